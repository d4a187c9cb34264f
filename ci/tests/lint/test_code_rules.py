"""Tests of the rules of imports between modules: order and independence."""

import ast
from typing import List

import pytest

from ci.lint import code_rules


@pytest.fixture(autouse=True)
def rooms(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setitem(code_rules.ROOMS, "house", ["cellar", "kitchen", "parlour", "attic"])
    monkeypatch.setitem(code_rules.INDEPENDENT, "house", [{"kitchen", "parlour"}])


def check(room: str, *imported: str) -> List[str]:
    """Return the messages about a module's imports."""
    text = "".join(f"from house.{name} import thing\n" for name in imported)
    found = code_rules.breaches(f"house.{room}.module", ast.parse(text))
    return [f"{line}: {sentence}" for line, sentence in found]


def test_a_room_imports_from_itself_and_from_those_before_it() -> None:
    assert not check("attic.corner", "attic.other", "parlour.table", "kitchen", "cellar")
    assert check("cellar", "attic.corner") == ["1: cellar stands below attic and may not import it"]


def test_independent_rooms_do_not_import_each_other() -> None:
    told = "kitchen and parlour are independent: neither may import the other"
    assert check("kitchen", "kitchen.stove", "parlour.table") == [f"2: {told}"]
    told = "parlour and kitchen are independent: neither may import the other"
    assert check("parlour", "cellar", "kitchen") == [f"2: {told}"]


def test_independent_rooms_are_rooms() -> None:
    for package, groups in code_rules.INDEPENDENT.items():
        assert groups
        for group in groups:
            assert len(group) > 1 and group <= set(code_rules.ROOMS[package])


def test_throttle_of_rospy_is_reported() -> None:
    text = "rospy.logwarn_throttle(1, '')\nrospy.logerr_throttle_identical\nthrottle.is_due()\n"
    assert sorted(line for line, _ in code_rules.shared_throttles(ast.parse(text))) == [1, 2]


def test_helpers_for_tests_are_refused_outside_nodekit() -> None:
    tree = ast.parse("from nodekit.testing.processes import Master\n")
    assert list(code_rules.breaches("pid_control.programs.private_master", tree)) == [
        (1, "nodekit.testing is for tests")
    ]
    assert not list(code_rules.breaches("nodekit.testing.graph", tree))
