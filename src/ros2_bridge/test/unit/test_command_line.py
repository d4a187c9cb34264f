"""Installation of the official command line, from repositories created by the test."""

import concurrent.futures
import fcntl
import pathlib
import re
import subprocess
from typing import List

import pytest

from nodekit.testing.waiting import wait_until
from ros2_bridge.environment import command_line
from ros2_bridge.environment.command_line import SOURCES, Source
from ros2_bridge.environment.python_environment import PythonEnvironment, Unavailable


@pytest.fixture
def source(tmp_path: pathlib.Path) -> Source:
    """Create a repository with a release and a newer commit."""
    place = tmp_path / "repository"

    def git(*arguments: str) -> str:
        who = ["-c", "user.name=we", "-c", "user.email=we@example.org"]
        done = subprocess.run(
            ["git", "-C", str(place), *who, *arguments], check=True, stdout=subprocess.PIPE
        )
        return done.stdout.decode().strip()

    (place / "ros2cli").mkdir(parents=True)
    (place / "ros2cli" / "setup.py").write_text("")
    git("init", "--quiet")
    git("add", ".")
    git("commit", "--quiet", "--message", "release")
    commit = git("rev-parse", "HEAD")
    (place / "ros2cli" / "setup.py").write_text("raise SystemExit('newer')\n")
    git("commit", "--quiet", "--all", "--message", "newer")
    return Source(f"file://{place}", commit, ("ros2cli",))


@pytest.fixture
def environment(tmp_path: pathlib.Path) -> PythonEnvironment:
    """Create an environment whose Python records its arguments and rejects the newer commit."""
    made = PythonEnvironment(tmp_path / "ros2")
    made.python.parent.mkdir(parents=True)
    made.python.write_text(
        f'#!/bin/sh\necho "$@" >>{tmp_path / "calls"}\n'
        "for last; do :; done\n"
        'if [ -s "$last/setup.py" ]; then echo "error: a newer commit"; exit 1; fi\n'
    )
    made.python.chmod(0o755)
    (tmp_path / "ros2_twins").mkdir()
    (tmp_path / "wheels.txt").write_text("psutil==1.0 --hash=sha256:0\n")
    return made


def calls(tmp_path: pathlib.Path) -> List[str]:
    """Return the arguments of each call of the environment's Python."""
    path = tmp_path / "calls"
    return path.read_text().splitlines() if path.exists() else []


def test_release_is_installed_once(
    tmp_path: pathlib.Path, source: Source, environment: PythonEnvironment
) -> None:
    for _ in range(2):
        command_line.install(environment, tmp_path / "wheels.txt", [source])
    wheels, packages = calls(tmp_path)
    assert wheels.endswith(f"--require-hashes --requirement {tmp_path / 'wheels.txt'}")
    assert "--no-build-isolation" in packages and packages.endswith("/ros2cli")
    newer = tmp_path / "wheels.txt"
    newer.write_text("psutil==1.1 --hash=sha256:0\n")
    command_line.install(environment, newer, [source])
    assert len(calls(tmp_path)) == 4
    command_line.install(environment, newer, [source, source])
    assert calls(tmp_path)[-1].count("/ros2cli") == 2
    with pytest.raises(Unavailable, match="ros2 cannot be fetched"):
        command_line.install(environment, newer, [source, source._replace(commit="0" * 40)])


def test_installation_waits_for_another_command(
    tmp_path: pathlib.Path,
    source: Source,
    environment: PythonEnvironment,
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    shown: List[str] = []
    with concurrent.futures.ThreadPoolExecutor() as pool:
        with (tmp_path / "ros2_twins" / "lock").open("w") as held:  # as any release holds it
            fcntl.flock(held, fcntl.LOCK_EX)
            later = pool.submit(
                command_line.install, environment, tmp_path / "wheels.txt", [source]
            )
            wait_until(
                lambda: shown.append(capsys.readouterr().err) or "waiting" in "".join(shown),
                lambda: str(shown),
            )
            assert calls(tmp_path) == []
        later.result()
    assert len(calls(tmp_path)) == 2


def test_missing_repository_is_named(
    tmp_path: pathlib.Path, environment: PythonEnvironment
) -> None:
    gone = Source(f"file://{tmp_path / 'gone'}", "0" * 40, (".",))
    with pytest.raises(Unavailable, match=f"ros2 cannot be fetched from {gone.url}: fatal: "):
        command_line.install(environment, tmp_path / "wheels.txt", [gone])
    assert calls(tmp_path) == []


def test_failed_installation_is_retried(
    tmp_path: pathlib.Path, source: Source, environment: PythonEnvironment
) -> None:
    good = environment.python.read_text()
    environment.python.write_text("#!/bin/sh\necho ERROR: no space\nexit 1\n")
    with pytest.raises(Unavailable, match="ros2 cannot be installed: ERROR: no space"):
        command_line.install(environment, tmp_path / "wheels.txt", [source])
    environment.python.write_text(good)
    command_line.install(environment, tmp_path / "wheels.txt", [source])
    assert len(calls(tmp_path)) == 2


def test_commits_are_full_hashes() -> None:
    assert all(len(source.commit) == 40 for source in SOURCES)


def test_repositories_and_commands_are_those_that_the_page_names() -> None:
    page = (pathlib.Path(__file__).resolve().parents[4] / "docs" / "ros2_bridge.md").read_text(
        "utf-8"
    )
    (versions,) = re.findall(
        r"the official command line of Jazzy .*?:(.*?) from GitHub", page, re.S
    )
    assert {source.url.rpartition("/")[2] for source in SOURCES} == {
        *re.findall(r"(\w+) \d", versions)
    }
    (listed,) = re.findall(r"The commands are (.*?)\.", page, re.S)
    commands = {*re.findall("`([a-z]+)`", listed)} - {"daemon"}  # which is of ros2cli
    packages = {package for source in SOURCES for package in source.packages}
    assert packages == {".", "ros2cli", *(f"ros2{command}" for command in commands)}
