"""Tests of ci/release: versions and changelogs, and failed checks."""

import datetime
import os
import pathlib
import re
import shutil
import signal
import subprocess
import textwrap
import time
from typing import List, Set

import pytest

from ci.packages.debian_files import RELEASES

from .conftest import CI

TITLE = "^^^^^\nTitle\n^^^^^\n\n"
PROJECT = """maintainer: some body
email: some@example.org
security: security@example.org
website: https://example.org/
repository: https://example.org/it.git
bugtracker: https://example.org/it/issues
"""
MANIFEST = """<package>
  <name>{name}</name>
  <version>0.9.0</version>
  <description>It.</description>
  <maintainer email="some@example.org">some body</maintainer>
</package>
"""
CHECKS = ("test", "clean-room", "deb", "container")
SUITES = tuple(RELEASES)
#: As often as each of them runs, two at a time: what a suite needs can be gone on with.
RUNS = sorted(
    ["test", *len(SUITES) * 7 * ["clean-room"], *len(SUITES) * ["deb"], "container"],
)


class Copy:
    """A small git workspace with checks that only log their calls."""

    def __init__(self, root: pathlib.Path) -> None:
        self.root = root
        #: Days on which ci/release was running.
        self.days: Set[str] = set()
        self.journal = root.parent / "journal"
        for name in (
            "release",
            "setup/usage.bash",
            "__init__.py",
            "__main__.py",
            "packages/__init__.py",
            "packages/debian_files.py",
            "packages/project.py",
            "packages/release.py",
        ):
            (root / "ci" / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(str(CI / name), str(root / "ci" / name))
        for name in (*CHECKS, "exec"):
            self.script(name, f"echo a {name}")
        self.script("deb", "mkdir -p dist/$1/earlier; : >dist/$1/a.deb; : >dist/$1/earlier/b.deb")
        self.script("test", "mkdir -p docs/_build/html; : >docs/_build/html/index.html")
        self.script(
            "exec", '[ "$1" = rostest ] && [ "$ADD_PROMISES" = 1 ] && echo new >>docs/table'
        )
        self.write(".gitignore", "/dist/\n/docs/_build/\n__pycache__/\n")
        self.write("packaging/project.yaml", PROJECT)
        self.write("docs/table", "old\n")
        self.write("docs/releases.md", "# Releases\n\n## 1.2.0\n\nGood.\n")
        for name, log in (("one", "Forthcoming\n-----------\n* Add it.\n\n"), ("two", "")):
            self.write(f"src/{name}/package.xml", MANIFEST.format(name=name))
            self.write(f"src/{name}/CHANGELOG.rst", f"{TITLE}{log}0.9.0 (2026-01-02)\n-----\n")
        self.git("init", "--quiet")
        self.commit()

    def script(self, name: str, body: str) -> None:
        """Write a program of ci/."""
        line = f'echo "{name} $@: $(git log -1 --format=%s)" >>"{self.journal}"'
        self.write(f"ci/{name}", f"#!/bin/sh -e\n{line}\n{body}\n")
        (self.root / "ci" / name).chmod(0o755)

    def write(self, name: str, text: str) -> None:
        """Write a file."""
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text)

    def read(self, name: str) -> str:
        """Read a file."""
        return (self.root / name).read_text()

    def git(self, *arguments: str) -> str:
        """Return git's output."""
        return subprocess.check_output(
            ["git", *arguments], cwd=str(self.root), universal_newlines=True
        )

    def commit(self) -> None:
        """Commit everything."""
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "Begin")

    def state(self) -> List[str]:
        """Return the state that a release changes."""
        return [self.git("log", "--all", "--format=%H"), self.git("status", "--porcelain")]

    def release(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run ci/release."""
        began = datetime.date.today()
        done = subprocess.run(
            [str(self.root / "ci" / "release"), *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=300,
        )
        self.days = {day.isoformat() for day in (began, datetime.date.today())}
        return done


@pytest.fixture
def copy(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> Copy:
    for role in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{role}_NAME", "committer")
        monkeypatch.setenv(f"GIT_{role}_EMAIL", "committer@example.invalid")
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", os.devnull)
    return Copy(tmp_path / "workspace")


def test_a_release_is_a_commit_a_tag_and_what_was_built(copy: Copy) -> None:
    done = copy.release("1.2.0")
    assert done.returncode == 0, done.stderr
    (day,) = re.findall(r"^1\.2\.0 \((.*)\)$", copy.read("src/one/CHANGELOG.rst"), re.MULTILINE)
    assert day in copy.days
    heading = f"1.2.0 ({day})\n------------------\n"
    assert copy.read("src/one/CHANGELOG.rst").startswith(f"{TITLE}{heading}* Add it.\n\n0.9.0 (")
    # An unchanged package gets the version too.
    assert copy.read("src/two/CHANGELOG.rst").startswith(f"{TITLE}{heading}\n0.9.0 (")
    for name in ("one", "two"):
        assert "<version>1.2.0</version>" in copy.read(f"src/{name}/package.xml")
    assert copy.read("docs/table") == "old\nnew\n"
    assert copy.git("status", "--porcelain") == ""
    assert copy.git("log", "-1", "--format=%s %d").startswith("Release 1.2.0  (HEAD -> ")
    assert copy.git("describe").strip() == "1.2.0"
    # The checks ran on the tagged commit.
    runs = [line.partition(" ")[::2] for line in copy.journal.read_text().splitlines()]
    assert runs[0][0] == "exec" and sorted(name for name, _ in runs[1:]) == RUNS
    assert all(rest.endswith(": Release 1.2.0") for _, rest in runs[1:])
    # Timed checks run alone, before the others.
    timed = [rest.partition(":")[0] for _, rest in runs[2 : 2 + len(SUITES)]]
    assert timed == [f"--only launch {suite}" for suite in SUITES]
    # The pages, and each suite with all parts.
    assert [rest.partition(":")[0] for name, rest in runs if name == "test"] == ["docs"]
    (named,) = re.findall(
        r"^read_options (\S+)", (CI / "clean-room").read_text("utf-8"), re.MULTILINE
    )
    for suite in SUITES:
        parts = [rest for name, rest in runs if name == "clean-room" and f" {suite}:" in rest]
        assert sorted(rest.split()[1] for rest in parts) == sorted(named.split(","))
    built = copy.root / "dist" / "1.2.0"
    logs = [f"logs/{name}" for name in os.listdir(built / "logs")]
    assert len(logs) == len(RUNS)
    assert sorted(str(path.relative_to(built)) for path in built.rglob("*.*")) == sorted(
        ["docs/index.html", *(f"{suite}/a.deb" for suite in SUITES), *logs]
    )
    assert (built / "logs" / "ci_container.log").read_text() == "a container\n"
    assert sorted(os.listdir(copy.root / "dist")) == ["1.2.0"]


@pytest.mark.parametrize("check", ["exec", "test", "deb", "container"])
def test_release_needs_passing_checks(copy: Copy, check: str) -> None:
    copy.script(check, "exit 3")
    copy.commit()
    before = copy.state()
    done = copy.release("1.2.0")
    assert done.returncode == 1
    assert f"ci/{check}" in done.stderr and "ended with status 3" in done.stderr
    assert done.stderr.splitlines()[-1] == "ci/release: nothing was released"
    assert copy.state() == before
    assert copy.git("tag") == "" and os.listdir(copy.root / "dist") == [".1.2.0"]


def test_passed_steps_are_not_run_again(copy: Copy) -> None:
    copy.script("deb", f"test -e {copy.journal}.goes_on; mkdir -p dist/$1")
    copy.commit()
    done = copy.release("1.2.0")
    assert done.returncode == 1
    # All other checks were run as well; the failed ones are listed at the end.
    names = [line.split()[0] for line in copy.journal.read_text().splitlines()]
    assert sorted(names[1:]) == RUNS
    told = done.stderr.splitlines()[-1 - len(SUITES) : -1]
    assert all(f"'./ci/deb {suite}' ended" in line for suite, line in zip(reversed(SUITES), told))
    before = copy.state()
    assert copy.release("--dry-run", "--resume", "1.2.0").returncode == 0  # which keeps it
    copy.journal.unlink()
    copy.journal.with_name("journal.goes_on").touch()
    done = copy.release("--resume", "1.2.0")
    assert done.returncode == 0, done.stderr
    assert "ci/release: ./ci/test docs: passed before" in done.stderr
    names = [line.split()[0] for line in copy.journal.read_text().splitlines()]
    assert names == ["deb"] * len(SUITES)
    assert copy.state() != before and copy.git("describe").strip() == "1.2.0"


def test_a_check_cleans_up_at_ctrl_c(copy: Copy) -> None:
    begun = copy.journal.with_name("begun")
    copy.script(
        "deb",
        f"""trap 'sleep 1; echo cleaned >>"{copy.journal}"; exit 130' INT
        : >"{begun}"
        while :; do sleep 0.1 || :; done""",
    )
    copy.commit()
    before = copy.state()
    process = subprocess.Popen(
        [str(copy.root / "ci" / "release"), "1.2.0"],
        stderr=subprocess.PIPE,
        universal_newlines=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60.0
    while not begun.exists() and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.01)  # poll
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("ci/release: interrupted: with --resume")
    assert "Traceback" not in said
    assert copy.journal.read_text().splitlines()[-1] == "cleaned"
    assert copy.state() == before and copy.git("tag") == ""


def test_only_the_same_commit_is_gone_on_with(copy: Copy) -> None:
    refused = "no release of 1.2.0 from this commit to resume; remove --resume"
    done = copy.release("--resume", "1.2.0")
    assert done.returncode == 125 and refused in done.stderr
    copy.script("container", "exit 3")
    copy.commit()
    assert copy.release("1.2.0").returncode == 1
    copy.script("container", "")
    copy.commit()
    done = copy.release("--resume", "1.2.0")
    assert done.returncode == 125 and refused in done.stderr
    assert copy.release("1.2.0").returncode == 0


def test_release_needs_the_pages(copy: Copy) -> None:
    copy.script("test", "")  # as if the tools of that tier are missing
    copy.commit()
    before = copy.state()
    done = copy.release("1.2.0")
    assert done.returncode == 1
    assert "docs/_build/html was not built, which needs Debian 12\n" in done.stderr
    assert copy.state() == before and copy.git("tag") == ""


def test_release_needs_the_git_identity_and_signs_nothing(
    copy: Copy, monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    (tmp_path / "config").write_text(
        "[user]\nuseConfigOnly = true\n[commit]\ngpgSign = true\n[tag]\ngpgSign = true\n"
    )
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", str(tmp_path / "config"))
    for role in ("AUTHOR", "COMMITTER"):
        monkeypatch.delenv(f"GIT_{role}_NAME")
        monkeypatch.delenv(f"GIT_{role}_EMAIL")
    done = copy.release("1.2.0")
    assert done.returncode == 125 and "GIT_COMMITTER_IDENT" in done.stderr
    copy.git("config", "user.name", "some body")  # in this repository, not in its clones
    copy.git("config", "user.email", "some@example.invalid")
    done = copy.release("1.2.0")
    assert done.returncode == 0, done.stderr
    told = copy.git("log", "-1", "--format=%an <%ae>, %cn <%ce>, %G?").strip()
    assert told == ", ".join(2 * ["some body <some@example.invalid>"] + ["N"])
    assert "PGP" not in copy.git("cat-file", "tag", "1.2.0")


def test_each_package_has_its_part_in_the_changelog() -> None:
    whole = (CI.parent / "docs" / "changelog.rst").read_text("utf-8")
    manifests = sorted(CI.parent.glob("src/*/package.xml"))
    assert manifests
    for manifest in manifests:
        name = manifest.parent.name
        part = f"\n{name}\n{'~' * len(name)}\n\n.. include:: ../src/{name}/CHANGELOG.rst\n"
        assert part in whole, name
        lines = manifest.with_name("CHANGELOG.rst").read_text("utf-8").splitlines()
        title = f"Changelog for package {name}"  # as REP 132 has it
        assert lines[:4] == ["^" * len(title), title, "^" * len(title), ""]


def test_dry_run_prints_and_changes_nothing(copy: Copy) -> None:
    before = copy.state()
    done = copy.release("--dry-run", "1.2.0")
    assert done.returncode == 0, done.stderr
    assert "+  <version>1.2.0</version>" in done.stdout
    heading = "-Forthcoming\n------------\n+1.2.0 ({})"
    assert any(heading.format(day) in done.stdout for day in copy.days)
    assert all(f"would run ./ci/{name}" in done.stdout for name in CHECKS)
    assert copy.state() == before and not copy.journal.exists()


@pytest.mark.parametrize(
    "version, said",
    [
        ("1.2", "the version is '1.2': must be three numbers"),
        ("01.2.0", "must be three numbers"),
        ("0.9.0", "one has the version 0.9.0: must be below 0.9.0"),
        ("0.10.0", "docs/releases.md lacks the section '## 0.10.0'"),
        ("1.2.0", "the tag 1.2.0 exists already"),
        ("1.3.0", "there are uncommitted changes: ?? stray"),
    ],
)
def test_invalid_release_is_refused(copy: Copy, version: str, said: str) -> None:
    if "tag" in said:
        copy.git("tag", version)
    if "stray" in said:
        copy.write("stray", "")
    done = copy.release(version)
    assert (done.returncode, done.stdout) == (125, "")
    assert said in done.stderr
    assert not copy.journal.exists()


def test_release_needs_a_reachable_maintainer(copy: Copy) -> None:
    placeholder = PROJECT.replace("security@example.org", "security@somewhere.invalid")
    copy.write("packaging/project.yaml", placeholder.replace("example.org/it/", "not.invalid/"))
    copy.commit()
    before = copy.state()
    for options in ([], ["--dry-run"]):
        done = copy.release(*options, "1.2.0")
        assert (done.returncode, done.stdout) == (125, "")
        assert "project.yaml has placeholders for security, bugtracker: users" in done.stderr
        assert "--unpublished" in done.stderr
    assert copy.state() == before and not copy.journal.exists()


def test_unpublished_files_may_have_placeholders(copy: Copy) -> None:
    copy.write("packaging/project.yaml", PROJECT.replace("example.org", "basic-comms.invalid"))
    copy.commit()
    done = copy.release("--unpublished", "1.2.0")
    assert done.returncode == 0, done.stderr
    assert copy.git("describe").strip() == "1.2.0"
    told = "has placeholders for email, security, website, repository, bugtracker: replace them"
    assert f"{told} before you publish anything" in done.stderr


def test_project_without_placeholders_gets_no_hint(copy: Copy) -> None:
    assert "placeholders" not in copy.release("--unpublished", "--dry-run", "1.2.0").stderr


def test_a_project_that_cannot_be_read_is_refused(copy: Copy) -> None:
    copy.write("packaging/project.yaml", PROJECT.partition("\n")[2])
    copy.commit()
    done = copy.release("--unpublished", "1.2.0")
    assert done.returncode == 125
    assert "packaging/project.yaml: must have the keys maintainer, email" in done.stderr


def test_usage_is_shown() -> None:
    done = subprocess.run([str(CI / "release")], stdout=subprocess.PIPE, timeout=60)
    assert done.returncode == 125
    assert textwrap.dedent(done.stdout.decode()).startswith("Usage: ci/release")
