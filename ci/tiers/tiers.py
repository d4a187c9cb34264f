"""What each tier of tests consists of."""

import pathlib
import sys
from typing import Callable, Dict, List, Sequence
from xml.etree import ElementTree

from .steps import WORKSPACE, Step

SOURCES = WORKSPACE / "src"
CI = WORKSPACE / "ci"
# Directories of ci/tests that are not part of the unit tier.
TIERS_OF_THEIR_OWN = ("lint", "spaces")
#: Folders in which nothing is anybody's own.
GENERATED = ("_build", "__pycache__")


def packages() -> List[pathlib.Path]:
    """The directories of the workspace's packages."""
    return sorted(manifest.parent for manifest in SOURCES.glob("*/package.xml"))


def python_files() -> List[str]:
    """All Python files of the project, scripts without a suffix too."""
    files = []
    for place in ("ci", "docs", "src"):
        for path in sorted((WORKSPACE / place).rglob("*")):
            parts = path.parent.relative_to(WORKSPACE).parts
            generated = any(part in GENERATED or part.startswith(".") for part in parts)
            if path.is_file() and not generated:
                if path.suffix == ".py" or (not path.suffix and runs_with("python", path)):
                    files.append(str(path))
    return files


def shell_scripts() -> List[str]:
    """The scripts that are run; what these source is checked with them."""
    files = sorted(path for path in CI.rglob("*") if path.is_file())
    return [str(path) for path in files if runs_with("bash", path)]


def runs_with(language: str, path: pathlib.Path) -> bool:
    with path.open("rb") as file:
        line = file.readline(80)
    return line.startswith(b"#!") and language.encode() in line


def lint() -> List[Step]:
    files = python_files()
    libraries = [str(package / "src") for package in packages() if (package / "src").is_dir()]
    # A package too, but one that catkin is not to find.
    template = SOURCES / "nodekit" / "template" / "package_name"
    commands = {
        "catkin_lint": ["catkin_lint", "-W2", "--strict", str(SOURCES), str(template)],
        "flake8": ["flake8", "--config", str(WORKSPACE / ".flake8")] + files,
        "black": ["black", "--check", "--diff", "--quiet"] + files,
        "mypy": ["mypy", "--exclude", "/(peers|tests)/"]
        + [str(CI), *libraries, str(template / "src")],
        "code_rules": [sys.executable, str(CI), "lint.code_rules"],
        "page_rules": [sys.executable, str(CI), "lint.page_rules"],
        "launch files": [sys.executable, str(CI), "lint.launch_files"]
        + [str(package / "launch") for package in packages()],
        "empty_loops": [sys.executable, str(CI), "lint.empty_loops"],
        "rosdep_keys": [sys.executable, str(CI), "lint.rosdep_keys"],
        "debian_files": [sys.executable, str(CI), "packages.debian_files"],
        "shellcheck": ["shellcheck", "-x", "-a", "-P", f"{CI}:{CI}/setup:{CI}/systems"]
        + shell_scripts(),
    }
    steps = [Step("lint", name, command, 900.0) for name, command in commands.items()]
    return [*steps, pytest_step("lint", "what lint refuses", CI / "tests" / "lint")]


def docs() -> List[Step]:
    source, target = str(WORKSPACE / "docs"), str(WORKSPACE / "docs" / "_build" / "html")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    return [Step("docs", "html", command + ["-d", "{results}/doctrees", source, target])]


def unit() -> List[Step]:
    places = {package.name: package / "test" / "unit" for package in packages()}
    places.update(
        ("ci/" + place.name, place)
        for place in sorted((CI / "tests").iterdir())
        if place.name not in TIERS_OF_THEIR_OWN
    )
    return [pytest_step("unit", name, place) for name, place in places.items() if place.is_dir()]


def install() -> List[Step]:
    place = CI / "tests" / "spaces"
    return [
        pytest_step("install", "install", place / "test_install_space.py"),
        pytest_step("install", "own workspace", place / "test_own_workspace.py"),
        pytest_step("install", "new package", place / "test_new_package.py"),
        pytest_step("install", "without rostest", place / "test_without_rostest.py"),
    ]


def catkin_build() -> List[Step]:
    place = CI / "tests" / "spaces" / "test_catkin_build.py"
    return [pytest_step("catkin_build", "catkin build", place)]


def pytest_step(tier: str, name: str, place: pathlib.Path) -> Step:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--tb=short"]
    command += ["--junitxml={results}/pytest.xml", str(place)]
    return Step(tier, name, command, writes_junit=True, time_limit=600.0)


def integration() -> List[Step]:
    steps = []
    for package in packages():
        for test in sorted((package / "test" / "integration").glob("*.test")):
            command = ["rostest", "--pkgdir", str(package), "--package", package.name]
            command += ["--results-base-dir", "{results}"]
            command += ["--results-filename", test.stem + ".xml", str(test)]
            name, limit = f"{package.name}/{test.stem}", declared_time(test) + 60.0
            steps.append(Step("integration", name, command, limit, writes_junit=True))
    # The longest first, so that none of them runs alone at the end.
    return sorted(steps, key=lambda step: step.time_limit, reverse=True)


def declared_time(test: pathlib.Path) -> float:
    """The sum of the time limits of a rostest file's test nodes, s."""
    nodes = ElementTree.parse(str(test)).getroot().iter("test")
    return sum(float(node.get("time-limit", "60")) for node in nodes)


def ros2() -> List[Step]:
    environment = Step("ros2", "environment", [str(CI / "ros2")], time_limit=1800.0)
    # With the Python of build/ros2, which takes pytest, as it takes rospy, from Debian's folder.
    debian = "/usr/lib/python3/dist-packages"
    path = f"PYTHONPATH={WORKSPACE / 'devel' / 'lib' / 'python3' / 'dist-packages'}:{debian}"
    steps = [environment]
    for place in sorted(SOURCES.glob("*/test/ros2/test_*.py")):
        command = ["env", path, str(WORKSPACE / "build" / "ros2" / "bin" / "python")]
        command += ["-m", "pytest", "-p", "no:cacheprovider", "--tb=short"]
        command += ["--junitxml={results}/pytest.xml", str(place)]
        steps.append(Step("ros2", place.stem, command, 300.0, True, after=environment.name))
    return steps


TIERS: Dict[str, Callable[[], List[Step]]] = {
    "lint": lint,
    "docs": docs,
    "unit": unit,
    "install": install,
    "catkin_build": catkin_build,
    "integration": integration,
    "ros2": ros2,
}

#: A step that may take longer than this is begun before all others, s.
LONG_S = 1000.0


def steps_of(names: Sequence[str]) -> List[Step]:
    """Return the steps of some tiers, tier by tier; what takes longest by far comes first.

    :param names: of the tiers
    """
    steps = [step for name in names for step in TIERS[name]()]
    return sorted(steps, key=lambda step: step.time_limit <= LONG_S)
