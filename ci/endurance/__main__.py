"""Run the nodes for long, with faults. Called by ci/soak and ci/two-hosts.

Usage: python3 ci endurance soak|two-hosts [OPTION…]
"""

import argparse
import contextlib
import importlib
import pathlib
import signal
import sys
import tempfile
import traceback
from typing import Any, Iterator, List

from ..benchmark import machine, report
from ..benchmark.processes import Session
from .checks import Check, Results, all_kept, as_json, table
from .context import Soak
from .hosts import Hosts
from .names import COMMANDS


def main(command: str, arguments: List[str]) -> int:
    """Carry out the selected runs, and print the table of checks.

    :returns: exit status: 0 if every bound was kept, 130 at Ctrl-C
    """
    options = parse(command, arguments)
    # A shell lets background processes ignore Ctrl-C, and that would be inherited.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    facts = machine.describe()
    if machine.is_busy():
        print(f"this machine is not idle (load {facts['load before']})", file=sys.stderr)
    results: Results = {}
    try:
        for name in options.only or COMMANDS[command]:
            print(f"{name}: {COMMANDS[command][name]}", file=sys.stderr, flush=True)
            results[name] = attempt(name, options)
            if options.json:
                report.write_json(options.json, as_json(results, facts))
    except KeyboardInterrupt:
        return 130  # everything has been cleaned up
    print(table(results))
    print(f"\nload before: {facts['load before']}")
    return 0 if all_kept(results) else 1


def parse(command: str, arguments: List[str]) -> argparse.Namespace:
    """Return the options; the command has their help."""
    parser = argparse.ArgumentParser(prog=f"ci/{command}")
    parser.add_argument("--only", nargs="+", choices=list(COMMANDS[command]), metavar="NAME")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    if command == "soak":
        parser.add_argument("--minutes", type=float, default=10.0)
        parser.add_argument("--times", type=int, default=50)
        parser.add_argument("--seed", type=int, default=1)
    else:
        parser.add_argument("--outage", type=float, default=20.0)
    options = parser.parse_args(arguments)
    for name in {"minutes", "times", "outage"}.intersection(vars(options)):
        if getattr(options, name) <= 0:
            parser.error(f"--{name}: more than 0")
    return options


@contextlib.contextmanager
def _context(directory: pathlib.Path, options: argparse.Namespace) -> Iterator[Any]:
    if "outage" in options:
        with Hosts(directory, options.outage) as hosts:
            yield hosts
    else:
        with Session(directory) as session:
            yield Soak(session, 60.0 * options.minutes, options.times, options.seed)


def attempt(name: str, options: argparse.Namespace) -> List[Check]:
    """Carry out one run; its failure is reported as a broken bound."""
    with tempfile.TemporaryDirectory(prefix="runs-") as directory:
        with _context(pathlib.Path(directory), options) as context:
            try:
                module: Any = importlib.import_module(f".run_{name}", __package__)
                checks: List[Check] = module.run(context)
                return checks
            except Exception as error:
                traceback.print_exc()
                for log in sorted(pathlib.Path(directory).glob("*.log")):
                    print(f"{log.name}: {log.read_text()[-1000:]}", file=sys.stderr)
                return [Check("the run itself", "ends", repr(error), False)]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
