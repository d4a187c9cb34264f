"""The command ``ci/test``: choose tests, run several steps at a time, and sum up."""

import argparse
import concurrent.futures
import contextlib
import os
import pathlib
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from typing import Callable, Dict, Iterator, List, Optional, Tuple

from tqdm import tqdm

from . import tier_plan
from .selection import DEFAULT, TIERS, Selection, UnknownWord, of_change
from .steps import Runner, Step, StepResult, repeat_command
from .times import Times, estimate
from .workspace import WORKSPACE, UnknownCommit, changed_files, dependencies, packages

#: More than most machines' cores: most integration tests wait most of the time. With three, the
#: whole run takes a fifth longer on two cores.
AT_A_TIME = 4
#: Examples that hypothesis tries of a property if no arguments are given; see conftest.py.
QUICK_EXAMPLES = "20"
#: Longest time until a signal is noticed [s].
POLL_S = 1.0
#: Lines of the output of a failed step that are shown.
LINES_SHOWN = 200
#: Number of steps in the final list of the longest by processor time.
STEPS_SHOWN = 8

Report = Callable[[StepResult], None]


def run_steps(steps: List[Step], directory: pathlib.Path, report: Report) -> List[StepResult]:
    """Run steps in their order, and report each when it ends.

    A step that depends on another step begins after it; if that step failed, it is not run, and
    counts as failed. A step marked ``alone`` runs without others.

    :raises KeyboardInterrupt: at SIGINT and SIGTERM, once nothing runs
    """
    results: List[StepResult] = []
    runner = Runner()
    # An exception raised by a signal could leave a lock of the pool locked forever. This
    # queue's put() may be called from a handler.
    ended: "queue.SimpleQueue[Optional[concurrent.futures.Future[StepResult]]]" = (
        queue.SimpleQueue()
    )
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.put(None))
    pending = list(steps)
    running: List[Step] = []

    def add(result: StepResult) -> None:
        results.append(result)
        report(result)

    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:

        def begin(step: Step) -> None:
            pending.remove(step)
            running.append(step)
            place = directory / f"{len(steps) - len(pending):03}"
            pool.submit(runner.run, step, place).add_done_callback(ended.put)

        try:
            while len(results) < len(steps):
                step = next_step(pending, running, results)
                if step is not None:
                    begin(step)
                    continue
                try:
                    # With a timeout: a signal just before the wait does not wake it.
                    first = ended.get(timeout=POLL_S)
                except queue.Empty:
                    continue
                if first is None:
                    raise KeyboardInterrupt
                result = first.result()
                running.remove(result.step)
                add(result)
                if not result.good:
                    for step in [one for one in pending if needs(one, result.step)]:
                        pending.remove(step)
                        add(StepResult(step, (), 0.0, 0.0, f"not run: {step.after} has failed"))
        except BaseException:
            runner.interrupt()
            raise
    return results


def next_step(
    pending: List[Step], running: List[Step], results: List[StepResult]
) -> Optional[Step]:
    """Return the step to begin now, None while all have to wait."""
    if len(running) == AT_A_TIME or any(step.alone for step in running):
        return None
    over = {(result.step.tier, result.step.name) for result in results}
    for step in pending:
        if (not step.alone or not running) and (not step.after or (step.tier, step.after) in over):
            return step
    return None


def needs(step: Step, other: Step) -> bool:
    """Return whether a step depends on another."""
    return (step.tier, step.after) == (other.tier, other.name)


class Reporter:
    """Reporter of finished steps, with a progress bar on a terminal.

    :param steps: the steps to come
    :param times: times of earlier runs
    """

    def __init__(self, steps: List[Step], times: Times) -> None:
        self._times = times
        self._bar = tqdm(
            total=sum(times.wall(step.title, tier_plan.UNKNOWN_S) for step in steps),
            bar_format="{percentage:3.0f} %|{bar}| {elapsed}, {remaining} left",
            disable=not sys.stderr.isatty(),
            leave=False,
        )

    def report(self, result: StepResult) -> None:
        """Print a line about a step, and why it failed."""
        self._bar.update(self._times.wall(result.step.title, tier_plan.UNKNOWN_S))
        lines = [
            f"{'ok' if result.good else 'FAILED':6} {result.step.title}: "
            f"{numbers(result.passed, failures(result), result.skipped)}, "
            f"{result.seconds:.1f} s, {result.cpu_seconds:.1f} s of processor time"
        ]
        lines += failed_cases(result)
        if not result.good:
            lines += ["    " + line for line in result.log.splitlines()[-LINES_SHOWN:]]
        for line in lines:
            self._bar.write(line, file=sys.stdout)
        sys.stdout.flush()

    def close(self) -> None:
        """Remove the bar."""
        self._bar.close()


