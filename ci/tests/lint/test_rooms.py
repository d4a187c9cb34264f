"""The page of the design shows the rooms, and who may import whom, as the lint has them."""

import ast
import re
from typing import Dict, List

import pytest

from ci.lint import code_rules, page_rules

DESIGN = (code_rules.SOURCES.parent / "docs" / "design.md").read_text("utf-8")
TABLES = {
    "room": code_rules.ROOMS["nodekit"],
    "room of topic_scope": code_rules.ROOMS["topic_scope"],
    "room of ros2_bridge": code_rules.ROOMS["ros2_bridge"],
    "room of the page": page_rules.ROOMS,
}


def rows(heading: str) -> Dict[str, str]:
    """Return the rows of a table of the page: what stands in the first column, and behind it."""
    (table,) = re.findall(
        rf"^\| {re.escape(heading)} \|.*\n\|[-|]+\|\n((?:\|.*\n)+)", DESIGN, re.MULTILINE
    )
    cells = (line.strip("| \n").split(" | ", 1) for line in table.splitlines())
    return {first: "".join(others) for first, *others in cells}


def names(text: str) -> List[str]:
    return re.findall(r"`(\w+)`", text)


@pytest.mark.parametrize("heading", TABLES)
def test_a_table_has_the_rooms_in_their_order(heading: str) -> None:
    assert [name for first in rows(heading) for name in names(first)] == TABLES[heading]


def test_a_room_that_is_called_pure_is_so() -> None:
    said = {f"nodekit.{names(room)[0]}" for room, text in rows("room").items() if "Pure" in text}
    assert said == {f"nodekit.{room}" for room in TABLES["room"]} & set(code_rules.PURE)


def test_every_other_package_with_rooms_has_its_row() -> None:
    table = {name: names(text) for name, text in rows("other packages with rooms").items()}
    with_tables = ("nodekit", "topic_scope", "ros2_bridge")
    assert table == {
        package: rooms
        for package, rooms in code_rules.ROOMS.items()
        if len(rooms) > 1 and package not in with_tables
    }


def test_every_package_has_a_row_with_what_it_may_import() -> None:
    table = {
        package: set(text.split(" |")[0].split(", ")) for package, text in rows("package").items()
    }
    assert table == code_rules.SIBLINGS


def test_every_room_and_every_pure_module_exists() -> None:
    modules = [name for name, _ in code_rules.modules()]
    listed = [f"{package}.{room}" for package, rooms in code_rules.ROOMS.items() for room in rooms]
    for place in [*listed, *code_rules.PURE, *code_rules.MAY_START_PROCESSES]:
        assert any(code_rules.is_in(name, [place]) for name in modules), place


@pytest.mark.parametrize(
    "name, text, said",
    [
        ("nodekit.timing.x", "from nodekit.node import y", "timing stands below node"),
        ("nodekit.attic.x", "", "attic is not among the rooms of nodekit"),
        ("nodekit.transport.x", "import rospy", "it must not depend on ROS, but imports rospy"),
        ("basic_comms.nodes.x", "import topic_scope", "basic_comms may not import topic_scope"),
        ("nodekit.timing.x", "import zoneinfo", "zoneinfo is newer than Python 3.8"),
        ("nodekit.timing.x", "eval('1')", "eval could make code of input"),
    ],
)
def test_a_breach_is_found(name: str, text: str, said: str) -> None:
    packages = set(code_rules.SIBLINGS)
    (found,) = code_rules.breaches(name, ast.parse(text), packages)
    assert found[1].startswith(said)


def test_the_workspace_has_no_breach() -> None:
    assert code_rules.main() == 0
