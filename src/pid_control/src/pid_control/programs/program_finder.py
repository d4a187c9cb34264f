"""Finder of the program to judge in each package of a batch run, such as ``controller.py``."""

import glob
import os
import re
from contextlib import suppress
from typing import List, Optional, Protocol, Sequence

from pid_control.programs.program_command import files_in, find_files, near_names
from pid_control.verdicts.limits import Figures

#: Most files in a hint.
_MOST_NAMES = 3


class NothingToJudge(Exception):
    """Error of a package with nothing to judge; the text gives the reason."""


class SubjectFinder(Protocol):
    """Finder of what a batch run judges in each package.

    :ivar subject: what is judged, such as a controller: heading in tables
    :ivar figures: names of the figures of each scenario
    """

    subject: str
    figures: Figures

    def is_in(self, package: str) -> bool:
        """Return True if a package has it."""

    def is_built_by(self, package: str) -> bool:
        """Return True if a package builds it."""

    def words(self, package: str, workspace: Optional[str]) -> List[str]:
        """Return the command-line arguments that name it for the judge.

        :param package: folder of the package
        :param workspace: workspace that the package was built in, if it was
        :raises NothingToJudge: if the package does not have it
        """

    def hint(self, folder: str) -> str:
        """Return a hint about a folder that is not a package, or an empty text."""


class ProgramFinder:
    """Finder of a program by its name.

    :param name: name of the program in each package
    :param arguments: its arguments
    :param figures: names of the figures of each scenario
    """

    subject = "controller"

    def __init__(self, name: str, arguments: Sequence[str], figures: Figures) -> None:
        self._name, self._arguments, self.figures = name, list(arguments), figures

    def is_in(self, package: str) -> bool:
        """Return True if a package has a file of that name."""
        return bool(find_files(package, self._name))

    def is_built_by(self, package: str) -> bool:
        """Return True if a package builds a program of that name."""
        return builds(package, self._name)

    def words(self, package: str, workspace: Optional[str]) -> List[str]:
        """Return the path of the program, and its arguments."""
        found = find_files(package, self._name)
        if workspace is not None:
            found += glob.glob(os.path.join(workspace, "devel", "lib", "*", self._name))
        if not found:
            near = near_names(self._name, package) or _controllers_in(package)
            raise NothingToJudge(f"it has no {self._name}{near}")
        return [found[0], *self._arguments]

    def hint(self, folder: str) -> str:
        """Return a hint about a program without a package."""
        found = find_files(folder, self._name)
        if not found:
            return ""
        return f"; {os.path.relpath(found[0], folder)} can be judged by its path"


def builds(package: str, name: str) -> bool:
    """Return True if a package builds a program of a name.

    :param package: folder of the package
    :param name: name of the program
    """
    with suppress(OSError, UnicodeDecodeError):
        with open(os.path.join(package, "CMakeLists.txt"), encoding="utf-8") as file:
            return re.search(rf"add_executable\(\s*{re.escape(name)}\s", file.read()) is not None
    return False


def _controllers_in(package: str) -> str:
    """Return a hint with the Python files that may be a controller, by the name of its topic."""
    found = []
    for path in files_in(package):
        with suppress(OSError):
            if path.endswith(".py"):
                with open(path, encoding="utf-8", errors="replace") as file:
                    found += [path] if "motor_input" in file.read() else []
    names = " or ".join(sorted(os.path.relpath(path, package) for path in found)[:_MOST_NAMES])
    return f"; {names} mentions motor_input, and can be judged by its path" if names else ""
