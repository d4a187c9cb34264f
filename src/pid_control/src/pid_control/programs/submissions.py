"""Submissions of a class: packages in folders, workspaces and archives."""

import contextlib
import csv
import os
import pathlib
import re
from typing import Dict, List, NamedTuple, Sequence, Tuple
from xml.etree import ElementTree

from pid_control.programs.archives import ArchiveError, is_archive, stem_of, unpack
from pid_control.programs.program_finder import SubjectFinder

#: Deepest level of a package below a folder, and below a submission.
_DEEPEST, _DEEPEST_OF_ENTRY = 3, 5
#: Folders of a workspace that have no sources.
_BUILT = ("build", "devel", "install", "logs")
#: Elements of a package.xml with a dependency to build or run; the last one is of format 1.
_NEEDS = ("depend", "build_depend", "exec_depend", "run_depend")
#: Words of a heading of a roster's columns.
_HEADINGS = (
    "archive",
    "entry",
    "file",
    "folder",
    "full name",
    "group",
    "id",
    "login",
    "name",
    "student",
    "student name",
    "students",
    "submission",
    "user",
    "username",
)


class RosterError(Exception):
    """Error of a roster that cannot be read; the text gives the reason."""


class Submission(NamedTuple):
    """A package to judge, or an entry without a package.

    :ivar name: path below the folder of the class
    :ivar entry: name of the folder, archive or file in the folder of the class
    :ivar package: folder of the package; empty if there is nothing to judge
    :ivar why: why there is nothing to judge
    :ivar siblings: folders of the other packages of the entry
    :ivar is_file: whether the entry is a file that is not unpacked
    """

    name: str
    entry: str
    package: str
    why: str = ""
    siblings: Sequence[str] = ()
    is_file: bool = False


def packages_in(folder: str, deepest: int = _DEEPEST) -> List[str]:
    """Return the packages in a folder and its subfolders.

    :param folder: absolute path
    :param deepest: deepest level of a package
    """
    found = []
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if name[0] != "." and name not in _BUILT)
        if "package.xml" in files or "CATKIN_IGNORE" in files:
            folders[:] = []
            found += [place] if "CATKIN_IGNORE" not in files else []
        elif os.path.relpath(place, folder).count(os.sep) + 1 >= deepest:
            folders[:] = []
    return sorted(found)


def submissions_in(folder: str, finder: SubjectFinder, scratch: str) -> List[Submission]:
    """Return at least one submission for each entry of a folder that is not hidden.

    :param folder: absolute path of the folder of the class
    :param finder: finds what to judge in each package
    :param scratch: folder for unpacked archives
    """
    if os.path.isfile(os.path.join(folder, "package.xml")):
        return [Submission(".", ".", folder)]
    found: List[Submission] = []
    for index, entry in enumerate(sorted(os.listdir(folder))):
        if entry[0] != ".":
            place = os.path.join(folder, entry)
            found += _of_entry(entry, place, finder, os.path.join(scratch, str(index)))
    return found


def _of_entry(entry: str, place: str, finder: SubjectFinder, scratch: str) -> List[Submission]:
    if is_archive(place):
        try:
            unpack(place, scratch)
        except ArchiveError as error:
            return [Submission(entry, entry, "", str(error))]
        place = scratch
    elif not os.path.isdir(place):
        why = "it is neither a folder nor an archive (zip, tar)"
        return [Submission(entry, entry, "", why, is_file=True)]
    packages = packages_in(place, _DEEPEST_OF_ENTRY)
    if not packages and place != scratch:
        inner = [name for name in sorted(os.listdir(place)) if is_archive(f"{place}/{name}")]
        if inner:
            found: List[Submission] = []
            for name in inner:
                path = os.path.join(place, name)
                found += _of_entry(name, path, finder, f"{scratch}-{len(found)}")
            return [one._replace(name=f"{entry}/{one.name}", entry=entry) for one in found]
    if not packages:
        return [
            Submission(
                entry,
                entry,
                "",
                f"it has no package.xml: not a ROS package{finder.hint(place)}",
            )
        ]
    # Of several packages, those with something to judge count: the others are messages or tools.
    chosen = [one for one in packages if finder.is_in(one)]
    chosen = chosen or [one for one in packages if finder.is_built_by(one)] or packages[:1]
    return [
        Submission(
            os.path.normpath(os.path.join(entry, os.path.relpath(one, place))),
            entry,
            one,
            siblings=[other for other in packages if other != one],
        )
        for one in chosen
    ]


