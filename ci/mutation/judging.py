"""What the tests of a package say of a mutant: its unit tests, then its integration tests."""

import concurrent.futures
import dataclasses
import json
import os
import pathlib
import shutil
import tempfile
import zlib
from typing import Dict, Iterator, List, NamedTuple, Sequence
from xml.etree import ElementTree

from ..lint import code_rules
from ..tiers import tiers
from ..tiers.steps import Runner, Step, StepResult
from . import pure_modules as mutants
from .nearest import UnitTests

#: How much longer than without a mutant a test may take, and what it gets on top, s.
LONGER, ON_TOP_S = 3.0, 30.0
#: How much of a reason is kept, characters; and of what a test without failures writes, words.
MOST_SHOWN, LAST_WORDS = 200, 20
#: How many files of unit tests are run before the others.
NEAREST = 3
#: Has a rostest end with the first test that fails; see nodekit.testing.running.
FAIL_FAST = "NODEKIT_TESTS_FAIL_FAST"
#: Its tests need ROS 2, which ci/ros2 brings.
BRIDGE = "ros2_bridge"


class Trial(NamedTuple):
    """A test without a mutant."""

    #: Of its files: a test that has changed is tried anew.
    digest: int
    #: Why it failed; empty if it passes.
    trouble: str
    seconds: float
    #: What its processes import of the copy, as paths below src.
    modules: Sequence[str]


class Judge:
    """Runs tests on the copy, one at a time.

    :param place: a folder for what is found out about the tests
    """

    def __init__(self, place: pathlib.Path) -> None:
        self._units = UnitTests()
        self._file = place / "tests.json"
        self._trials: Dict[str, Trial] = {}
        if self._file.exists():
            known = {name: Trial(*it) for name, it in json.loads(self._file.read_text()).items()}
            # What failed has another chance in each run.
            self._trials = {name: trial for name, trial in known.items() if not trial.trouble}
        self._compiled = place / "compiled"
        self._runner = Runner()
        self._pool = concurrent.futures.ThreadPoolExecutor(1)

    def killer(self, module: str, text: str) -> str:
        """Put a text into a module of the copy, and run the tests that meet it.

        :param module: its path below src
        :returns: the first test that fails or does not end in time, and why; empty if none does
        :raises mutants.Unfit: if ROS 2 is needed, and cannot be had
        """
        copy = mutants.COPY / "src" / module
        original = copy.read_text("utf-8")
        for step in self.tests_of(module):
            try:
                self._write(copy, text)
                result = self._run_twice(step, self._compiled)
            finally:
                self._write(copy, original)
            if not result.good:
                return f"{step.name}: {trouble_of(result)}"
        return ""

    def tests_of(self, module: str) -> Iterator[Step]:
        """Return what meets a module: the unit tests, then the others by their time.

        Each is tried without a mutant before it is returned, so what kills early spares that of the
        long ones. One that fails then is left out.

        :raises mutants.Unfit: if ROS 2 is needed, and cannot be had
        """
        package = module.split("/")[0]
        nearest = self._units.of(code_rules.SOURCES / module)
        if nearest:
            # What they take in all bounds what some of them take.
            whole = self._trial(unit_step(package, self._units.all_of(package)))
            # Most die by the nearest; collecting the others takes longer than running those.
            for tests in (nearest[:NEAREST], nearest[NEAREST:]):
                if tests and not whole.trouble:
                    yield limited(unit_step(package, tests), whole)
        for step in sorted(integration_steps(package), key=self._expected_s):
            trial = self._trial(step)
            if module in trial.modules and not trial.trouble:
                yield limited(step, trial)

    def _expected_s(self, step: Step) -> float:
        """Return what a test took, or where that is not known the most that it may take, s."""
        known = self._trials.get(step.name)
        return known.seconds if known else step.time_limit

    def close(self) -> None:
        """Remove what the tests have left behind."""
        self._pool.shutdown()
        shutil.rmtree(str(self._compiled), ignore_errors=True)

    def left_out(self) -> List[str]:
        """Return the tests that fail without a mutant, and why."""
        trials = sorted(self._trials.items())
        return [f"{name}: {trial.trouble}" for name, trial in trials if trial.trouble]

    def _trial(self, step: Step) -> Trial:
        """Run a test without a mutant, unless that has been done."""
        digest = digest_of(step)
        known = self._trials.get(step.name)
        if known and known.digest == digest:
            return known
        if step.tier == "ros2":
            made = self._run(tiers.ros2()[0], self._compiled)
            if not made.good:
                raise mutants.Unfit(f"{BRIDGE} is tested with ROS 2: {made.log.strip()}")
        with tempfile.TemporaryDirectory(prefix="mutants-") as compiled:
            result = self._run_twice(step, pathlib.Path(compiled))
            sources = pathlib.Path(compiled + str(mutants.COPY / "src"))
            modules = sorted(
                str(path.relative_to(sources).with_name(path.name.split(".")[0] + ".py"))
                for path in sources.rglob("*.pyc")
            )
        self._trials[step.name] = Trial(digest, trouble_of(result), result.seconds, modules)
        self._file.write_text(json.dumps(self._trials))
        return self._trials[step.name]

    def _run_twice(self, step: Step, compiled: pathlib.Path) -> StepResult:
        """Run a test, and once more if it fails: on a busy machine one may fail by the way."""
        result = self._run(step, compiled)
        return result if result.good else self._run(step, compiled)

    def _run(self, step: Step, compiled: pathlib.Path) -> StepResult:
        """Run a test to its end, or, at Ctrl-C, end it."""
        os.environ.update({"PYTHONPYCACHEPREFIX": str(compiled), FAIL_FAST: "1"})
        directory = pathlib.Path(tempfile.mkdtemp(prefix="mutants-"))
        running = self._pool.submit(self._runner.run, step, directory / "run")
        try:
            return running.result()
        except BaseException:
            self._runner.interrupt()
            concurrent.futures.wait([running])
            raise
        finally:
            shutil.rmtree(str(directory), ignore_errors=True)

    def _write(self, copy: pathlib.Path, text: str) -> None:
        copy.write_text(text, "utf-8")
        # Python tells by length and second alone whether what it has compiled is of this text.
        compiled = pathlib.Path(str(self._compiled) + str(copy.parent))
        for path in compiled.glob(f"{copy.stem}.*.pyc"):
            path.unlink()


