"""Measure the workspace's nodes and their peers in turn. Called by ci/bench."""

import argparse
import gc
import pathlib
import signal
import sys
import tempfile
import time

from . import machine, report
from . import peer_programs as peers
from .context import Bench
from .measurements import MEASUREMENTS, chosen
from .processes import Session
from .results import Results
from .turns import LIMIT_S, Turns


def main() -> int:
    """Measure and report.

    :returns: exit status: 0 if everything could be measured, whatever it came to
    """
    options = arguments()
    wanted = chosen(options.only, options.all)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    began = time.monotonic()
    facts = machine.describe()
    if machine.is_busy():
        say(f"this machine is not idle (load {facts['load before']}): the figures will scatter")
    say("building the peers")
    built = peers.prepare(fetch=not options.quick)
    results = Results()
    steal = machine.Steal()
    with tempfile.TemporaryDirectory(prefix="bench-") as directory:
        with Session(pathlib.Path(directory)) as session:
            gc.disable()  # it would hold up the observer
            bench = Bench(session, built, options.quick)
            limit = None if options.all or options.only else LIMIT_S
            Turns(wanted, bench, results, options.repeats, say).take_all(limit)
    names = [one.name for one in wanted]
    facts["load after"] = machine.load()
    facts["taken by the host"] = f"{100.0 * steal.share():.1f} % of the time"
    facts["duration"] = f"{time.monotonic() - began:.0f} s"
    print(report.tables(results, names, facts, built.left_out))
    if options.json:
        report.write_json(options.json, results, facts, built.left_out)
    if options.plot:
        from . import plot  # matplotlib takes half a second and tens of megabytes

        plot.draw(options.plot, results)
    return 1 if results.failures else 0


def arguments() -> argparse.Namespace:
    """Read the command line."""
    names = [one.name for one in MEASUREMENTS]
    parser = argparse.ArgumentParser(prog="ci/bench")  # which has the help
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME")
    parser.add_argument("--repeats", type=int, metavar="N")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--plot", type=pathlib.Path, metavar="FILE")
    options = parser.parse_args()
    if options.quick and options.repeats is None:
        options.repeats = 1
    if options.repeats is not None and options.repeats < 1:
        parser.error("--repeats: at least 1")
    return options


def say(text: str) -> None:
    """Tell what is going on."""
    print("ci/bench: " + text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
