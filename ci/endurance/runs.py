"""Frame of the long runs: carries out those selected, and reports what each of them found."""

import argparse
import pathlib
import signal
import sys
import tempfile
import traceback
from typing import Callable, ContextManager, Dict, List, TypeVar

from ..benchmark import machine, report
from .checks import Check, Results, all_kept, as_json, table

#: Context of a run.
Context = TypeVar("Context")


def make_parser(command: str, names: Dict[str, str]) -> argparse.ArgumentParser:
    """Return a parser with the options that all commands with runs have.

    :param command: which has their help
    """
    parser = argparse.ArgumentParser(prog=command)
    parser.add_argument("--only", nargs="+", choices=list(names), metavar="NAME")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    return parser


def carry_out(
    options: argparse.Namespace,
    names: Dict[str, str],
    runs: Dict[str, Callable[[Context], List[Check]]],
    make_context: Callable[[pathlib.Path], ContextManager[Context]],
) -> int:
    """Carry out runs, each in a context of its own, and print the table of checks.

    :param names: what each run does
    :param make_context: given an empty directory for logs and files
    :returns: exit status: 0 if every bound was kept, 130 at Ctrl-C
    """
    # A shell lets background processes ignore Ctrl-C, and that would be inherited.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    facts = machine.describe()
    if machine.is_busy():
        print(f"this machine is not idle (load {facts['load before']})", file=sys.stderr)
    results: Results = {}
    try:
        for name in options.only or runs:
            print(f"{name}: {names[name]}", file=sys.stderr, flush=True)
            results[name] = attempt(runs[name], make_context)
            if options.json:
                report.write_json(options.json, as_json(results, facts))
    except KeyboardInterrupt:
        return 130  # everything has been cleaned up on the way here
    print(table(results))
    print(f"\nload before: {facts['load before']}")
    return 0 if all_kept(results) else 1


def attempt(
    run: Callable[[Context], List[Check]],
    make_context: Callable[[pathlib.Path], ContextManager[Context]],
) -> List[Check]:
    """Carry out one run; its failure is a bound that is not kept."""
    with tempfile.TemporaryDirectory(prefix="runs-") as directory:
        with make_context(pathlib.Path(directory)) as context:
            try:
                return run(context)
            except Exception as error:
                traceback.print_exc()
                for log in sorted(pathlib.Path(directory).glob("*.log")):
                    print(f"{log.name}: {log.read_text()[-1000:]}", file=sys.stderr)
                return [Check("the run itself", "ends", repr(error), False)]
