"""Tests of the public names of nodekit."""

import ast
import importlib
import pathlib
import subprocess
import sys
from typing import Any, Dict, List

import pytest

import nodekit
import nodekit.entry_point
from nodekit.deprecated import OLD_NAMES

#: Folder of the sources; nodekit.__file__ is catkin's own in a devel space.
PACKAGE = pathlib.Path(nodekit.entry_point.__file__).resolve().parent
TREE = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))


def imports_for_type_checkers() -> List[ast.ImportFrom]:
    (block,) = [node for node in TREE.body if isinstance(node, ast.If)]
    assert isinstance(block.test, ast.Name) and block.test.id == "TYPE_CHECKING"
    assert not block.orelse
    statements: List[ast.ImportFrom] = []
    for node in block.body:
        if isinstance(node, ast.Assign):  # an old name
            continue
        assert isinstance(node, ast.ImportFrom) and node.level == 0
        statements.append(node)
    return statements


def homes_in_the_text() -> List[Any]:
    """Return keys and values of _HOMES as they are written, repeated keys included."""
    (table,) = [
        node.value
        for node in TREE.body
        if isinstance(node, ast.AnnAssign) and getattr(node.target, "id", "") == "_HOMES"
    ]
    assert isinstance(table, ast.Dict)
    return [
        (ast.literal_eval(key), ast.literal_eval(value))
        for key, value in zip(table.keys, table.values)
    ]


def run(program: str) -> None:
    """Run a program in a separate process without imports."""
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize("name", sorted(nodekit._HOMES))
def test_each_name_can_be_imported(name: str) -> None:
    value = getattr(nodekit, name)
    home = importlib.import_module("nodekit." + nodekit._HOMES[name])
    assert value is getattr(home, name)
    assert getattr(value, "__module__", home.__name__) == home.__name__, (
        "it is named where it is made"
    )
    assert vars(nodekit)[name] is value, "it is looked for once"


def test_type_checkers_see_the_same_names() -> None:
    told: Dict[str, str] = {}
    for statement in imports_for_type_checkers():
        for alias in statement.names:
            assert alias.asname == alias.name, "or else it is not handed on to who imports nodekit"
            assert alias.name not in told
            told[alias.name] = str(statement.module)
    assert told == {name: "nodekit." + home for name, home in homes_in_the_text()}


def test_type_checkers_know_the_old_names() -> None:
    (block,) = [node for node in TREE.body if isinstance(node, ast.If)]
    old = {
        getattr(node.targets[0], "id", ""): getattr(node.value, "id", "")
        for node in block.body
        if isinstance(node, ast.Assign)
    }
    assert old == OLD_NAMES


def test_no_name_is_written_twice_and_all_are_public() -> None:
    names = [name for name, _ in homes_in_the_text()]
    assert sorted(set(names)) == sorted(names)
    assert nodekit.__all__ == sorted([*names, *OLD_NAMES])
    assert nodekit._HOMES == dict(homes_in_the_text())


def test_each_home_has_its_name() -> None:
    """Also where a home cannot be imported, as its text tells."""
    for name, home in nodekit._HOMES.items():
        path = PACKAGE.joinpath(*home.split(".")).with_suffix(".py")
        tree = ast.parse(path.read_text(encoding="utf-8"))
        made = [
            node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))
        ]
        made += [
            getattr(target, "id", "")
            for node in tree.body
            if isinstance(node, ast.Assign)
            for target in node.targets
        ]
        assert name in made, f"{name} is not made in {path}"


def test_no_public_name_hides_a_room() -> None:
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert not rooms & set(nodekit.__all__)


def test_a_name_that_does_not_exist_is_an_error_as_everywhere() -> None:
    with pytest.raises(AttributeError, match="module 'nodekit' has no attribute 'Nodes'"):
        getattr(nodekit, "Nodes")
    assert not hasattr(nodekit, "Nodes")
    run("try: from nodekit import Nodes\nexcept ImportError: pass\nelse: raise SystemExit(1)")


def test_star_import_has_all_public_names() -> None:
    run(f"from nodekit import *; assert set({nodekit.__all__!r}) <= set(globals())")


@pytest.mark.parametrize(
    "statement",
    [
        "import nodekit.parameters.parameter_types",
        "import nodekit.parameters.declaration",
        "import nodekit",
        "from nodekit import FloatParameter, ParameterSet, rule",
        "import nodekit.entry_point",
    ],
)
def test_validating_parameters_does_not_import_ros(statement: str) -> None:
    ros = ("rospy", "rosgraph", "roslib", "genpy", "std_msgs", "nodekit_msgs")
    run(f"import sys; {statement}; assert not set({ros!r}) & set(sys.modules), sorted(sys.modules)")
