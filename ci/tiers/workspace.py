"""The workspace's files and packages, and the packages that a change affects."""

import pathlib
import subprocess
from typing import Dict, Iterable, List, Set
from xml.etree import ElementTree

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SOURCES = WORKSPACE / "src"
CI = WORKSPACE / "ci"
DOCS = WORKSPACE / "docs"
#: Folders of files that are generated.
GENERATED = ("_build", "__pycache__")


class UnknownCommit(Exception):
    """Error of an unknown commit; the text is git's."""


def packages() -> List[pathlib.Path]:
    """Return the directories of the workspace's packages."""
    return sorted(manifest.parent for manifest in SOURCES.glob("*/package.xml"))


def files_of(*places: pathlib.Path) -> Iterable[pathlib.Path]:
    """Return the files below some folders, without generated and hidden ones."""
    for place in places:
        for path in sorted(place.rglob("*")) if place.is_dir() else [place]:
            parts = path.parent.relative_to(WORKSPACE).parts
            if path.is_file() and not any(
                part in GENERATED or part.startswith(".") for part in parts
            ):
                yield path


def scripts(language: str, *places: pathlib.Path) -> List[str]:
    """Return the files with an interpreter in their first line, e.g. ``bash``."""
    return [str(path) for path in files_of(*places) if runs_with(language, path)]


def runs_with(language: str, path: pathlib.Path) -> bool:
    """Return whether a file's first line names an interpreter."""
    with path.open("rb") as file:
        line = file.readline(80)
    return line.startswith(b"#!") and language.encode() in line


def dependencies() -> Dict[str, Set[str]]:
    """Return each package's dependencies in the workspace, including those of its tests."""
    names = {package.name for package in packages()}
    return {
        package.name: {
            (tag.text or "").strip()
            for tag in ElementTree.parse(str(package / "package.xml")).getroot()
            if tag.tag.endswith("depend")
        }
        & names
        for package in packages()
    }


def with_dependents(changed: Set[str], needs: Dict[str, Set[str]]) -> Set[str]:
    """Return packages and all direct and indirect dependents.

    :param changed: names of packages
    :param needs: the packages that each package depends on
    """
    found = set(changed)
    while True:
        more = {name for name, needed in needs.items() if needed & found} - found
        if not more:
            return found
        found |= more


def changed_files(commit: str) -> List[str]:
    """Return the paths that differ from a commit, including uncommitted changes.

    :raises UnknownCommit: if the commit does not exist
    """
    return [
        *git("diff", "--name-only", "--no-renames", commit, "--"),
        *git("ls-files", "--others", "--exclude-standard"),
    ]


def git(*arguments: str) -> List[str]:
    """Return the lines of git's output.

    :raises UnknownCommit: if it fails
    """
    done = subprocess.run(
        ["git", "-C", str(WORKSPACE), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    )
    if done.returncode:
        raise UnknownCommit(done.stderr.strip().splitlines()[0])
    return done.stdout.splitlines()
