"""Run the tests that may detect a mutant: unit tests, then integration tests."""

import dataclasses
import itertools
import os
import pathlib
import re
import shutil
import signal
import sys
import tempfile
import time
from typing import Dict, Iterator, List, NamedTuple, Sequence, Set
from xml.etree import ElementTree

from ..tiers.steps import Runner, Step
from ..tiers.workspace import WORKSPACE
from .mutants import SOURCES, Unfit
from .nearest import unit_tests

GENERATED = WORKSPACE / "devel" / "lib" / "python3" / "dist-packages"
DEBIAN = "/usr/lib/python3/dist-packages"
#: Factor by which a test may take longer than without a mutant, and additional time [s].
LONGER, ON_TOP_S = 3.0, 20.0
#: Number of unit test files that are run first.
NEAREST = 3
#: Makes a rostest end at the first failing test; see nodekit.testing.running.
FAIL_FAST = "NODEKIT_TESTS_FAIL_FAST"
#: Import in test modules that open the oscilloscope's page.
BROWSER = re.compile(r"^from browsing\.(browser|\w+_test) import", re.MULTILINE)
#: For pytest: the tests of a mutant need not find the simplest failing example.
CONFTEST = """
from hypothesis import Phase, settings
phases = [Phase.explicit, Phase.generate]
settings.register_profile("once", derandomize=True, deadline=None, phases=phases)
settings.load_profile("once")
"""


class Trial(NamedTuple):
    """A run of a test without a mutant."""

    #: Why it failed; empty if it passed.
    trouble: str
    seconds: float
    #: The modules of the copy that its processes imported, as paths below src.
    modules: Set[str]


class Evaluation:
    """Runner of tests on a copy of the sources, one at a time.

    :param place: a folder for the copy
    :param integration: whether the integration tests are run too
    """

    def __init__(self, place: pathlib.Path, integration: bool) -> None:
        self._copy, self._compiled = place / "copy" / "src", place / "compiled"
        self._integration = integration
        self._trials: Dict[str, Trial] = {}
        self._moments = itertools.count(int(time.time()))
        self._runner, self._is_interrupted = Runner(), False
        copy_sources(self._copy)
        # Scripts in devel use the first for imports, the second to find the page.
        places = os.pathsep.join(map(str, self._copy.glob("*/src")))
        for name, first in (("PYTHONPATH", places), ("ROS_PACKAGE_PATH", str(self._copy))):
            os.environ[name] = first + os.pathsep + os.environ.get(name, "")
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._interrupt)

    def _interrupt(self, *_: object) -> None:
        self._is_interrupted = True
        self._runner.interrupt()

    def close(self) -> None:
        """Remove the copy."""
        for folder in (self._copy.parent, self._compiled):
            shutil.rmtree(str(folder), ignore_errors=True)

    def killer(self, module: str, text: str) -> str:
        """Return the first test that fails with a text in a module, and why; empty if none does.

        :param module: its path below src
        :raises KeyboardInterrupt: at Ctrl-C, after the test has ended
        :raises Unfit: if ROS 2 is needed and missing
        """
        copy = self._copy / module
        original = copy.read_text("utf-8")
        for step in self.tests_of(module):
            try:
                self._write(copy, text)
                trouble = self._trouble(step, self._compiled)
            finally:
                self._write(copy, original)
            if trouble:
                return f"{step.name}: {trouble}"
        return ""

    def _write(self, copy: pathlib.Path, text: str) -> None:
        copy.write_text(text, "utf-8")
        # Python identifies a compiled module by its length and modification time in seconds.
        os.utime(str(copy), (0, next(self._moments)))

    def tests_of(self, module: str) -> Iterator[Step]:
        """Return the tests that import a module: unit tests, then the others by their time.

        Each test is run without a mutant first, when needed, and omitted if it fails then.

        :param module: its path below src
        :raises Unfit: if ROS 2 is needed and missing
        """
        package, is_script = self._copy / module.split("/")[0], module.endswith(".js")
        units = unit_tests(package, module)
        parts = [part for part in (units[:NEAREST], units[NEAREST:]) if part]
        steps = [
            pytest_step("unit", f"{package.name}/unit", part, sys.executable) for part in parts
        ]
        if self._integration:
            known = {name: trial.seconds for name, trial in self._trials.items()}
            others = [
                one for one in integration_steps(package) if not is_script or one.tier == "page"
            ]
            steps += sorted(others, key=lambda step: known.get(step.name, step.time_limit))
        for step in steps:
            trial = self._trial(step)
            is_met = step.tier == "unit" or is_script or module in trial.modules
            if is_met and not trial.trouble:
                limit = min(step.time_limit, LONGER * trial.seconds + ON_TOP_S)
                yield dataclasses.replace(step, time_limit=limit)

    def left_out(self) -> List[str]:
        """Return the tests that fail without a mutant, and why."""
        return [f"{name}: {trial.trouble}" for name, trial in self._trials.items() if trial.trouble]

    def _trial(self, step: Step) -> Trial:
        """Run a test without a mutant, unless that has been done."""
        if step.name not in self._trials:
            if step.tier == "ros2":
                setup = Step("unit", "ros2", [f"{WORKSPACE}/ci/ros2"], 1800.0)
                if self._trouble(setup, self._compiled):
                    raise Unfit(f"{step.name} needs ROS 2, which ci/ros2 cannot set up")
            with tempfile.TemporaryDirectory(prefix="mutants-") as compiled:
                began = time.monotonic()
                trouble = self._trouble(step, pathlib.Path(compiled))
                seconds = time.monotonic() - began
                sources = pathlib.Path(compiled + str(self._copy))
                paths = [path.relative_to(sources) for path in sources.rglob("*.pyc")]
            modules = {str(path.with_name(path.name.split(".")[0] + ".py")) for path in paths}
            self._trials[step.name] = Trial(trouble, seconds, modules)
        return self._trials[step.name]

    def _trouble(self, step: Step, compiled: pathlib.Path) -> str:
        """Run a test, and return why it failed; empty if it passed.

        On a busy machine a test that needs a master may fail by chance: it is repeated once.
        """
        os.environ.update({"PYTHONPYCACHEPREFIX": str(compiled), FAIL_FAST: "1"})
        for _ in range(1 if step.tier == "unit" else 2):
            directory = pathlib.Path(tempfile.mkdtemp(prefix="mutants-"))
            result = self._runner.run(step, directory / "run")
            shutil.rmtree(str(directory), ignore_errors=True)
            if self._is_interrupted:
                raise KeyboardInterrupt
            if result.good:
                return ""
        failed = [
            f"{case.name}: {case.reason}" for case in result.cases if case.outcome == "failed"
        ]
        return [*failed, "it was skipped"][0][:200]


