"""Run the nodes for long and trouble them meanwhile. Called by ci/soak."""

import argparse
import pathlib
import signal
import sys
import tempfile
import traceback
from typing import Dict, List

import machine
from checks import Check, all_kept, table, write_json
from processes import Session
from runs import RUNS, Run
from surroundings import Soak


def main() -> int:
    """Run what is asked for, and report.

    :returns: exit status: 0 if every bound was kept
    """
    options = arguments()
    # A shell has what it runs in the background ignore Ctrl-C, and that would be inherited.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    chosen = [one for one in RUNS if not options.only or one.name in options.only]
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    facts = machine.describe()
    if machine.is_busy():
        say(f"this machine is not idle (load {facts['load before']})")
    results: Dict[str, List[Check]] = {}
    for one in chosen:
        say(f"{one.name}: {one.help}")
        results[one.name] = attempt(one, options)
        if options.json:
            write_json(options.json, results, facts)
    print(table(results))
    print(f"\nload before: {facts['load before']}")
    return 0 if all_kept(results) else 1


def attempt(one: Run, options: argparse.Namespace) -> List[Check]:
    """Do one run on a master of its own; a failure of the run itself is a bound not kept."""
    with tempfile.TemporaryDirectory(prefix="soak-") as directory:
        with Session(pathlib.Path(directory)) as session:
            soak = Soak(session, 60.0 * options.minutes, options.times, options.seed)
            try:
                return one.run(soak)
            except Exception as error:
                traceback.print_exc()
                return [Check("the run itself", "ends", repr(error), False)]


def arguments() -> argparse.Namespace:
    """Read the command line."""
    listed = "\n".join(f"  {one.name:10} {one.help}" for one in RUNS)
    parser = argparse.ArgumentParser(
        prog="ci/soak",
        description="Run the nodes for long and trouble them meanwhile.",
        epilog="runs:\n" + listed,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    names = [one.name for one in RUNS]
    parser.add_argument("--minutes", type=float, default=10.0, help="of recording; 10 by default")
    parser.add_argument("--times", type=int, default=0, help="kills (50), interrupts (100)")
    parser.add_argument("--seed", type=int, default=1, help="of everything random; 1 by default")
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME", help="only these")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures")
    options = parser.parse_args()
    if options.minutes <= 0.0 or options.times < 0:
        parser.error("--minutes and --times: more than 0")
    return options


def say(text: str) -> None:
    """Tell what is going on."""
    print("ci/soak: " + text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)  # everything has been cleaned up on the way here