#: Files that name other packages, and a pattern of those lines.
_SOURCES = (".py", ".cpp", ".cc", ".h", ".hpp")
_IMPORTS = re.compile(
    r"^\s*(?:import|from)\s+[^\n]*|^\s*#\s*include\b[^\n]*|\bfind_package\s*\([^)]*", re.MULTILINE
)
_WORD = re.compile(r"\w+")


def needed_siblings(package: str, siblings: Sequence[str]) -> List[str]:
    """Return the sibling packages that a package depends on, directly or indirectly.

    :param package: folder of the package
    :param siblings: folders of the packages beside it; of those with one name, the first counts
    """
    own, missing = _name_and_needs(package)
    by_name: Dict[str, Tuple[str, List[str]]] = {}
    for sibling in siblings:
        name, needs = _name_and_needs(sibling)
        by_name.setdefault(name, (sibling, needs))
    by_name.pop(own, None)
    found: List[str] = []
    while missing:
        sibling, needs = by_name.pop(missing.pop(), ("", []))
        if sibling:
            found.append(sibling)
            missing += needs
    return sorted(found)


def _name_and_needs(package: str) -> Tuple[str, List[str]]:
    """Return the name of a package, and the packages that it declares or mentions.

    A build in a workspace works without a declaration, so many packages have none.
    """
    try:
        root = ElementTree.parse(os.path.join(package, "package.xml")).getroot()
    except (OSError, ElementTree.ParseError, LookupError, ValueError):  # also of its encoding
        return "", []
    needs = {(one.text or "").strip() for one in root if one.tag in _NEEDS}
    for path in pathlib.Path(package).rglob("*"):
        if path.suffix in _SOURCES or path.name == "CMakeLists.txt":
            with contextlib.suppress(OSError):
                text = path.read_text("utf-8", "replace")
                needs.update(
                    name for line in _IMPORTS.findall(text) for name in _WORD.findall(line)
                )
    return (root.findtext("name") or "").strip(), sorted(needs)


def read_roster(path: str) -> Dict[str, str]:
    """Return the student of each folder or archive; skip a heading.

    :param path: CSV file; each row has the name of a folder or archive, and the student
    :raises RosterError: if it is not CSV, a row has no student, or an entry has two
    """
    found: Dict[str, str] = {}
    with open(path, encoding="utf-8-sig", newline="") as file:
        try:
            rows = list(csv.reader(file, skipinitialspace=True))
        except csv.Error as error:
            raise RosterError(f"it is not CSV: {error}") from None
    for number, row in enumerate(rows, start=1):
        cells = [cell.strip() for cell in row]
        is_heading = number == 1 and all(cell.lower() in _HEADINGS for cell in cells[:2])
        if not any(cells) or is_heading:
            continue
        if len(cells) < 2 or not cells[0] or not cells[1]:
            raise RosterError(f"line {number}: must be a folder or archive, and a student")
        if stem_of(cells[0]) in found:
            raise RosterError(f"line {number}: {cells[0]} appears twice")
        found[stem_of(cells[0])] = cells[1]
    return found


def name_in(roster: Dict[str, str], submission: Submission) -> str:
    """Return the name of a submission's entry in a roster, or an empty text.

    :param roster: student of each folder or archive
    :param submission: the submission; a file may have any ending
    """
    names = [stem_of(submission.entry)]
    names += [os.path.splitext(submission.entry)[0]] if submission.is_file else []
    return next((name for name in names if name in roster), "")


def missing_in(submissions: Sequence[Submission], roster: Dict[str, str]) -> List[Submission]:
    """Return a submission with nothing to judge for each missing entry of a roster.

    :param submissions: the existing submissions
    :param roster: student of each folder or archive
    """
    there = {name_in(roster, one) for one in submissions}
    return [Submission(name, name, "", "nothing handed in") for name in roster if name not in there]
