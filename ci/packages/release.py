"""Release the workspace: see ci/release.

Ends with status 125 and one sentence where it cannot begin, with 1 where something is not good, and
with 130 at Ctrl-C.
"""

import argparse
import datetime
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Deque, List, Optional, TextIO, Tuple

from . import debian_files, project

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]

#: What changes the clone before the commit, and what has to be good after it: in pieces, since
#: what was interrupted begins anew.
PREPARE = [
    ["env", "ADD_PROMISES=1", "./ci/exec", "rostest"]
    + ["src/basic_comms/test/extended/dumped_parameters.test"]
]
#: Checks that nothing runs beside: what is timed. (Of the tiers only that which makes the pages is
#: run here: the rooms run all.)
ALONE = [
    ["./ci/test", "docs"],
    *(["./ci/clean-room", "--only", "launch", suite] for suite in debian_files.RELEASES),
]
#: What is newest changes most, and is bad most often: that is known early.
NEWEST_FIRST = list(reversed(debian_files.RELEASES))
#: Checks that use this machine's network, where two of ROS 2 would find each other: one at a time.
ONE_BY_ONE = [
    ["./ci/container"],
    *(["./ci/deb", suite] for suite in NEWEST_FIRST),
    *(["./ci/clean-room", "--only", "ros2", suite] for suite in NEWEST_FIRST),
]
#: Checks that have a network of their own, and can run beside any others: the longest first.
ROOMS = ("test", "workspace", "package", "prefix", "by_hand", "refusals")
BESIDE = [["./ci/clean-room", "--only", part, suite] for part in ROOMS for suite in NEWEST_FIRST]
#: Built by these, and what it is called in dist/VERSION.
PRODUCTS = {f"dist/{suite}": suite for suite in debian_files.RELEASES}
PRODUCTS["docs/_build/html"] = "docs"
NOTES = "docs/releases.md"

VERSION = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)")
FORTHCOMING = re.compile(r"^Forthcoming\n-+\n", re.MULTILINE)


class Refused(Exception):
    """There can be no such release; the text says why."""


def number(version: str) -> Tuple[int, ...]:
    """Return a version as something that can be compared.

    :raises Refused: it has another form than 1.2.3
    """
    if not VERSION.fullmatch(version):
        raise Refused(f"the version is '{version}': must be three numbers, such as 1.2.0")
    return tuple(map(int, version.split(".")))


def with_version(manifest: str, version: str) -> str:
    """Return a package.xml with another version.

    :param manifest: its text
    """
    return re.sub(r"(<version>)[^<]*(</version>)", rf"\g<1>{version}\g<2>", manifest, count=1)


def with_heading(changelog: str, version: str, date: datetime.date) -> str:
    """Return a changelog in which what was forthcoming is a version, in the form of REP 132.

    :param changelog: its text; without that part, the version has nothing to tell
    """
    title = f"{version} ({date.isoformat()})"
    heading = f"{title}\n{'-' * len(title)}\n"
    if FORTHCOMING.search(changelog):
        return FORTHCOMING.sub(heading, changelog, count=1)
    lines = changelog.splitlines(keepends=True)
    # The title, which has three lines, and an empty one.
    return "".join([*lines[:4], heading, "\n", *lines[4:]])


def said(*command: str, place: pathlib.Path = WORKSPACE) -> str:
    """Return what a command prints.

    :raises Refused: it fails
    """
    try:
        return subprocess.check_output(command, cwd=str(place), universal_newlines=True).strip()
    except subprocess.CalledProcessError as error:
        raise Refused(f"'{' '.join(command)}' ended with status {error.returncode}") from None


def author() -> List[str]:
    """Return the options by which git learns who releases: a clone lacks what is set here alone.

    :raises Refused: git does not know it here either
    """
    name, _, rest = said("git", "var", "GIT_COMMITTER_IDENT").partition(" <")
    return ["-c", f"user.name={name}", "-c", f"user.email={rest.partition('>')[0]}"]


def judge_project(unpublished: bool) -> None:
    """Look whether those who get the release can reach its owner.

    :param unpublished: nobody will get it; then what is missing is told only
    :raises Refused: they cannot
    """
    try:
        missing = project.placeholders(project.read(WORKSPACE))
    except ValueError as error:
        raise Refused(str(error)) from None
    if not missing:
        return
    what = f"packaging/project.yaml has placeholders for {', '.join(missing)}"
    if not unpublished:
        raise Refused(
            f"{what}: nobody could reach you. Replace them as that file says,"
            " or release with --unpublished"
        )
    say(f"{what}: replace them before you publish anything")