def failed_cases(result: StepResult) -> List[str]:
    """Return two lines for each failed test: its reason, and the command that repeats it."""
    lines = []
    for case in result.cases:
        if case.outcome == "failed":
            lines.append(f"  failed: {': '.join(filter(None, (case.name, case.reason)))}")
            lines.append(f"    again: {repeat_command(result.step, case)}")
    return lines


def failures(result: StepResult) -> int:
    """Return how many tests of a step failed; a step that was not run counts as one."""
    return max(result.failed, int(not result.good and not result.skipped))


def numbers(passed: int, failed: int, skipped: int) -> str:
    """Return the closing line's form of three counts."""
    return f"{passed} passed, {failed} failed, {skipped} skipped"


def summarise(results: List[StepResult], seconds: float, times: Times) -> bool:
    """Print the table and the closing line.

    :param seconds: wall time of the run
    :param times: times of earlier runs
    :returns: whether all tests passed
    """
    row = "%-12s %7s %7s %8s %9s %11s"
    print("\n" + row % ("tier", "passed", "failed", "skipped", "seconds", "processor s"))
    total = [0, 0, 0]
    for name in TIERS:
        mine = [result for result in results if result.step.tier == name]
        if not mine:
            continue
        counts = [
            sum(result.passed for result in mine),
            sum(map(failures, mine)),
            sum(result.skipped for result in mine),
        ]
        spent = f"{sum(result.seconds for result in mine):.1f}", f"{cpu_seconds(mine):.1f}"
        print(row % (name, *counts, *spent))
        total = [one + other for one, other in zip(total, counts)]
    print("most of the processor time:")
    for result in sorted(results, key=lambda result: -result.cpu_seconds)[:STEPS_SHOWN]:
        print(f"  {result.cpu_seconds:6.1f} s  {result.step.title}")
    for result in results:
        title = result.step.title
        if times.has_grown(title, result.cpu_seconds):
            print(f"{title}: {result.cpu_seconds:.1f} s, usually {times.cpu(title):.1f} s")
    for result in results:
        if not result.good:
            print("\n".join([f"FAILED {result.step.title}", *failed_cases(result)]))
    print(
        f"{seconds:.0f} s in all, {AT_A_TIME} steps at a time, "
        f"{cpu_seconds(results) / 60:.1f} minutes of processor time\n"
    )
    print(numbers(*total))
    return total[0] > 0 and all(result.good for result in results)


def cpu_seconds(results: List[StepResult]) -> float:
    """Return the processor time of some steps [s]."""
    return sum(result.cpu_seconds for result in results)


def summarise_rounds(rounds: List[List[StepResult]]) -> bool:
    """Print which tests did not pass in every round.

    :returns: whether all did
    """
    passed: Dict[Tuple[str, str, str], int] = {}
    for results in rounds:
        for result in results:
            for case in result.cases:
                key = (result.step.title, case.class_name, case.name)
                passed[key] = passed.get(key, 0) + (case.outcome == "passed")
    unstable = {key: count for key, count in passed.items() if count < len(rounds)}
    for (title, class_name, name), count in sorted(unstable.items()):
        print(f"{count} of {len(rounds)}: {title}: {class_name}.{name}")
    print(f"{len(passed) - len(unstable)} of {len(passed)} tests passed {len(rounds)} times\n")
    print(numbers(len(passed) - len(unstable), len(unstable), 0))
    return bool(passed) and not unstable


@contextlib.contextmanager
def load(wanted: bool) -> Iterator[None]:
    """Keep each core busy during the block, if requested."""
    hog = [sys.executable, "-c", "while True: pass"]
    count = (os.cpu_count() or 1) if wanted else 0
    hogs = [subprocess.Popen(hog) for _ in range(count)]
    try:
        yield
    finally:
        for process in hogs:
            process.kill()
            process.wait()


def list_tests(times: Times) -> None:
    """Print tiers and packages, with their usual times."""
    row = "%-26s %9s %12s  %s"
    print(row % ("", "seconds", "processor s", ""))
    for tier, text in TIERS.items():
        steps = tier_plan.plan(Selection(whole=[tier]), times)
        print(row % (tier, *usual(steps, times), text))
    for package in packages():
        chosen = Selection()
        chosen.add_package(package.name)
        print(row % (package.name, *usual(tier_plan.plan(chosen, times), times), ""))
    print(f"\nWithout a word: {' '.join(DEFAULT)}. A dash: not run here yet.")


