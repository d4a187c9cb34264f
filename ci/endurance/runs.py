"""Do the runs that are asked for, one after the other, and report what each of them found."""

import argparse
import dataclasses
import pathlib
import signal
import sys
import tempfile
import traceback
from typing import Callable, ContextManager, Dict, Generic, List, Sequence, TypeVar

from ..benchmark import machine
from .checks import Check, all_kept, table, write_json
from .surroundings import logs

#: What a run is given.
Given = TypeVar("Given")


@dataclasses.dataclass(frozen=True)
class Run(Generic[Given]):
    """One thing to find out."""

    name: str
    help: str
    run: Callable[[Given], List[Check]]


def parser_of(command: str, runs: Sequence[Run[Given]]) -> argparse.ArgumentParser:
    """Return a parser with the options that every command with runs has.

    :param command: how it is called; its own comment has the help
    """
    parser = argparse.ArgumentParser(prog=command)
    names = [one.name for one in runs]
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    return parser


def carry_out(
    command: str,
    runs: Sequence[Run[Given]],
    options: argparse.Namespace,
    surroundings: Callable[[pathlib.Path], ContextManager[Given]],
) -> int:
    """Do the runs, each in surroundings of its own, and print the table of checks.

    :param surroundings: makes them, with a fresh directory for logs and files
    :returns: exit status: 0 if every bound was kept, 130 at Ctrl-C
    """
    # A shell has what it runs in the background ignore Ctrl-C, and that would be inherited.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    facts = machine.describe()
    if machine.is_busy():
        print(f"{command}: this machine is not idle (load {facts['load before']})", file=sys.stderr)
    results: Dict[str, List[Check]] = {}
    try:
        for one in runs:
            if options.only and one.name not in options.only:
                continue
            print(f"{command}: {one.name}: {one.help}", file=sys.stderr, flush=True)
            results[one.name] = attempt(one, surroundings)
            if options.json:
                write_json(options.json, results, facts)
    except KeyboardInterrupt:
        return 130  # everything has been cleaned up on the way here
    print(table(results))
    print(f"\nload before: {facts['load before']}")
    return 0 if all_kept(results) else 1


def attempt(
    one: Run[Given], surroundings: Callable[[pathlib.Path], ContextManager[Given]]
) -> List[Check]:
    """Do one run; a failure of the run itself is a bound not kept."""
    with tempfile.TemporaryDirectory(prefix="runs-") as name:
        directory = pathlib.Path(name)
        with surroundings(directory) as given:
            try:
                return one.run(given)
            except Exception as error:
                traceback.print_exc()
                print("\n".join(logs(directory))[-5000:], file=sys.stderr)
                return [Check("the run itself", "ends", repr(error), False)]