def copy_sources(copy: pathlib.Path) -> None:
    """Copy the folder src, including generated modules."""
    shutil.rmtree(str(copy.parent), ignore_errors=True)
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(str(SOURCES), str(copy), symlinks=True, ignore=ignored)
    for place in [*GENERATED.glob("*/msg"), *GENERATED.glob("*/srv")]:
        library = copy / place.parent.name / "src" / place.parent.name
        if library.is_dir():
            shutil.copytree(str(place), str(library / place.name))
    (copy.parent / "conftest.py").write_text(CONFTEST)


def pytest_step(tier: str, name: str, tests: Sequence[pathlib.Path], *python: str) -> Step:
    """Return the run of some test files, in their order, up to the first failing test."""
    command = [*python, "-m", "pytest", "-p", "no:cacheprovider", "--tb=short", "-x"]
    command += ["--junitxml={results}/pytest.xml", *map(str, tests)]
    return Step(tier, " ".join([name, *(test.stem for test in tests)]), command, 600.0, True)


def integration_steps(package: pathlib.Path) -> List[Step]:
    """Return the tests of a package in the copy that need a master; some open the page.

    Each test node has its own file, because rostest runs all test nodes of a file to their end.
    """
    steps = []
    for file in sorted((package / "test").glob("*/*.test")):
        for index in range(len(ElementTree.parse(str(file)).findall(".//test"))):
            tree = ElementTree.parse(str(file))
            test = tree.findall(".//test")[index]
            for parent in list(tree.iter()):
                for other in [child for child in parent.findall("test") if child is not test]:
                    parent.remove(other)
            part = file.with_name(f"{file.stem}.{index}.part")
            tree.write(str(part))
            command = ["rostest", "--pkgdir", str(package), "--package", package.name]
            command += ["--results-base-dir", "{results}", "--results-filename", "it.xml"]
            name = f"{package.name}/{file.stem} {test.get('test-name')}"
            script = file.with_name(test.get("type", ""))
            text = script.read_text("utf-8") if script.is_file() else ""
            tier = "page" if BROWSER.search(text) else "integration"
            limit = float(test.get("time-limit", "60")) + 60.0
            steps.append(Step(tier, name, [*command, str(part)], limit, True))
    path = os.pathsep.join([*map(str, package.parent.glob("*/src")), str(GENERATED), DEBIAN])
    python = ("env", f"PYTHONPATH={path}", f"{WORKSPACE}/build/ros2/bin/python")
    tests = sorted((package / "test" / "ros2").glob("test_*.py"))
    return [*steps, *(pytest_step("ros2", package.name, [test], *python) for test in tests)]
