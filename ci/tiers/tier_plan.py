"""Plan of the steps of each test tier."""

import dataclasses
import pathlib
import sys
from typing import Callable, Dict, List, Optional, Set
from xml.etree import ElementTree

from .selection import Selection, UnknownWord
from .steps import Step
from .times import Times
from .workspace import CI, DOCS, SOURCES, WORKSPACE, files_of, packages, runs_with, scripts

#: The formatter and linter, and the check of spelling, which ci/test fetches from PyPI.
RUFF = str(WORKSPACE / "build" / "lint" / "bin" / "ruff")
CODESPELL = str(WORKSPACE / "build" / "lint" / "bin" / "codespell")
#: Package that catkin must not find.
TEMPLATE = SOURCES / "nodekit" / "template" / "package_name"
#: Folders of ci/tests with tests that build whole workspaces, in separate tiers.
SPACES = CI / "tests" / "spaces"
#: Test files of a package are run by several steps if they take longer than this [s].
LANE_S = 60.0
#: Largest number of such steps of a package's rostest files.
LANES = 3
#: Largest number of steps of the tests with ROS 2, which mostly wait.
ROS2_LANES = 4
#: Marker of unit tests that belong to the tier of this name, and its form in a file.
EXTENDED = "extended"
MARK = f"pytest.mark.{EXTENDED}"
#: Assumed duration of a test file that has not been run yet [s].
UNKNOWN_S = 10.0
#: Step that creates the environment in which tests with ROS 2 run.
ENVIRONMENT = Step("ros2", "environment", [str(CI / "ros2")], time_limit=1800.0)


def python_files(*places: pathlib.Path) -> List[str]:
    """Return the Python files of the project or of some folders, scripts without a suffix too."""
    return [
        str(path)
        for path in files_of(*(places or (CI, DOCS, SOURCES, WORKSPACE / "conftest.py")))
        if path.suffix == ".py" or (not path.suffix and runs_with("python", path))
    ]


def lint(scope: Optional[Set[str]] = None) -> List[Step]:
    """Return the steps of static checks.

    :param scope: names of packages, and ``ci``; everything unless given
    """
    chosen = [package for package in packages() if scope is None or package.name in scope]
    with_ci = scope is None or "ci" in scope
    files = python_files(*chosen, *([CI] if with_ci else [])) if scope else python_files()
    libraries = [package / "src" for package in chosen if (package / "src").is_dir()]
    types = [*([str(CI)] if with_ci else []), *map(str, libraries)]
    folders = [str(package / "launch") for package in chosen if (package / "launch").is_dir()]
    if scope is None or "nodekit" in scope:
        types.append(str(TEMPLATE / "src"))
        chosen.append(TEMPLATE)
    if scope is None:
        types.append(str(DOCS / "tests"))
    path = ":".join(map(str, [DOCS / "tests", *(package / "src" for package in packages())]))
    ci = [sys.executable, str(CI)]
    commands = {
        "format": [RUFF, "format", "--check", "--diff", "--quiet", *files],
        "style": [RUFF, "check", "--quiet", *files],
        "types": ["env", f"MYPYPATH={path}", "mypy", "--cache-dir", f"{WORKSPACE}/build/mypy"]
        + ["--exclude", "(^|/)(peers|ci/tests)/", *types],
        "code rules": [*ci, "lint.code_rules"],
        "language": [*ci, "lint.language"],
        "vacuous tests": [*ci, "lint.vacuous_tests"],
    }
    if chosen:
        commands["packages"] = ["catkin_lint", "-W2", "--strict", *map(str, chosen)]
    if folders:
        commands["launch files"] = [*ci, "lint.launch_files", *folders]
    if scope is None or "topic_scope" in scope:
        commands["page rules"] = [*ci, "lint.page_rules"]
    if with_ci:
        texts = [*map(str, sorted(WORKSPACE.glob("*.md"))), str(CI), str(DOCS), str(SOURCES)]
        commands["spelling"] = [CODESPELL, "--toml", str(WORKSPACE / "pyproject.toml"), *texts]
        commands["rosdep keys"] = [*ci, "lint.rosdep_keys"]
        commands["debian files"] = [*ci, "packages.debian_files"]
        commands["shell scripts"] = ["shellcheck", "-x", "-a"]
        commands["shell scripts"] += ["-P", f"{CI}:{CI}/setup:{CI}/systems", *scripts("bash", CI)]
    of = f" of {', '.join(sorted(scope))}" if scope else ""
    return [Step("lint", name + of, command, 900.0) for name, command in commands.items()]


