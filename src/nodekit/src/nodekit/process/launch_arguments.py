"""Check of the roslaunch command line for arguments that no launch file declares.

roslaunch ignores them silently, so the first node that it starts warns.
"""

import contextlib
import os
import re
from typing import List, Sequence, Set
from xml.etree import ElementTree

import rospkg
from roslib.packages import find_resource

from nodekit.parameters.validation import unknown_names


def warnings() -> List[str]:
    """Return a warning for each ignored argument.

    :returns: empty if roslaunch has not started this process, or it is not the first node
    """
    process = os.getpid()
    try:
        while process > 1:
            parent = _parent(process)
            words = _command(parent)
            names = [os.path.basename(word) for word in words[:2]]  # of Python, and of its script
            if "roslaunch" in names:
                given = words[names.index("roslaunch") + 1 :]
                found = ignored(given, os.readlink(f"/proc/{parent}/cwd"))
                return found if found and _is_first(process, parent) else []
            process = parent
    except (OSError, ElementTree.ParseError, rospkg.ResourceNotFound):
        pass  # a missing warning must not stop the node
    return []


def ignored(words: Sequence[str], folder: str) -> List[str]:
    """Return a warning for each ignored argument of a command line.

    :param words: arguments of ``roslaunch``
    :param folder: its working directory
    :raises OSError: if a launch file cannot be read
    :raises xml.etree.ElementTree.ParseError: if a launch file is malformed
    :raises rospkg.ResourceNotFound: if an included package is missing
    """
    given = [word.partition(":=")[0] for word in words if ":=" in word]
    names = [name for name in given if not name.startswith("_")]  # those are ROS's own
    paths = _launch_files([word for word in words if ":=" not in word], folder) if names else []
    if not paths:
        return []
    taken: Set[str] = set()
    for path in paths:
        _collect(path, taken, set())
    where = ", ".join(map(os.path.basename, paths))
    return [
        f"roslaunch ignores the argument {name}: it is not declared in {where}"
        + (f"; did you mean {nearest}?" if nearest else "")
        for name, nearest in unknown_names(taken, names).items()
    ]


def _launch_files(words: Sequence[str], folder: str) -> List[str]:
    """Return the launch files of a command line, named by path or by package and file."""
    paths = []
    for before, word in zip(["", *words], words):
        if word.endswith((".launch", ".xml")):
            found = []
            with contextlib.suppress(rospkg.ResourceNotFound):  # an option instead of a package
                found = find_resource(before, word) if before else []
            paths.append(str(found[0]) if found else os.path.join(folder, word))
    return paths


def _collect(path: str, taken: Set[str], seen: Set[str]) -> None:
    """Add the declared arguments of a launch file, and of included files that get all arguments.

    :param path: path of the file
    :param taken: collects the names
    :param seen: files that were read already
    """
    if path in seen:
        return
    seen.add(path)
    tree = ElementTree.parse(path)
    handed = {id(argument) for include in tree.iter("include") for argument in include}
    taken.update(
        argument.get("name", "") for argument in tree.iter("arg") if id(argument) not in handed
    )
    for include in tree.iter("include"):
        if include.get("pass_all_args", "").lower() in ("true", "1"):
            _collect(_resolved(include.get("file", ""), path), taken, seen)


def _resolved(text: str, path: str) -> str:
    """Return the path of an included file."""
    text = text.replace("$(dirname)", os.path.dirname(path))
    packages = rospkg.RosPack()
    return re.sub(r"\$\(find (\S+)\)", lambda found: str(packages.get_path(found[1])), text)


def _is_first(process: int, parent: int) -> bool:
    """Return whether a process is the first node of roslaunch, apart from its own rosout."""
    numbers = [int(name) for name in os.listdir("/proc") if name.isdigit()]
    return process == min(number for number in numbers if _is_node(number, parent))


def _is_node(process: int, parent: int) -> bool:
    try:
        words = _command(process) if _parent(process) == parent else []
    except OSError:  # it has just ended
        return False
    names = [word for word in words if word.startswith("__name:=")]
    return bool(names) and names != ["__name:=rosout"]


def _parent(process: int) -> int:
    with open(f"/proc/{process}/stat") as file:
        return int(file.read().rpartition(")")[2].split()[1])


def _command(process: int) -> List[str]:
    with open(f"/proc/{process}/cmdline", errors="replace") as file:
        return file.read().split("\0")[:-1]
