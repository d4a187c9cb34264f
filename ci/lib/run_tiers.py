"""Run the tiers of tests named on the command line, two steps at a time, and sum up."""

import concurrent.futures
import pathlib
import shutil
import signal
import sys
import tempfile
import time
from typing import List

import tiers
from steps import Outcome, Runner, Step

# Most integration tests wait most of the time.
AT_A_TIME = 2
# Of the output of a failed step.
LINES_SHOWN = 200


def run_steps(steps: List[Step], directory: pathlib.Path) -> List[Outcome]:
    """Run steps in their order, and report each when it ends."""
    outcomes = []
    runner = Runner()
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        running: List["concurrent.futures.Future[Outcome]"] = []
        try:
            for number, step in enumerate(steps):
                running.append(pool.submit(runner.run, step, directory / ("%03d" % number)))
            for future in concurrent.futures.as_completed(running):
                outcome = future.result()
                outcomes.append(outcome)
                report(outcome)
        except BaseException:
            for future in running:
                future.cancel()
            runner.interrupt()
            raise
    return outcomes


def report(outcome: Outcome) -> None:
    """Print a line about a step, and the end of its output if it failed."""
    print(
        "%-6s %s/%s: %s, %.1f s"
        % (
            "ok" if outcome.good else "FAILED",
            outcome.step.tier,
            outcome.step.name,
            numbers(outcome.passed, outcome.failed, outcome.skipped),
            outcome.seconds,
        ),
        flush=True,
    )
    if not outcome.good:
        lines = outcome.log.splitlines()
        for line in lines[-LINES_SHOWN:]:
            print("    " + line, flush=True)


def numbers(passed: int, failed: int, skipped: int) -> str:
    return "%d passed, %d failed, %d skipped" % (passed, failed, skipped)


def summarise(names: List[str], outcomes: List[Outcome], seconds: float) -> bool:
    """Print the table and the closing line.

    :returns: whether everything is well
    """
    row = "%-12s %7s %7s %8s %9s"
    print("\n" + row % ("tier", "passed", "failed", "skipped", "seconds"))
    total = [0, 0, 0]
    for name in names:
        mine = [outcome for outcome in outcomes if outcome.step.tier == name]
        tally = [
            sum(outcome.passed for outcome in mine),
            # A tier without a test proves nothing.
            sum(outcome.failed for outcome in mine) if mine else 1,
            sum(outcome.skipped for outcome in mine),
        ]
        seconds_of_tier = "%.1f" % sum(outcome.seconds for outcome in mine)
        print(row % (name, *tally, seconds_of_tier) + ("" if mine else "  no test ran"))
        total = [one + other for one, other in zip(total, tally)]
    print("%.0f s in all, %d steps at a time\n" % (seconds, AT_A_TIME))
    print(numbers(*total))
    return total[1] == 0 and total[2] == 0


def main(names: List[str]) -> int:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    began = time.monotonic()
    directory = pathlib.Path(tempfile.mkdtemp(prefix="ci-test-"))
    try:
        steps = [step for name in names for step in tiers.TIERS[name]()]
        outcomes = run_steps(steps, directory)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    finally:
        shutil.rmtree(str(directory), ignore_errors=True)
    return 0 if summarise(names, outcomes, time.monotonic() - began) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