def judge(version: str, unpublished: bool) -> None:
    """Look whether there can be such a release.

    :param unpublished: whether it may have placeholders
    :raises Refused: there cannot
    """
    wanted = number(version)
    judge_project(unpublished)
    author()
    changed = said("git", "status", "--porcelain")
    if changed:
        raise Refused(f"there are uncommitted changes: {changed.splitlines()[0].strip()}")
    if said("git", "tag", "--list", version):
        raise Refused(f"the tag {version} exists already")
    for manifest in sorted(WORKSPACE.glob("src/*/package.xml")):
        found = re.search(r"<version>([^<]*)</version>", manifest.read_text("utf-8"))
        present = found.group(1) if found else "none"
        if number(present) >= wanted:
            raise Refused(
                f"{manifest.parent.name} has the version {present}: must be below {version}"
            )
    if not re.search(rf"^## {re.escape(version)}\b", (WORKSPACE / NOTES).read_text("utf-8"), re.M):
        raise Refused(f"{NOTES} has no section '## {version}': say there what it brings its users")


def bump(tree: pathlib.Path, version: str) -> None:
    """Change the version, and the changelogs, of all packages of a tree."""
    today = datetime.date.today()
    for manifest in sorted(tree.glob("src/*/package.xml")):
        manifest.write_text(with_version(manifest.read_text("utf-8"), version), "utf-8")
        changelog = manifest.with_name("CHANGELOG.rst")
        changelog.write_text(with_heading(changelog.read_text("utf-8"), version, today), "utf-8")


class Attempt:
    """A clone in which a release is tried, and the checks that it has passed there.

    It is kept until the version is released, so that ``--resume`` need not begin anew.

    :param version: the version
    :param place: a folder for it
    """

    def __init__(self, version: str, place: pathlib.Path) -> None:
        self._version, self._place = version, place
        self._journal = self._place / "passed"
        self.logs = self._place / "logs"
        self._systems = self._place / "systems"
        self.tree = self._place / "workspace"

    def begin(self) -> None:
        """Clone HEAD, and change the versions."""
        self.remove()
        self._systems.mkdir(parents=True)
        self.logs.mkdir()
        said("git", "clone", "--quiet", "--no-hardlinks", str(WORKSPACE), str(self.tree))
        said("git", "checkout", "--quiet", "--detach", head(WORKSPACE), place=self.tree)
        bump(self.tree, self._version)

    def prepare(self) -> None:
        """Run what changes the clone further, and commit.

        :raises Refused: it fails
        """
        for command in PREPARE:
            self._run(command)
        message = ["--no-gpg-sign", "--message", f"Release {self._version}"]
        said("git", *author(), "commit", "--quiet", "--all", *message, place=self.tree)
        self._journal.touch()

    def judge(self) -> None:
        """Look whether there is something to go on with.

        :raises Refused: there is not
        """
        if not self._journal.is_file() or head(self.tree, "HEAD~1") != head(WORKSPACE):
            raise Refused(
                f"there is no release of {self._version} from this commit to go on with: "
                "leave out --resume"
            )

    def check(self) -> None:
        """Run the checks that it has not passed yet, two at a time where they allow it.

        A bad one ends none of the others: what is to be mended is known after one run.

        :raises Refused: some of them are not good; the text names them
        """
        alone, one_by_one, beside = map(self._left, (ALONE, ONE_BY_ONE, BESIDE))
        bad = self._take(alone)
        with ThreadPoolExecutor(2) as pool:
            lanes = [
                pool.submit(self._take, one_by_one, beside),
                pool.submit(self._take, beside),
            ]
            try:
                for lane in as_completed(lanes):
                    bad += lane.result()
            except KeyboardInterrupt:
                one_by_one.clear()
                beside.clear()
                raise
        if bad:
            raise Refused("\n".join(bad))
        for source in PRODUCTS:
            if not (self.tree / source).is_dir():
                raise Refused(f"{source} was not built, which needs Debian 12")

    def remove(self) -> None:
        """Leave nothing of it."""
        shutil.rmtree(str(self._place), ignore_errors=True)

    def _left(self, checks: List[List[str]]) -> Deque[List[str]]:
        passed = self._journal.read_text("utf-8").splitlines()
        for command in checks:
            if " ".join(command) in passed:
                say(f"{' '.join(command)}: passed before")
        return deque(command for command in checks if " ".join(command) not in passed)

    def _take(self, *queues: Deque[List[str]]) -> List[str]:
        """Run what is in the queues, from which another thread may take as well.

        :returns: what was not good
        """
        bad = []
        for queue in queues:
            while True:
                try:
                    command = queue.popleft()
                except IndexError:
                    break
                try:
                    self._check(command)
                except Refused as error:
                    say(str(error))
                    bad.append(str(error))
        return bad

    def _check(self, command: List[str]) -> None:
        line = " ".join(command)
        name = "_".join(word.lstrip("./-") for word in command).replace("/", "_")
        log = self.logs / f"{name}.log"
        began = time.monotonic()
        with log.open("w", encoding="utf-8") as output:
            self._run(command, output)
        with self._journal.open("a", encoding="utf-8") as journal:
            journal.write(f"{line}\n")
        say(f"{line}: passed after {time.monotonic() - began:.0f} s")

    def _run(self, command: List[str], output: Optional[TextIO] = None) -> None:
        line = " ".join(command)
        see = f", see {output.name}" if output else ""
        say(f"{line}{see}")
        # The session's own ROS workspace is another one.
        own = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
        # Each system is bootstrapped once for all checks.
        own.setdefault("CLEAN_ROOM_CACHE", str(self._systems))
        process = subprocess.Popen(
            command, cwd=str(self.tree), env=own, stdout=output, stderr=output and subprocess.STDOUT
        )
        try:
            status = process.wait()
        except KeyboardInterrupt:
            # The terminal has told it as well: it cleans up before it ends.
            process.wait()
            raise
        if status in (-signal.SIGINT, 128 + signal.SIGINT):
            raise KeyboardInterrupt  # which reached it before us
        if status != 0:
            raise Refused(f"'{line}' ended with status {status}{see}")


