"""Measure the workspace's nodes and their peers in turn. Called by ci/bench."""

import argparse
import gc
import pathlib
import signal
import sys
import tempfile
import time
from typing import List

import machine
import peers
import report
from context import Bench
from goals import GOALS
from measurements import MEASUREMENTS, Measurement, chosen
from processes import Session
from results import Results

#: No repeat begins that would end later than this, s.
LIMIT = 540.0


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
            measure(wanted, Bench(session, built, options.quick), options.repeats, results)
    names = [one.name for one in wanted]
    facts["load after"] = machine.load()
    facts["taken by the host"] = f"{100.0 * steal.share():.1f} % of the time"
    facts["duration"] = f"{time.monotonic() - began:.0f} s"
    print(report.tables(results, names, facts, built.left_out))
    if options.json:
        report.write_json(options.json, results, facts, built.left_out)
    if options.plot:
        import plot  # matplotlib takes half a second and tens of megabytes

        plot.draw(options.plot, results)
    return 1 if results.failures else 0


def arguments() -> argparse.Namespace:
    """Read the command line."""
    names = [one.name for one in MEASUREMENTS]
    listed = "\n".join(
        f"  {one.name:14} {one.help}{', with --all' if one.is_extreme else ''}"
        for one in MEASUREMENTS
    )
    parser = argparse.ArgumentParser(
        prog="ci/bench",
        description="Measure the workspace's nodes and their peers in turn.",
        epilog="measurements:\n" + listed,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="an overview in a minute")
    parser.add_argument("--all", action="store_true", help="also those that few need")
    parser.add_argument("--only", nargs="+", choices=names, metavar="NAME", help="only these")
    parser.add_argument("--repeats", type=int, metavar="N", help="at most; 12 unless given")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures")
    parser.add_argument("--plot", type=pathlib.Path, metavar="FILE", help="draw, .svg or .png")
    options = parser.parse_args()
    if options.repeats is None:
        options.repeats = 1 if options.quick else 12
    if options.repeats < 1:
        parser.error("--repeats: at least 1")
    return options


def measure(wanted: List[Measurement], bench: Bench, repeats: int, results: Results) -> None:
    """Run all measurements, each repeat all subjects in turn, until more would say little."""
    began = latest = time.monotonic()
    for repeat in range(repeats):
        now = time.monotonic()
        if now - began + (now - latest) > LIMIT:
            say(f"that took long: stopping after {repeat} repeats")
            return
        latest = now
        for measurement in wanted:
            disturbed = results.disturbed[measurement.name]
            if repeat >= measurement.repeats + disturbed or is_settled(measurement, results):
                continue
            for subject in rotated(measurement.subjects, repeat):
                if subject in bench.peers.left_out:
                    continue
                if subject in measurement.slow and (bench.quick or repeat > 0):
                    continue
                if repeat == 0 and measurement.warm_up:
                    run(measurement, bench._replace(quick=True), subject, -1, Results())
                run(measurement, bench, subject, repeat, results)


def is_settled(measurement: Measurement, results: Results) -> bool:
    """Tell whether more turns of a measurement would say little more of any of its goals."""
    goals = [goal for goal in GOALS if goal.measurement == measurement.name]
    verdicts = [verdict for verdict in (goal.judge(results) for goal in goals) if verdict]
    return bool(verdicts) and all(verdict.is_settled for verdict in verdicts)


def run(
    measurement: Measurement, bench: Bench, subject: str, repeat: int, results: Results
) -> None:
    """Run one measurement of one subject; a failure is reported and ends nothing else.

    Nothing comes of a turn in which the host took much of the processors' time.
    """
    what = f"{measurement.name}, {subject}"
    say(f"{what}, repeat {repeat + 1}" if repeat >= 0 else f"{what}, warm-up")
    steal = machine.Steal()
    try:
        figures = measurement.measure(bench, subject)
        if steal.share() <= machine.STOLEN:
            results.add(measurement.name, subject, repeat, figures)
        else:
            results.disturbed[measurement.name] += 1
            say(f"{what}: left out, as the host took {100.0 * steal.share():.1f} % of the time")
    except (LookupError, OSError, RuntimeError, ValueError) as error:
        results.failures.append(f"{what}: {error!r}")
        say(results.failures[-1])
    gc.collect()


def rotated(subjects: List[str], repeat: int) -> List[str]:
    """Return the subjects, another one first in each repeat."""
    first = repeat % len(subjects)
    return subjects[first:] + subjects[:first]


def say(text: str) -> None:
    """Tell what is going on."""
    print("ci/bench: " + text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
