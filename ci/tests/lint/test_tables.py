"""Tests of the generated tables of modules and allowed imports."""

import ast
import pathlib

import pytest

from ci.lint import code_rules, tables


@pytest.mark.parametrize("page", tables.PAGES, ids=lambda page: page.name)
def test_page_has_the_tables_as_they_are_generated(page: pathlib.Path) -> None:
    text = page.read_text("utf-8")
    assert tables.with_tables(text) == text, "run python3 ci lint.tables"


def test_every_table_is_on_a_page() -> None:
    texts = "".join(page.read_text("utf-8") for page in tables.PAGES)
    assert [name for name, rows in tables.tables().items() if f": {name}\n\n{rows}" in texts] == (
        list(tables.tables())
    )


def test_old_table_is_replaced_and_the_text_around_it_stays() -> None:
    begin, end = "% Table, by lint.tables: rooms of the page\n", "% End of table\n"
    rows = tables.tables()["rooms of the page"]
    text = tables.with_tables(f"before\n{begin}\n| old |\n\n{end}after\n{end}")
    assert text == f"before\n{begin}\n{rows}\n\n{end}after\n{end}"


def test_every_room_and_every_pure_module_exists() -> None:
    modules = [name for name, _ in code_rules.modules()]
    listed = [f"{package}.{room}" for package, rooms in code_rules.ROOMS.items() for room in rooms]
    for place in [*listed, *code_rules.PURE]:
        assert any(code_rules.is_in(name, [place]) for name in modules), place


def test_every_package_with_code_is_listed() -> None:
    packages = {name.partition(".")[0] for name, _ in code_rules.modules()}
    assert packages == set(code_rules.SIBLINGS) == set(code_rules.ROOMS)


@pytest.mark.parametrize(
    "name, text, said",
    [
        ("nodekit.timing.x", "from nodekit.node import y", "timing stands below node"),
        ("nodekit.attic.x", "", "attic is not among the rooms of nodekit"),
        ("nodekit.transport.x", "import rospy", "it must not depend on ROS, but imports rospy"),
        ("basic_comms.nodes.x", "import topic_scope", "basic_comms may not import topic_scope"),
        ("basic_comms.nodes.x", "import nodekit_msgs", "basic_comms may not import nodekit_msgs"),
    ],
)
def test_a_breach_is_found(name: str, text: str, said: str) -> None:
    (found,) = code_rules.breaches(name, ast.parse(text))
    assert found[1].startswith(said)