def docs(since: str = "") -> List[Step]:
    """Return the steps that build the pages and type their commands.

    :param since: a commit, to type only the pages that have changed since
    """
    target = str(DOCS / "_build" / "html")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    command += ["-d", str(WORKSPACE / "build" / "doctrees"), str(DOCS), target]
    steps = [Step("docs", "html", command)]
    for marked, alone in ("not real_time", False), ("real_time", True):
        typed = pytest_step("docs", f"commands, {marked.replace('_', ' ')}", DOCS / "tests")
        typed.command.extend(["-m", marked])
        if since:
            typed.command.append(f"--pages-changed-since={since}")
        steps.append(dataclasses.replace(typed, time_limit=1800.0, alone=alone))
    return steps


def ci_tests() -> List[Step]:
    """Return the steps that test ci, one per folder."""
    folders = sorted(path for path in (CI / "tests").iterdir() if (path / "__init__.py").exists())
    return [
        pytest_step("ci", folder.name, folder)
        for folder in folders
        if folder != SPACES and any(folder.glob("test_*.py"))
    ]


def unit(names: Optional[Set[str]] = None) -> List[Step]:
    """Return the steps that run the unit tests of some packages, or of all."""
    steps = []
    for package in packages():
        folder = package / "test" / "unit"
        if (names is None or package.name in names) and folder.is_dir():
            steps.append(pytest_step("unit", package.name, folder))
            steps[-1].command.extend(["-m", f"not {EXTENDED}"])
    return steps


def extended(names: Optional[Set[str]], times: Times) -> List[Step]:
    """Return the steps that run rostest files of ``test/extended``, and unit tests marked so."""
    steps = rostest_steps("extended", names, times)
    for package in packages():
        files = sorted((package / "test" / "unit").glob("test_*.py"))
        marked = [file for file in files if MARK in file.read_text("utf-8")]
        if marked and (names is None or package.name in names):
            steps.append(pytest_step("extended", f"{package.name}, unit", *marked))
            steps[-1].command.extend(["-m", EXTENDED])
    return steps


def install() -> List[Step]:
    """Return the steps that build other types of workspaces, or install from this one."""
    names = {
        "user's workspace": ["test_own_workspace.py", "test_install_space.py"],
        "new package": ["test_new_package.py"],
        "without rostest": ["test_without_rostest.py"],
    }
    return [
        pytest_step("install", name, *(SPACES / file for file in files))
        for name, files in names.items()
    ]


def catkin_build() -> List[Step]:
    """Return the step that builds with catkin build."""
    return [pytest_step("catkin_build", "catkin build", SPACES / "test_catkin_build.py")]


def pytest_step(
    tier: str, name: str, *places: pathlib.Path, test: str = "", time_limit: float = 600.0
) -> Step:
    """Return the step that runs pytest on files or folders, or on one test of a file."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--tb=short"]
    command += ["--junitxml={results}/pytest.xml"]
    command += [f"{place}::{test}" if test else str(place) for place in places]
    return Step(tier, name, command, time_limit, True, repeat="{module}::{case}")


def rostest_steps(tier: str, names: Optional[Set[str]], times: Times) -> List[Step]:
    """Return the steps that run the rostest files of some packages, or of all.

    :param tier: ``integration`` or ``extended``, also the folder's name
    :param names: names of the packages
    :param times: times of earlier runs
    """
    steps = []
    for package in packages():
        files = sorted((package / "test" / tier).glob("*.test"))
        if files and (names is None or package.name in names):
            lanes = share_out(files, times)
            for number, lane in enumerate(lanes, 1):
                suffix = f" {number}/{len(lanes)}" if len(lanes) > 1 else ""
                steps.append(rostest_step(tier, package.name + suffix, lane))
    return steps


def share_out(
    files: List[pathlib.Path], times: Times, most: int = LANES
) -> List[List[pathlib.Path]]:
    """Divide files among the fewest steps that each take less than LANE_S, the longest first.

    :param files: test files
    :param times: times of earlier runs
    :param most: largest number of steps
    """
    known = {file: times.wall(str(file.relative_to(WORKSPACE)), UNKNOWN_S) for file in files}
    count = min(most, len(files), 1 + int(sum(known.values()) / LANE_S))
    lanes: List[List[pathlib.Path]] = [[] for _ in range(count)]
    for file in sorted(files, key=lambda one: (-known[one], one)):
        min(lanes, key=lambda lane: sum(known[one] for one in lane)).append(file)
    return lanes


def rostest_step(tier: str, name: str, files: List[pathlib.Path], test: str = "") -> Step:
    """Return the step that runs rostest files on one master."""
    command = [sys.executable, str(CI), "tiers.shared_master", "--results", "{results}"]
    command += [*(["--test", test] if test else []), *map(str, files)]
    limit = sum(map(declared_time, files)) + 60.0 * len(files)
    folder = files[0].parent.relative_to(WORKSPACE)
    return Step(tier, name, command, limit, True, repeat=f"{folder}/{{file}}.test::{{case}}")


def declared_time(test: pathlib.Path) -> float:
    """Return the sum of the time limits of a rostest file's test nodes [s]."""
    nodes = ElementTree.parse(str(test)).getroot().iter("test")
    return sum(float(node.get("time-limit", "60")) for node in nodes)


