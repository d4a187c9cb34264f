"""Check imports between modules, and that code for ROS Noetic can be parsed.

``python3 ci lint.code_rules`` prints each breach and ends with status 1 if there is one. Modules
and functions that no package may use are banned in pyproject.toml, where ruff reads them.
"""

import ast
import pathlib
import re
import sys
from typing import Dict, Iterable, Iterator, List, Mapping, Set, Tuple

from . import public_api
from .structure import INDEPENDENT, ROOMS, SIBLINGS

SOURCES = pathlib.Path(__file__).resolve().parents[2] / "src"
PACKAGES = {manifest.parent.name for manifest in SOURCES.glob("*/package.xml")}
ROS = {"rospy", "rosgraph", "roslib", "std_msgs", "std_srvs", "genpy", "rclpy"}

#: Most lines of a module: a longer module has more than one subject.
LONGEST = 400
#: Module that imports its public names on first use.
PUBLIC_MODULE = "nodekit"

#: rospy's throttles, keyed by line of code: two nodes in a process silence each other.
THROTTLE = re.compile(r"log[a-z]+_throttle")

#: The Python of ROS Noetic, also for mypy, which knows the contents of its modules.
NOETIC = (3, 8)
#: First line of a module that must not depend on ROS; in an ``__init__.py``, for its whole folder.
PURE_MARK = "# Pure: knows no ROS.\n"


def modules() -> Iterator[Tuple[str, pathlib.Path]]:
    """Return the name and the path of each module of each package, scripts included."""
    for library in sorted(SOURCES.glob("*/src")):
        for path in sorted(library.rglob("*.py")):
            parts = path.relative_to(library).with_suffix("").parts
            yield ".".join(part for part in parts if part != "__init__"), path
    for path in sorted(filter(pathlib.Path.is_file, SOURCES.glob("*/scripts/*"))):
        yield f"{path.parts[-3]}.scripts.{path.stem}", path


#: Folders and modules with the mark, which are tested without a master.
PURE = frozenset(name for name, path in modules() if path.read_text("utf-8").startswith(PURE_MARK))


def imports(tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and full name of all imports of a module."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            prefix = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            for alias in node.names:
                yield node.lineno, prefix + alias.name


def is_in(name: str, places: Iterable[str]) -> bool:
    """Return whether a dotted name is, or lies below, one of some places."""
    return any((name + ".").startswith(place + ".") for place in places)


def import_graph(trees: Mapping[str, ast.AST]) -> Dict[str, Set[str]]:
    """Return the other modules that each module imports."""
    return {
        name: {
            found
            for _, imported in imports(tree)
            for found in (imported, imported.rpartition(".")[0])
            if found in trees and found != name
        }
        for name, tree in trees.items()
    }


def cycles(graph: Mapping[str, Set[str]]) -> Iterator[str]:
    """Return a sentence for each cycle of modules that import each other.

    :param graph: imports of each module
    """
    done: Set[str] = set()

    def visit(module: str, path: List[str]) -> Iterator[str]:
        if module in path:
            yield "import cycle: " + " -> ".join(path[path.index(module) :] + [module])
        elif module not in done:
            for target in sorted(graph.get(module, ())):
                yield from visit(target, path + [module])
            done.add(module)

    for module in sorted(graph):
        yield from visit(module, [])


def breaches(name: str, tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and message of each forbidden import of a module."""
    package, room = (name + ".").split(".")[:2]
    rooms, independent = ROOMS.get(package, []), INDEPENDENT.get(package, [])
    allowed = [package, *SIBLINGS.get(package, ("", ""))[0].split(", ")]
    if room not in ("", "scripts", *rooms):
        yield 1, f"{room} is not among the rooms of {package}: give it its place in ROOMS"
    for line, imported in imports(tree):
        top, other = (imported + ".").split(".")[:2]
        if top in PACKAGES and not is_in(imported, allowed):
            yield line, f"{package} may not import {imported}"
        if package != "nodekit" and is_in(imported, ["nodekit.testing"]):
            yield line, "nodekit.testing is for tests"
        if top == package and room in rooms and other in rooms:
            if room != other and any({room, other} <= group for group in independent):
                yield line, f"{room} and {other} are independent: neither may import the other"
            elif rooms.index(other) > rooms.index(room):
                yield line, f"{room} stands below {other} and may not import it"
        if is_in(name, PURE) and top in ROS:
            yield line, f"it must not depend on ROS, but imports {imported}"


def shared_throttles(tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and message of each use of rospy's throttles, which all nodes share."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and THROTTLE.match(node.attr):
            yield node.lineno, f"{node.attr} is keyed by line of code: use nodekit.Throttle"


def all_breaches() -> Iterator[str]:
    """Return a line for each breach in the workspace."""
    trees = {}
    for name, path in modules():
        text = path.read_text("utf-8")
        trees[name] = ast.parse(text, str(path), feature_version=NOETIC)
        found = [*breaches(name, trees[name]), *shared_throttles(trees[name])]
        for line, sentence in found:
            yield f"{path.relative_to(SOURCES.parent)}:{line}: {sentence}"
        if len(text.splitlines()) > LONGEST:
            yield f"{name}: longer than {LONGEST} lines"
    trees.pop(PUBLIC_MODULE)  # no module inside the package imports it
    yield from cycles(import_graph(trees))
    yield from public_api.breaches()


if __name__ == "__main__":
    sys.exit("\n".join(all_breaches()) or 0)
