"""Release the workspace: see ci/release.

Ends with status 125 and one sentence if it cannot begin, with 1 if a check fails, and with 130 at
Ctrl-C.
"""

import argparse
import datetime
import itertools
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Iterable, List, Optional, TextIO, Tuple

from . import debian_files, project

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SUITES = list(debian_files.RELEASES)
#: The newest suite first: it fails most often.
NEWEST_FIRST = SUITES[::-1]

#: Command that changes the clone before the commit.
PREPARE = (
    "env ADD_PROMISES=1 ./ci/exec rostest src/basic_comms/test/extended/dumped_parameters.test"
)
#: Checks that run alone because they measure times. (Of the tiers only docs is run here: the clean
#: rooms run all.)
ALONE = ["./ci/test docs", *(f"./ci/clean-room --only launch {suite}" for suite in SUITES)]
#: Checks that use this machine's network, one at a time: ROS 2 nodes would find each other.
ONE_BY_ONE = [
    "./ci/container",
    *(f"./ci/deb {suite}" for suite in NEWEST_FIRST),
    *(f"./ci/clean-room --only ros2 {suite}" for suite in NEWEST_FIRST),
]
#: Checks with a separate network, which can run beside any others: the longest first.
BESIDE = [
    f"./ci/clean-room --only {part} {suite}"
    for part in ("test", "workspace", "package", "prefix", "refusals")
    for suite in NEWEST_FIRST
]
#: Products of the checks, and their names in dist/VERSION.
PRODUCTS = {**{f"dist/{suite}": suite for suite in SUITES}, "docs/_build/html": "docs"}
NOTES = "docs/releases.md"

FORTHCOMING = re.compile(r"^Forthcoming\n-+\n", re.MULTILINE)


class Refused(Exception):
    """Error of an impossible release; the text has the reason."""


def number(version: str) -> Tuple[int, ...]:
    """Return a version as numbers, which can be compared.

    :raises Refused: if its form is not 1.2.3
    """
    if not re.fullmatch(r"(0|[1-9]\d*)(\.(0|[1-9]\d*)){2}", version):
        raise Refused(f"the version is '{version}': must be three numbers, such as 1.2.0")
    return tuple(map(int, version.split(".")))


def output(*command: str, folder: pathlib.Path = WORKSPACE) -> str:
    """Return the output of a command.

    :raises Refused: if it fails
    """
    try:
        return subprocess.check_output(command, cwd=str(folder), universal_newlines=True).strip()
    except subprocess.CalledProcessError as error:
        raise Refused(f"'{' '.join(command)}' ended with status {error.returncode}") from None


def author() -> List[str]:
    """Return git's options for the committer, because a clone lacks this folder's settings."""
    name, _, rest = output("git", "var", "GIT_COMMITTER_IDENT").partition(" <")
    return ["-c", f"user.name={name}", "-c", f"user.email={rest.partition('>')[0]}"]


def validate(version: str, unpublished: bool) -> None:
    """Check that a version can be released.

    :param unpublished: whether packaging/project.yaml may have placeholders
    :raises Refused: if it cannot
    """
    wanted = number(version)
    try:
        missing = ", ".join(project.placeholders(project.read(WORKSPACE)))
    except ValueError as error:
        raise Refused(str(error)) from None
    what = f"packaging/project.yaml has placeholders for {missing}"
    if missing and not unpublished:
        raise Refused(
            f"{what}: users could not reach you. Replace them as that file says,"
            " or release with --unpublished"
        )
    if missing:
        say(f"{what}: replace them before you publish anything")
    author()
    changed = output("git", "status", "--porcelain")
    if changed:
        raise Refused(f"there are uncommitted changes: {changed.splitlines()[0]}")
    if output("git", "tag", "--list", version):
        raise Refused(f"the tag {version} exists already")
    for one in debian_files.read_manifests(WORKSPACE / "src"):
        if number(one.version) >= wanted:
            raise Refused(f"{one.name} has the version {one.version}: must be below {version}")
    if not re.search(rf"^## {re.escape(version)}\b", (WORKSPACE / NOTES).read_text("utf-8"), re.M):
        raise Refused(f"{NOTES} lacks the section '## {version}': describe its changes there")