def ros2(names: Optional[Set[str]], times: Times) -> List[Step]:
    """Return the steps that create an environment with ROS 2, and test the bridge in it.

    Tests of ROS 2 recordings need PyPI, but not this environment. Tests marked ``extended`` belong
    to the whole tier.

    :param names: selected packages; None for the whole tier
    :param times: times of earlier runs
    """
    steps = [ENVIRONMENT]
    files = sorted(SOURCES.glob("*/test/ros2/test_*.py"))
    lanes = share_out(files, times, ROS2_LANES)
    for number, lane in enumerate(lanes, 1):
        name = f"clients {number}/{len(lanes)}"
        steps.append(ros2_step(*lane, name=name, after=ENVIRONMENT.name))
        if names is not None:
            steps[-1].command.extend(["-m", f"not {EXTENDED}"])
    places = sorted(SOURCES.glob("*/test/recordings"))
    return [*steps, pytest_step("ros2", "recordings", *places)]


def ros2_step(*places: pathlib.Path, test: str = "", name: str = "", after: str = "") -> Step:
    """Return the step that runs tests with ROS 2.

    They run with the Python of build/ros2, with pytest and rospy from Debian's folder.

    :param places: test files
    :param test: the only test of the file to run
    :param name: name of the step, if not the first file's
    :param after: the step that must run first
    """
    debian = "/usr/lib/python3/dist-packages"
    path = f"PYTHONPATH={WORKSPACE / 'devel' / 'lib' / 'python3' / 'dist-packages'}:{debian}"
    step = pytest_step("ros2", name or places[0].stem, *places, test=test, time_limit=1200.0)
    python = str(WORKSPACE / "build" / "ros2" / "bin" / "python")
    command = ["env", path, python, *step.command[1:]]
    return dataclasses.replace(step, command=command, after=after)


def single(place: pathlib.Path, test: str) -> List[Step]:
    """Return the step that runs one test file, or one test in it, and what that step needs.

    :raises UnknownWord: if it is not a test file
    """
    folder = place.parent.name
    if place.suffix == ".py" and folder in ("integration", "extended"):
        for file in sorted(place.parent.glob("*.test")):
            if f'"{place.name}"' in file.read_text("utf-8"):
                return [rostest_step(folder, file.stem, [file], test)]
    elif place.suffix == ".test":
        return [rostest_step(folder, place.stem, [place], test)]
    elif folder == "ros2":
        return [ENVIRONMENT, ros2_step(place, test=test, after=ENVIRONMENT.name)]
    elif place.suffix == ".py" and place.name.startswith("test_"):
        return [pytest_step("unit", place.stem, place, test=test)]
    raise UnknownWord(f"'{place}' is not a test file, or no .test file names it")


def plan(chosen: Selection, times: Times) -> List[Step]:
    """Return the selected steps, each once: the longest first, those that run alone last.

    :raises UnknownWord: if a place is not a test file
    """
    steps: List[Step] = []
    for tier in dict.fromkeys([*chosen.whole, *chosen.packages]):
        names = None if tier in chosen.whole else chosen.packages[tier]
        steps += steps_of(tier, names, times, chosen.pages_since)
    for place, test in chosen.places:
        steps += single(place, test)
    unique = list({(step.title, tuple(step.command)): step for step in steps}.values())

    def wall(step: Step) -> float:
        return times.wall(step.title, step.time_limit / 20.0)

    def urgency(step: Step) -> float:
        """Return the duration of a step and of the steps that depend on it [s]."""
        after = [one for one in unique if (one.tier, one.after) == (step.tier, step.name)]
        return wall(step) + sum(map(wall, after))

    return sorted(unique, key=lambda step: (step.alone, -urgency(step)))


def steps_of(tier: str, names: Optional[Set[str]], times: Times, since: str = "") -> List[Step]:
    """Return the steps of a tier, of all or of some packages."""
    makers: Dict[str, Callable[[], List[Step]]] = {
        "lint": lambda: lint(names),
        "docs": lambda: docs(since),
        "ci": ci_tests,
        "unit": lambda: unit(names),
        "install": install,
        "catkin_build": catkin_build,
        "integration": lambda: rostest_steps(tier, names, times),
        "extended": lambda: extended(names, times),
        "ros2": lambda: ros2(names, times),
    }
    return makers[tier]()