def list_steps(steps: List[Step], times: Times) -> None:
    """Print the steps that would run, with their usual times."""
    row = "%9s %12s  %s"
    print(row % ("seconds", "processor s", "step"))
    for step in steps:
        print(row % (*usual([step], times), step.title))
    print(f"\n{len(steps)} steps. A dash: not run here yet.")


def usual(steps: List[Step], times: Times) -> Tuple[str, str]:
    """Return wall and processor time of some steps, a dash for unknown values."""
    if not all(times.knows(step.title) for step in steps):
        return "-", "-"
    wall = estimate([times.wall(step.title) for step in steps], AT_A_TIME)
    return f"{wall:.0f}", f"{sum(times.cpu(step.title) for step in steps):.0f}"


def announce(steps: List[Step], times: Times, rounds: int) -> None:
    """Print the steps to run, and the estimated time."""
    counts: Dict[str, int] = {}
    for step in steps:
        counts[step.tier] = counts.get(step.tier, 0) + 1
    text = ", ".join(f"{tier} ({count})" for tier, count in counts.items())
    walls = [times.wall(step.title, tier_plan.UNKNOWN_S) for step in steps]
    seconds = rounds * estimate(walls, AT_A_TIME)
    known = sum(times.knows(step.title) for step in steps)
    how_long = f"about {seconds / 60:.1f} minutes" if known > len(steps) / 2 else "time unknown"
    times_each = f", {rounds} times" if rounds > 1 else ""
    print(f"ci/test: {len(steps)} steps{times_each}: {text}; {how_long}", flush=True)


def arguments(words: List[str]) -> argparse.Namespace:
    """Read the command line; ci/test has its help."""
    parser = argparse.ArgumentParser(prog="ci/test", add_help=False)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--changed", nargs="?", const="HEAD~1", metavar="COMMIT")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--repeat", type=int, default=1, metavar="N")
    parser.add_argument("--load", action="store_true")
    parser.add_argument("--without", nargs="*", default=[], metavar="TIER")
    options = parser.parse_args(words)
    if options.repeat < 1:
        parser.error(f"--repeat: at least 1 ({options.repeat})")
    return options


def choose(options: argparse.Namespace) -> Selection:
    """Return the selection of the command line.

    :raises UnknownWord: if a word is unknown
    :raises UnknownCommit: if git does not know the commit
    """
    if options.changed:
        needs_of = dependencies()
        chosen = of_change(changed_files(options.changed), needs_of, options.changed)
    else:
        chosen = Selection()
    if not options.words and not options.changed:
        chosen.whole.extend(DEFAULT)
        os.environ.setdefault("UNIT_TEST_EXAMPLES", QUICK_EXAMPLES)
    known = {package.name for package in packages()}
    for word in options.words:
        chosen.add_word(word, known, WORKSPACE)
    for tier in options.without:
        chosen.whole = [one for one in chosen.whole if one != tier]
        chosen.packages.pop(tier, None)
    return chosen


def main(words: List[str]) -> int:
    """Run the selected steps.

    :returns: exit status: 0 if every step ran tests and all passed
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # A shell ignores it in background jobs, which all tested processes would inherit.
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    options, times = arguments(words), Times()
    if options.list:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` ends it without a traceback
    if options.list and not options.words and not options.changed:
        list_tests(times)
        return 0
    try:
        steps = tier_plan.plan(choose(options), times)
    except (UnknownWord, UnknownCommit) as error:
        print(f"ci/test: {error}", file=sys.stderr)
        return 125
    if options.list:
        list_steps(steps, times)
        return 0
    if not steps:
        print("ci/test: nothing has changed that has tests\n\n0 passed, 0 failed, 0 skipped")
        return 0
    announce(steps, times, options.repeat)
    began = time.monotonic()
    directory = pathlib.Path(tempfile.mkdtemp(prefix="ci-test-"))
    reporter = Reporter(steps * options.repeat, times)
    rounds = []
    try:
        with load(options.load):
            for number in range(options.repeat):
                rounds.append(run_steps(steps, directory / str(number), reporter.report))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    finally:
        reporter.close()
        shutil.rmtree(str(directory), ignore_errors=True)
    if options.repeat > 1:
        return 0 if summarise_rounds(rounds) else 1
    good = summarise(rounds[0], time.monotonic() - began, times)
    if not options.load:
        note(rounds[0], times)
    return 0 if good else 1


def note(results: List[StepResult], times: Times) -> None:
    """Store the times of passed steps for the next run."""
    for result in results:
        if result.good:
            times.add(result.step.title, result.seconds, result.cpu_seconds)
            for place, seconds in result.places.items():
                times.add(place, seconds, 0.0)
    times.save()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
