"""Selection of tests by the words of ``ci/test``."""

import dataclasses
import pathlib
from typing import Dict, List, Sequence, Set, Tuple

#: The tiers in the order of the report, and their contents.
TIERS: Dict[str, str] = {
    "lint": "format, types, imports, launch files, scripts, dependencies",
    "docs": "the pages, warnings as errors, and every command on them",
    "ci": "pytest on ci/tests",
    "unit": "pytest on src/*/test/unit",
    "install": "an install space, a workspace of the user's own, a new package",
    "catkin_build": "catkin build in place of catkin_make",
    "integration": "rostest files, src/*/test/integration",
    "extended": "rare faults and long waits, src/*/test/extended",
    "ros2": "src/*/test/ros2 and recordings: the bridge, recordings of ROS 2; fetches from PyPI",
}
#: Tiers that ``ci/test`` runs without arguments.
DEFAULT = ("unit", "integration")
#: The tiers of one package.
OF_A_PACKAGE = ("lint", "unit", "integration")
#: Packages with ROS 2 tests in place of integration tests.
WITH_ROS2 = ("ros2_bridge",)


class UnknownWord(Exception):
    """A word is not a tier, a package or a file."""


@dataclasses.dataclass
class Selection:
    """Selected tiers, packages by tier, and single test files.

    :param whole: names of complete tiers
    :param packages: names of selected packages, by tier
    :param places: test files, each with the name of a test in it, or empty
    :param pages_since: a commit, to type only the pages that have changed since
    """

    whole: List[str] = dataclasses.field(default_factory=list)
    packages: Dict[str, Set[str]] = dataclasses.field(default_factory=dict)
    places: List[Tuple[pathlib.Path, str]] = dataclasses.field(default_factory=list)
    pages_since: str = ""

    def add_package(self, name: str) -> None:
        """Choose the tiers of a package."""
        for tier in (*OF_A_PACKAGE, *(["ros2"] if name in WITH_ROS2 else [])):
            self.packages.setdefault(tier, set()).add(name)

    def add_word(self, word: str, known: Set[str], root: pathlib.Path) -> None:
        """Add the tier, package or file that a word names.

        :param known: names of the packages
        :param root: folder of the workspace, for relative paths that do not exist here
        :raises UnknownWord: if the word is unknown
        """
        path, _, test = word.partition("::")
        if word == "ci":
            self.packages.setdefault("lint", set()).add("ci")
            self.whole.append("ci")
        elif word in TIERS:
            self.whole.append(word)
        elif word in known:
            self.add_package(word)
        else:
            places = [place for place in (pathlib.Path(path), root / path) if place.exists()]
            if not places:
                raise UnknownWord(
                    f"'{word}' is not a tier, a package or a test file: ci/test --list shows them"
                )
            self.places.append((places[0].resolve(), test))


def of_change(files: Sequence[str], needs: Dict[str, Set[str]], commit: str) -> Selection:
    """Return the selection for a change of some files.

    :param files: their paths below the workspace
    :param needs: the packages that each package depends on
    :param commit: the commit that they differ from
    """
    from .workspace import with_dependents

    chosen = Selection()
    parts = [pathlib.PurePath(file).parts for file in files]
    changed = {part[1] for part in parts if part[0] == "src" and len(part) > 2} & set(needs)
    for name in sorted(with_dependents(changed, needs)):
        chosen.add_package(name)
    if any(part[0] in ("ci", "packaging", ".ci") or len(part) == 1 for part in parts):
        chosen.whole.append("ci")
        chosen.packages.setdefault("lint", set()).add("ci")
    if changed or any(part[0] == "docs" or part == ("README.md",) for part in parts):
        chosen.whole.append("docs")
        chosen.pages_since = commit
    return chosen
