"""Run the tiers of tests named on the command line, three steps at a time, and sum up."""

import concurrent.futures
import pathlib
import queue
import shutil
import signal
import sys
import tempfile
import time
from typing import List, Optional

from . import tiers
from .steps import Runner, Step, StepResult

# More than most machines' cores: most integration tests wait most of the time.
AT_A_TIME = 3
# How long a signal may stay unseen, s.
LOOK_S = 1.0
# Of the output of a failed step.
LINES_SHOWN = 200
# The steps that the end names, those that take most of the processors.
STEPS_SHOWN = 8


def run_steps(steps: List[Step], directory: pathlib.Path) -> List[StepResult]:
    """Run steps in their order, and report each when it ends.

    A step that has to be after another one takes its place behind all when that has ended; if that
    went wrong, it is not run, and has failed.

    :raises KeyboardInterrupt: at SIGINT and SIGTERM, once nothing runs any more
    """
    results: List[StepResult] = []
    runner = Runner()
    # An exception raised by a signal could leave a lock of the pool locked for ever. This
    # queue's put() may be called from a handler.
    ended: "queue.SimpleQueue[Optional[concurrent.futures.Future[StepResult]]]" = (
        queue.SimpleQueue()
    )
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.put(None))
    waiting = [step for step in steps if step.after]
    running: "List[concurrent.futures.Future[StepResult]]" = []
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:

        def begin(step: Step) -> None:
            place = directory / f"{len(running):03}"
            running.append(pool.submit(runner.run, step, place))
            running[-1].add_done_callback(ended.put)

        try:
            for step in steps:
                if not step.after:
                    begin(step)
            while len(results) < len(steps):
                try:
                    # Not for ever: one that comes just before this begins to wait wakes nobody.
                    first = ended.get(timeout=LOOK_S)
                except queue.Empty:
                    continue
                if first is None:
                    raise KeyboardInterrupt
                result = first.result()
                results.append(result)
                report(result)
                for step in [one for one in waiting if follows(one, result.step)]:
                    if result.good:
                        begin(step)
                    else:
                        why = f"not run: {step.after} has failed"
                        results.append(StepResult(step, 0, 1, 0, 0.0, 0.0, why))
                        report(results[-1])
        except BaseException:
            for future in running:
                future.cancel()
            runner.interrupt()
            raise
    return results


def follows(step: Step, other: Step) -> bool:
    """Tell whether a step has to be after another one."""
    return (step.tier, step.after) == (other.tier, other.name)


def report(result: StepResult) -> None:
    """Print a line about a step, and the end of its output if it failed."""
    print(
        f"{'ok' if result.good else 'FAILED':6} "
        f"{result.step.tier}/{result.step.name}: "
        f"{numbers(result.passed, result.failed, result.skipped)}, "
        f"{result.seconds:.1f} s, of processors {result.cpu_seconds:.1f} s",
        flush=True,
    )
    for failure in result.failures:
        print(f"  failed: {failure}", flush=True)
    if not result.good:
        lines = result.log.splitlines()
        for line in lines[-LINES_SHOWN:]:
            print("    " + line, flush=True)


def numbers(passed: int, failed: int, skipped: int) -> str:
    return f"{passed} passed, {failed} failed, {skipped} skipped"


def summarise(names: List[str], results: List[StepResult], seconds: float) -> bool:
    """Print the table and the closing line.

    :returns: whether everything is well
    """
    row = "%-12s %7s %7s %8s %9s %11s"
    print("\n" + row % ("tier", "passed", "failed", "skipped", "seconds", "processor s"))
    total = [0, 0, 0]
    for name in names:
        mine = [result for result in results if result.step.tier == name]
        tally = [
            sum(result.passed for result in mine),
            # A tier without a test proves nothing.
            sum(result.failed for result in mine) if mine else 1,
            sum(result.skipped for result in mine),
        ]
        times = f"{sum(result.seconds for result in mine):.1f}", f"{cpu_seconds(mine):.1f}"
        print(row % (name, *tally, *times) + ("" if mine else "  no test ran"))
        total = [one + other for one, other in zip(total, tally)]
    dearest = sorted(results, key=lambda result: -result.cpu_seconds)[:STEPS_SHOWN]
    print("most of the processors went to:")
    for result in dearest:
        print(f"  {result.cpu_seconds:6.1f} s  {result.step.tier}/{result.step.name}")
    print(
        f"{seconds:.0f} s in all, {AT_A_TIME} steps at a time, "
        f"{cpu_seconds(results) / 60:.1f} minutes of processor time\n"
    )
    print(numbers(*total))
    return total[1] == 0 and total[2] == 0


def cpu_seconds(results: List[StepResult]) -> float:
    """The processor time of some steps, s."""
    return sum(result.cpu_seconds for result in results)


def main(names: List[str]) -> int:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # A shell that starts this in the background has it ignored, and so would all that is tested.
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    began = time.monotonic()
    directory = pathlib.Path(tempfile.mkdtemp(prefix="ci-test-"))
    try:
        results = run_steps(tiers.steps_of(names), directory)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    finally:
        shutil.rmtree(str(directory), ignore_errors=True)
    return 0 if summarise(names, results, time.monotonic() - began) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