def kept_attempt(version: str) -> Attempt:
    """Return the attempt at a version that ``--resume`` finds again."""
    return Attempt(version, WORKSPACE / "dist" / f".{version}")


def head(tree: pathlib.Path, commit: str = "HEAD") -> str:
    """Return the name of a commit."""
    return said("git", "rev-parse", commit, place=tree)


def release(version: str, resume: bool) -> None:
    """Do all of it.

    :param resume: go on with what was tried before
    :raises Refused: something is not good
    """
    attempt = kept_attempt(version)
    if not resume:
        attempt.begin()
        attempt.prepare()
    attempt.check()
    said("git", "fetch", "--quiet", str(attempt.tree), "HEAD")
    said("git", "merge", "--quiet", "--ff-only", "FETCH_HEAD")
    said("git", "tag", "--annotate", "--no-sign", "--message", f"Release {version}", version)
    target = WORKSPACE / "dist" / version
    shutil.rmtree(str(target), ignore_errors=True)
    for source, name in PRODUCTS.items():
        shutil.copytree(
            str(attempt.tree / source), str(target / name), ignore=shutil.ignore_patterns("earlier")
        )
    shutil.copytree(str(attempt.logs), str(target / "logs"))
    attempt.remove()
    say(f"{version} is tagged and in dist/{version}: push it with 'git push origin HEAD {version}'")


def show(version: str) -> None:
    """Show what would be changed and run."""
    with tempfile.TemporaryDirectory(prefix="release-") as folder:
        attempt = Attempt(version, pathlib.Path(folder))
        attempt.begin()
        print(said("git", "diff", "--unified=0", place=attempt.tree))
    for command in PREPARE + ALONE + ONE_BY_ONE + BESIDE:
        print("would run", *command)


def say(text: str) -> None:
    print(f"ci/release: {text}", file=sys.stderr, flush=True)


def main(arguments: List[str]) -> int:
    """Release, or show how.

    :returns: exit status
    """
    parser = argparse.ArgumentParser(prog="ci/release")
    parser.add_argument("--dry-run", action="store_true")
    parser.add_argument("--unpublished", action="store_true")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("version")
    options = parser.parse_args(arguments)
    try:
        judge(options.version, options.unpublished)
        if options.resume:
            kept_attempt(options.version).judge()
    except Refused as reason:
        say(str(reason))
        return 125
    if options.dry_run:
        show(options.version)
        return 0
    try:
        release(options.version, options.resume)
    except Refused as reason:
        say(str(reason))
        say("nothing was released")
        return 1
    except KeyboardInterrupt:
        say("interrupted: with --resume, what was good is not run again")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