def bump(tree: pathlib.Path, version: str) -> None:
    """Change the version and the changelogs of all packages, in the format of REP 132."""
    title = f"{version} ({datetime.date.today().isoformat()})"
    heading = f"{title}\n{'-' * len(title)}\n"
    for manifest in sorted(tree.glob("src/*/package.xml")):
        text = manifest.read_text("utf-8")
        text = re.sub(r"<version>[^<]*<", f"<version>{version}<", text, count=1)
        manifest.write_text(text, "utf-8")
        changelog = manifest.with_name("CHANGELOG.rst")
        text, changes = FORTHCOMING.subn(heading, changelog.read_text("utf-8"), count=1)
        if not changes:
            # After the title, which has three lines, and an empty line.
            lines = text.splitlines(keepends=True)
            text = "".join([*lines[:4], heading, "\n", *lines[4:]])
        changelog.write_text(text, "utf-8")


class Attempt:
    """Clone for a release, and the checks that have passed there.

    It is kept until the version is released, so that ``--resume`` can continue.

    :param version: the version
    :param folder: a folder for the clone
    """

    def __init__(self, version: str, folder: pathlib.Path) -> None:
        self._version, self._folder = version, folder
        self._journal = folder / f"passed-{output('git', 'rev-parse', 'HEAD')}"
        self._is_interrupted = False
        self.tree, self.logs = folder / "workspace", folder / "logs"

    def begin(self) -> None:
        """Clone HEAD, and change the versions."""
        self.remove()
        self.logs.mkdir(parents=True)
        output("git", "clone", "--quiet", "--no-hardlinks", str(WORKSPACE), str(self.tree))
        bump(self.tree, self._version)

    def commit(self) -> None:
        """Run the command that changes the clone, and commit."""
        self._run(PREPARE)
        message = ["--no-gpg-sign", "--message", f"Release {self._version}"]
        output("git", *author(), "commit", "--quiet", "--all", *message, folder=self.tree)
        self._journal.touch()

    def validate(self) -> None:
        """Check that there is something to resume.

        :raises Refused: if there is nothing
        """
        if not self._journal.is_file():
            raise Refused(
                f"no release of {self._version} from this commit to resume; remove --resume"
            )

    def check(self) -> None:
        """Run the checks that have not passed yet, two at a time if they allow it.

        A failure does not end the others, so that one run shows all failures.

        :raises Refused: if checks have failed; the text names them
        """
        passed = self._journal.read_text("utf-8").splitlines()
        for line in passed:
            say(f"{line}: passed before")
        alone, one_by_one, beside = (
            iter([line for line in lines if line not in passed])
            for lines in (ALONE, ONE_BY_ONE, BESIDE)
        )
        failures = self._check_each(alone)
        with ThreadPoolExecutor(2) as pool:
            # Both take from the same iterator.
            lanes = [
                pool.submit(self._check_each, itertools.chain(one_by_one, beside)),
                pool.submit(self._check_each, beside),
            ]
            try:
                for lane in as_completed(lanes):
                    failures += lane.result()
            except KeyboardInterrupt:
                self._is_interrupted = True
                raise
        failures += [
            f"{source} was not built, which needs Debian 12"
            for source in PRODUCTS
            if not failures and not (self.tree / source).is_dir()
        ]
        if failures:
            raise Refused("\n".join(failures))

    def remove(self) -> None:
        """Remove the clone and its files."""
        shutil.rmtree(str(self._folder), ignore_errors=True)

    def _check_each(self, lines: Iterable[str]) -> List[str]:
        """Run checks, and return a message for each failure."""
        failures = []
        for line in lines:
            if self._is_interrupted:
                break
            began = time.monotonic()
            name = re.sub(r"\W+", "_", line).strip("_")
            try:
                with (self.logs / f"{name}.log").open("w", encoding="utf-8") as log:
                    self._run(line, log)
            except Refused as error:
                say(str(error))
                failures.append(str(error))
                continue
            with self._journal.open("a", encoding="utf-8") as journal:
                journal.write(f"{line}\n")
            say(f"{line}: passed after {time.monotonic() - began:.0f} s")
        return failures

    def _run(self, line: str, log: Optional[TextIO] = None) -> None:
        """Run a command in the clone.

        :raises Refused: if it fails
        :raises KeyboardInterrupt: at Ctrl-C, after the command has ended
        """
        see = f", see {log.name}" if log else ""
        say(f"{line}{see}")
        # The session's ROS workspace is another.
        own = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
        # Each system is bootstrapped once for all checks.
        systems = self._folder / "systems"
        systems.mkdir(exist_ok=True)
        own.setdefault("CLEAN_ROOM_CACHE", str(systems))
        process = subprocess.Popen(
            line.split(), cwd=str(self.tree), env=own, stdout=log, stderr=log and subprocess.STDOUT
        )
        try:
            status = process.wait()
        except KeyboardInterrupt:
            # The terminal has interrupted it as well: it cleans up before it ends.
            process.wait()
            raise
        if status in (-signal.SIGINT, 128 + signal.SIGINT):
            raise KeyboardInterrupt  # which reached it before us
        if status != 0:
            raise Refused(f"'{line}' ended with status {status}{see}")


