"""Command ``timeline``: picture of the calls of each thread, from a demo's log."""

import argparse
import os
import sys
from typing import Dict, List, NoReturn

from executors_demo.bars import Bar, bars
from nodekit.package_version import ShowVersion
from executors_demo.events import read

#: Stands for standard input.
STDIN = "-"
_FORMATS = ("svg", "png")


class NoLines(Exception):
    """A log without anything to draw; the text names it."""


def main() -> None:
    """Draw when each callback ran, and on which thread."""
    arguments = _parser().parse_args()
    try:
        _write(arguments.output, {log: _bars(log) for log in arguments.logs or [STDIN]})
    except NoLines as error:
        _fail(str(error))
    except ModuleNotFoundError as error:
        _fail(f"{error.name} is not installed: apt install python3-{error.name}")
    except OSError as error:
        _fail(f"{error.filename or arguments.output}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)  # the shell's convention for SIGINT


def _fail(text: str) -> NoReturn:
    print(f"timeline: {text}", file=sys.stderr)
    sys.exit(2)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="timeline",
        description="Draw which callback of a demo ran when, and on which thread.",
        epilog="Several logs are drawn one below the other, over the same time.",
    )
    parser.add_argument("--version", action=ShowVersion, package="executors_demo")
    parser.add_argument(
        "logs",
        metavar="LOG",
        nargs="*",
        help="output of a demo; - or none for standard input",
    )
    parser.add_argument(
        "-o", "--output", required=True, type=_output, help="file to write: .svg or .png"
    )
    return parser


def _output(text: str) -> str:
    if _format(text) not in _FORMATS:
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .svg or .png")
    return text


def _format(path: str) -> str:
    return os.path.splitext(path)[1][1:].lower()


def _bars(log: str) -> List[Bar]:
    if log == STDIN:
        made = bars(read(sys.stdin))
    else:
        with open(log, errors="replace") as file:
            made = bars(read(file))
    if not made:
        raise NoLines(f"{log}: no line about the start or end of a call")
    return made


def _write(path: str, runs: Dict[str, List[Bar]]) -> None:
    # Matplotlib takes a second to load, which errors should not wait for.
    from executors_demo.picture import Panel, draw, save

    panels = [Panel(_title(log), made) for log, made in runs.items()]
    # The file is renamed when it is complete.
    partial = path + ".part"
    try:
        save(draw(panels), partial, _format(path))
        os.replace(partial, path)
    finally:
        if os.path.exists(partial):
            os.remove(partial)


def _title(log: str) -> str:
    return "" if log == STDIN else os.path.splitext(os.path.basename(log))[0]
