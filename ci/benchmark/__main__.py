"""Measure the workspace's nodes and their peers in turn. Called by ci/bench."""

import argparse
import gc
import pathlib
import signal
import sys
import tempfile
import time
from typing import Dict, Set

from . import boards, machine, page, peer_programs, report
from .context import Bench
from .measurements import MEASUREMENTS, select
from .processes import Session
from .results import Results
from .runner import Runner

#: After this time, the main rows begin only first rounds [s].
LIMIT_S = 260.0


def main() -> int:
    """Measure and report.

    :returns: exit status: 0 if everything could be measured, whatever the figures
    """
    options = parse_arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    began, facts, steal = time.monotonic(), machine.describe(), machine.Steal()
    if machine.is_busy():
        say(f"this machine is not idle (load {facts['load before']}): the figures will scatter")
    results, wanted = Results(), select(options.only, options.all)
    left_out = prepare_peers({one.name for one in wanted}, options.quick)
    with tempfile.TemporaryDirectory(prefix="bench-") as directory:
        with Session(pathlib.Path(directory)) as session:
            gc.disable()  # it would hold up the observer
            runner = Runner(Bench(session, options.quick, left_out), results, options.rounds, say)
            runner.run(wanted, began + (LIMIT_S if not (options.all or options.only) else 1e6))
    facts["taken by the host"] = f"{100.0 * steal.share():.1f} % of the time"
    facts["duration"] = f"{time.monotonic() - began:.0f} s"
    print(report.tables(results, [one.name for one in wanted], facts, left_out))
    content = report.as_json(results, facts, left_out)
    if options.json:
        report.write_json(options.json, content)
    if options.page:
        report.write_json(options.page / "benchmark.json", {**content, "turns": []})
        page.write(options.page)
    return 1 if results.failures else 0


def prepare_peers(rows: Set[str], is_quick: bool) -> Dict[str, str]:
    """Build and generate what the peers of some rows need.

    :returns: the reason for each omitted peer, by its name
    """
    left_out: Dict[str, str] = {}
    if rows != {"serial"}:
        say("building the peers")
        left_out = peer_programs.prepare(fetch=not is_quick)
    if "serial" in rows:
        left_out.update(boards.prepare())
    return left_out


def parse_arguments() -> argparse.Namespace:
    """Return the options; ci/bench has their help."""
    parser = argparse.ArgumentParser(prog="ci/bench")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--all", action="store_true")
    names = [one.name for one in MEASUREMENTS]
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME")
    parser.add_argument("--rounds", type=int, metavar="N")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--page", type=pathlib.Path, metavar="FOLDER")
    options = parser.parse_args()
    if options.rounds is None and options.quick:
        options.rounds = 1
    if options.rounds is not None and options.rounds < 1:
        parser.error("--rounds: at least 1")
    return options


def say(text: str) -> None:
    """Report progress."""
    print("ci/bench: " + text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
