"""Check what no linter knows: who may import whom, what Python 3.8 lacks, no code made of input.

``python3 ci lint.code_rules`` prints each breach and ends with status 1 if there is one.
"""

import ast
import pathlib
import sys
from typing import Dict, Iterator, List, Mapping, Set, Tuple

from . import front_door
from .structure import INDEPENDENT, ROOMS, SIBLINGS

SOURCES = pathlib.Path(__file__).resolve().parents[2] / "src"

ROS = {"rospy", "rosgraph", "roslib", "std_msgs", "std_srvs", "genpy", "rclpy"}

#: Most lines of a module. Length follows sense; what is longer than this has more than one subject.
LONGEST = 400
#: Most modules of nodekit that a node imports: the front door is to do.
MOST_DOORS = 2
#: Imports by name what it offers, so that nothing is imported before it is used.
FRONT_DOOR = "nodekit"

#: The Python of ROS Noetic. mypy is set to it as well, and knows what its modules hold.
NOETIC = (3, 8)
#: Modules of the standard library that it does not have.
NEWER_MODULES = {"graphlib", "tomllib", "zoneinfo"}
#: First line of a module that must not depend on ROS; in an ``__init__.py``, of its whole room.
PURE_MARK = "# Pure: knows no ROS.\n"

#: What turns text into code or a command.
CODE = {"eval", "exec", "compile", "__import__", "system", "popen", "unsafe_load", "full_load"}
#: rosparam teaches even the safe loader of YAML to evaluate what is tagged as an angle.
MODULES = {"subprocess", "pickle", "marshal", "shelve", "pty", "rosparam"}
#: Where tests start processes, and pip and a compiler are called: by what an author wrote, not by
#: input. The judge starts what its user names, as rosrun does, and teleop what restores its
#: terminal.
MAY_START_PROCESSES = (
    "bot_controller_demo.teleop.terminal",
    "nodekit.testing",
    "pid_control.trial.class_run",
    "pid_control.trial.controller_process",
    "pid_control.trial.target",
    "ros2_bridge.environment.environment",
    "ros2_bridge.environment.twin_builder",
)


def modules() -> Iterator[Tuple[str, pathlib.Path]]:
    """Return the name and the path of each module of each package, scripts included."""
    for library in sorted(SOURCES.glob("*/src")):
        for path in sorted(library.rglob("*.py")):
            parts = path.relative_to(library).with_suffix("").parts
            yield ".".join(part for part in parts if part != "__init__"), path
    for path in sorted(SOURCES.glob("*/scripts/*")):
        yield f"{path.parts[-3]}.scripts.{path.stem}", path


#: Rooms and modules that bear the mark, so that they are tested without a master.
PURE = frozenset(name for name, path in modules() if path.read_text("utf-8").startswith(PURE_MARK))


def imports(tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and full name of all that a module imports, wherever it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield node.lineno, f"{node.module}.{alias.name}"


def calls(tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and bare name of all that a module calls."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            function = node.func
            if isinstance(function, ast.Name):
                yield node.lineno, function.id
            elif isinstance(function, ast.Attribute) and function.attr != "compile":
                yield node.lineno, function.attr


def is_in(name: str, places: object) -> bool:
    """Tell whether a dotted name is one of some places, or lies below one."""
    return any((name + ".").startswith(place + ".") for place in places)  # type: ignore


def import_graph(trees: Mapping[str, ast.AST]) -> Dict[str, Set[str]]:
    """Return which of the other modules each module imports."""
    return {
        name: {
            found
            for _, imported in imports(tree)
            for found in (imported, imported.rpartition(".")[0])
            if found in trees and found != name
        }
        for name, tree in trees.items()
    }


def circles(graph: Mapping[str, Set[str]]) -> Iterator[str]:
    """Return a sentence for each circle of modules that import each other.

    :param graph: what each module imports
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


def breaches(name: str, tree: ast.AST, packages: Set[str]) -> Iterator[Tuple[int, str]]:
    """Return line and sentence of all that a module may not do."""
    package, _, room = name.partition(".")
    room = room.partition(".")[0]
    rooms, independent = ROOMS.get(package, []), INDEPENDENT.get(package, [])
    if room not in ("", "scripts", *rooms):
        yield 1, f"{room} is not among the rooms of {package}: give it its place in ROOMS"
    for line, imported in imports(tree):
        top, _, other = imported.partition(".")
        other = other.partition(".")[0]
        if top in packages and top != package and not is_in(imported, SIBLINGS.get(package, ())):
            yield line, f"{package} may not import {imported}"
        if top == package and room in rooms and other in rooms:
            if room != other and any({room, other} <= group for group in independent):
                yield line, f"{room} and {other} are independent: neither may import the other"
            elif rooms.index(other) > rooms.index(room):
                yield line, f"{room} stands below {other} and may not import it"
        if is_in(name, PURE) and top in ROS:
            yield line, f"it must not depend on ROS, but imports {imported}"
        if top in MODULES and not is_in(name, MAY_START_PROCESSES):
            yield line, f"{top} could make code of input"
        if top in NEWER_MODULES:
            yield line, f"{top} is newer than Python 3.8, which ROS Noetic has"
        if imported == "typing.TYPE_CHECKING" and name != FRONT_DOOR:
            yield line, "what is imported for type checkers alone may hide a circle"
    if is_in(name, [f"{package}.nodes"]):
        doors = {imported.rpartition(".")[0] for _, imported in imports(tree)}
        doors = {door for door in doors if is_in(door, ["nodekit"])}
        if len(doors) > MOST_DOORS:
            yield 1, f"it imports too many modules of nodekit: {', '.join(sorted(doors))}"
    for line, called in calls(tree):
        if called in CODE:
            yield line, f"{called} could make code of input"


def main() -> int:
    """Print all breaches.

    :returns: exit status
    """
    packages = {manifest.parent.name for manifest in SOURCES.glob("*/package.xml")}
    paths = dict(modules())
    trees = {
        name: ast.parse(path.read_text("utf-8"), str(path), feature_version=NOETIC)
        for name, path in paths.items()
    }
    found = [
        f"{paths[name].relative_to(SOURCES.parent)}:{line}: {sentence}"
        for name, tree in trees.items()
        for line, sentence in breaches(name, tree, packages)
    ]
    for name, path in paths.items():
        if len(path.read_text("utf-8").splitlines()) > LONGEST:
            found.append(f"{name}: longer than {LONGEST} lines")
    trees.pop(FRONT_DOOR)  # nobody imports it from within
    found += circles(import_graph(trees))
    found += front_door.breaches()
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