def release(version: str, attempt: Attempt) -> None:
    """Run the checks, and fetch the commit, the tag and the products.

    :raises Refused: if a check fails
    """
    attempt.check()
    output("git", "fetch", "--quiet", str(attempt.tree), "HEAD")
    output("git", "merge", "--quiet", "--ff-only", "FETCH_HEAD")
    output("git", "tag", "--annotate", "--no-sign", "--message", f"Release {version}", version)
    target = WORKSPACE / "dist" / version
    shutil.rmtree(str(target), ignore_errors=True)
    for source, name in PRODUCTS.items():
        earlier = shutil.ignore_patterns("earlier")
        shutil.copytree(str(attempt.tree / source), str(target / name), ignore=earlier)
    shutil.copytree(str(attempt.logs), str(target / "logs"))
    attempt.remove()
    say(f"{version} is tagged and in dist/{version}: push it with 'git push origin HEAD {version}'")


def show(version: str) -> None:
    """Show the changes and the commands."""
    with tempfile.TemporaryDirectory(prefix="release-") as folder:
        attempt = Attempt(version, pathlib.Path(folder))
        attempt.begin()
        print(output("git", "diff", "--unified=0", folder=attempt.tree))
    for line in [PREPARE, *ALONE, *ONE_BY_ONE, *BESIDE]:
        print("would run", line)


def say(text: str) -> None:
    print(f"ci/release: {text}", file=sys.stderr, flush=True)


def main(arguments: List[str]) -> int:
    """Release, or show the steps.

    :returns: exit status
    """
    parser = argparse.ArgumentParser(prog="ci/release")
    parser.add_argument("--dry-run", action="store_true")
    parser.add_argument("--unpublished", action="store_true")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("version")
    options = parser.parse_args(arguments)
    status = 125
    try:
        validate(options.version, options.unpublished)
        attempt = Attempt(options.version, WORKSPACE / "dist" / f".{options.version}")
        if options.resume:
            attempt.validate()
        status = 1
        if options.dry_run:
            show(options.version)
            return 0
        if not options.resume:
            attempt.begin()
            attempt.commit()
        release(options.version, attempt)
    except Refused as reason:
        say(str(reason))
        if status == 1:
            say("nothing was released")
        return status
    except KeyboardInterrupt:
        say("interrupted: with --resume, passed checks are not run again")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
