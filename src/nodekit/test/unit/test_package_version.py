"""Tests of the version of a package, with real git repositories."""

import argparse
import pathlib
import subprocess
from typing import List

import pytest

from nodekit import package_version as version
from nodekit.package_version import ShowVersion, package_version

MANIFEST = """<package format="2"><name>{name}</name><version>1.2.3</version>
<description>d</description><maintainer email="a@b.cd">m</maintainer><license>BSD</license>
</package>
"""


@pytest.fixture
def package(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    """Package in a folder of its own, outside a repository."""
    folder = tmp_path / "sources" / "thermometer"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST.format(name="thermometer"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "sources"))
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    return folder


def git(folder: pathlib.Path, *arguments: str) -> str:
    named = ["-c", "user.name=a", "-c", "user.email=a@b.cd"]
    done = subprocess.check_output(["git", *named, *arguments], cwd=str(folder), timeout=30)
    return done.decode().strip()


def test_source_in_git_names_its_commit_and_changes(package: pathlib.Path) -> None:
    root = package.parent
    git(root, "init", "-q")
    git(root, "add", ".")
    git(root, "commit", "-qm", "x")
    commit = git(root, "rev-parse", "--short=7", "HEAD")
    (root / "notes.txt").write_text("outside the package")
    assert package_version("thermometer") == f"1.2.3, commit {commit}"
    (package / "node.py").write_text("")
    assert package_version("thermometer") == f"1.2.3, commit {commit}, with changes"


def test_ignored_folder_of_a_repository_has_no_commit(package: pathlib.Path) -> None:
    git(package.parent, "init", "-q")
    (package.parent / ".gitignore").write_text("/thermometer/\n")
    git(package.parent, "add", ".")
    git(package.parent, "commit", "-qm", "x")
    assert package_version("thermometer") == "1.2.3"


def test_debian_package_has_its_version(
    package: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: List[List[str]] = []

    def answer(command: List[str]) -> str:
        asked.append(command)
        if command[0] == "git":
            return ""
        searches = command[1] == "--search"
        return f"ros-thermometer: {package}/package.xml" if searches else "1.2.4~git2.abc+deb12"

    monkeypatch.setattr(version, "_output", answer)
    assert package_version("thermometer") == "1.2.4~git2.abc+deb12"
    assert asked[-1][-1] == "ros-thermometer"


def test_missing_commands_leave_the_version_of_the_manifest(
    package: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    assert package_version("thermometer") == "1.2.3"


def test_option_prints_the_version_and_ends(
    package: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = argparse.ArgumentParser(prog="read")
    parser.add_argument("--version", action=ShowVersion, package="thermometer")
    parser.add_argument("required")
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["--version"])
    assert not ended.value.code
    assert capsys.readouterr().out == "read of thermometer 1.2.3\n"
