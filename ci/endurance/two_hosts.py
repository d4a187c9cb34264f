"""Launch on two hosts, pull the cable between them, look from one into the other.

Called by ci/two-hosts.
"""

import argparse
import pathlib
import signal
import sys
import tempfile
import traceback
from typing import Callable, Dict, List, NamedTuple

import machine
import run_cable
import run_closed
from checks import Check, all_kept, table, write_json
from hosts import Hosts


class Run(NamedTuple):
    """Something to find out with two hosts."""

    name: str
    help: str
    run: Callable[[Hosts, float], List[Check]]


RUNS = [
    Run("cable", "cw1_two_hosts.launch, and the cable pulled for a while", run_cable.run),
    Run(
        "closed", "what another host can reach of nodes that were not to be reached", run_closed.run
    ),
]


def main() -> int:
    """Run what is asked for, and report.

    :returns: exit status: 0 if every bound was kept
    """
    options = arguments()
    # A shell has what it runs in the background ignore Ctrl-C, and that would be inherited.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    facts = machine.describe()
    results: Dict[str, List[Check]] = {}
    for one in RUNS:
        if options.only and one.name not in options.only:
            continue
        print(f"ci/two-hosts: {one.name}: {one.help}", file=sys.stderr, flush=True)
        results[one.name] = attempt(one, options.outage)
        if options.json:
            write_json(options.json, results, facts)
    print(table(results))
    print(f"\nload before: {facts['load before']}")
    return 0 if all_kept(results) else 1


def attempt(one: Run, seconds: float) -> List[Check]:
    """Do one run on hosts of its own; a failure of the run itself is a bound not kept."""
    with tempfile.TemporaryDirectory(prefix="two-hosts-") as directory:
        with Hosts(pathlib.Path(directory)) as hosts:
            try:
                return one.run(hosts, seconds)
            except Exception as error:
                traceback.print_exc()
                print(hosts.logs()[-5000:], file=sys.stderr)
                return [Check("the run itself", "ends", repr(error), False)]


def arguments() -> argparse.Namespace:
    """Read the command line."""
    listed = "\n".join(f"  {one.name:10} {one.help}" for one in RUNS)
    parser = argparse.ArgumentParser(
        prog="ci/two-hosts",
        description="Make two hosts of this machine, and try the network between them.",
        epilog="runs:\n" + listed,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    names = [one.name for one in RUNS]
    parser.add_argument("--outage", type=float, default=20.0, help="s; 20 by default")
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME", help="only these")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures")
    options = parser.parse_args()
    if options.outage <= 0.0:
        parser.error("--outage: more than 0")
    return options


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)  # everything has been cleaned up on the way here