def trouble_of(result: StepResult) -> str:
    """Return in a few words why a test failed; nothing if it did not."""
    if result.good:
        return ""
    reasons = result.failures or [" ".join(result.log.split()[-LAST_WORDS:])]
    return reasons[0][:MOST_SHOWN]


def limited(step: Step, trial: Trial) -> Step:
    """Return a test with the time that it has with a mutant."""
    limit = min(step.time_limit, LONGER * trial.seconds + ON_TOP_S)
    return dataclasses.replace(step, time_limit=limit)


def unit_step(package: str, tests: Sequence[pathlib.Path]) -> Step:
    """Return the run of some unit tests, in their order, up to the first that fails."""
    step = tiers.pytest_step("unit", f"{package}/unit", tests[0])
    command = [*step.command, *map(str, tests[1:]), "-x"]
    return dataclasses.replace(step, command=command)


def integration_steps(package: str) -> List[Step]:
    """Return the tests of a package that need a master."""
    steps = [step for step in tiers.integration() if step.name.startswith(package + "/")]
    if package != BRIDGE:
        return steps
    # They have a PYTHONPATH of their own, which is to begin with the copy as well.
    copies = os.pathsep.join(str(place) for place in (mutants.COPY / "src").glob("*/src"))
    for step in tiers.ros2()[1:]:
        command = [
            word.replace("PYTHONPATH=", f"PYTHONPATH={copies}{os.pathsep}", 1)
            for word in step.command
        ]
        name = f"{package}/{step.name}"
        steps.append(dataclasses.replace(step, name=name, command=[*command, "-x"]))
    return steps


def digest_of(step: Step) -> int:
    """Return a figure of the files that a test consists of; its helpers are not looked at."""
    files = [pathlib.Path(word) for word in step.command if word.endswith((".py", ".test"))]
    for file in list(files):
        if file.suffix == ".test":
            nodes = ElementTree.parse(str(file)).getroot().iter("test")
            files += [file.parent / node.get("type", "") for node in nodes]
    # What a test starts may also be a program of the package.
    return zlib.crc32(b"".join(file.read_bytes() for file in files if file.is_file()))
