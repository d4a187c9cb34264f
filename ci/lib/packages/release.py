"""Release the workspace: see ci/release.

Ends with status 125 and one sentence where it cannot begin, and with 1 where something is not good.
"""

import argparse
import contextlib
import datetime
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from typing import Iterator, List, Tuple

import project

WORKSPACE = pathlib.Path(__file__).resolve().parents[3]

#: What changes the clone before the commit, and what has to be good after it.
PREPARE = [
    ["env", "ADD_PROMISES=1", "./ci/exec", "rostest"]
    + ["src/basic_comms/test/integration/dumped_parameters.test"]
]
CHECKS = [["./ci/test", "all"], ["./ci/clean-room"], ["./ci/deb"], ["./ci/container"]]
#: Built by these, and what it is called in dist/VERSION.
PRODUCTS = {"dist/bookworm": "bookworm", "dist/trixie": "trixie", "docs/_build/html": "docs"}
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


@contextlib.contextmanager
def clone() -> Iterator[pathlib.Path]:
    """Have a clone of HEAD for a while."""
    with tempfile.TemporaryDirectory(prefix="release-") as folder:
        tree = pathlib.Path(folder, "workspace")
        said("git", "clone", "--quiet", "--no-hardlinks", str(WORKSPACE), str(tree))
        said("git", "checkout", "--quiet", "--detach", said("git", "rev-parse", "HEAD"), place=tree)
        yield tree


def run(commands: List[List[str]], tree: pathlib.Path) -> None:
    """Run commands, all of which have to be good.

    :raises Refused: one is not
    """
    # The session's own ROS workspace is another one.
    variables = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
    for command in commands:
        say(" ".join(command))
        status = subprocess.call(command, cwd=str(tree), env=variables)
        if status != 0:
            raise Refused(f"'{' '.join(command)}' ended with status {status}: nothing was released")


def release(version: str) -> None:
    """Do all of it.

    :raises Refused: something is not good
    """
    with clone() as tree:
        bump(tree, version)
        run(PREPARE, tree)
        message = ["--no-gpg-sign", "--message", f"Release {version}"]
        said("git", *author(), "commit", "--quiet", "--all", *message, place=tree)
        run(CHECKS, tree)
        for source in PRODUCTS:
            if not (tree / source).is_dir():
                raise Refused(
                    f"{source} was not built, which needs Debian 12: nothing was released"
                )
        said("git", "fetch", "--quiet", str(tree), "HEAD")
        said("git", "merge", "--quiet", "--ff-only", "FETCH_HEAD")
        said("git", "tag", "--annotate", "--no-sign", "--message", f"Release {version}", version)
        target = WORKSPACE / "dist" / version
        shutil.rmtree(str(target), ignore_errors=True)
        for source, name in PRODUCTS.items():
            shutil.copytree(
                str(tree / source), str(target / name), ignore=shutil.ignore_patterns("earlier")
            )
    say(f"{version} is tagged and in dist/{version}: push it with 'git push origin HEAD {version}'")


def show(version: str) -> None:
    """Show what would be changed and run."""
    with clone() as tree:
        bump(tree, version)
        print(said("git", "diff", "--unified=0", place=tree))
    for command in PREPARE + CHECKS:
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
    parser.add_argument("version")
    options = parser.parse_args(arguments)
    try:
        judge(options.version, options.unpublished)
    except Refused as reason:
        say(str(reason))
        return 125
    if options.dry_run:
        show(options.version)
        return 0
    try:
        release(options.version)
    except Refused as reason:
        say(str(reason))
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
