"""Tests of the reports of failures under rostest."""

import io
import unittest
from typing import Any, List, Type
from xml.etree import ElementTree

import pytest

from nodekit.testing import running


class Outside(unittest.TestCase):
    __test__ = False  # but below

    @classmethod
    def setUpClass(cls) -> None:
        raise OSError("no class")

    def test_that_is_never_run(self) -> None:
        pass


class Within(unittest.TestCase):
    __test__ = False  # but below

    def test_in_parts(self) -> None:
        with self.subTest("first"):
            self.fail("no part")
        with self.subTest("second"):
            pass


class Twice(unittest.TestCase):
    __test__ = False  # but below

    def test_first(self) -> None:
        self.fail("no first")

    def test_second(self) -> None:
        raise OSError("no second")


class Well(unittest.TestCase):
    __test__ = False  # but below

    def test_that_passes(self) -> None:
        with self.subTest("first"):
            pass


def results_of(case: Type[unittest.TestCase], monkeypatch: "pytest.MonkeyPatch") -> List[Any]:
    """Run the tests of a class, and return their results."""
    results = io.StringIO()
    monkeypatch.setattr(running.xmlrunner, "_XMLTestResult", running.Result)
    suite = unittest.TestLoader().loadTestsFromTestCase(case)
    running.xmlrunner.XMLTestRunner(results).run(suite)
    return ElementTree.fromstring(results.getvalue()).findall("testcase")


@pytest.mark.parametrize(
    "case, names, said",
    [
        (Outside, ["Outside)"], "no class"),
        (Within, ["test_in_parts"], "no part"),
        (Well, ["test_that_passes"], ""),
    ],
)
def test_results_name_the_failure(
    case: Type[unittest.TestCase],
    names: List[str],
    said: str,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    cases = results_of(case, monkeypatch)
    assert [each.get("name") for each in cases] == names
    (told,) = [each.findtext("error") or "" for each in cases]
    assert said in told and bool(told) == bool(said)


@pytest.mark.parametrize(
    "value, names", [("", ["test_first", "test_second"]), ("1", ["test_first"])]
)
def test_a_run_ends_with_the_first_failure_where_that_is_enough(
    value: str, names: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setenv(running.FAIL_FAST, value)
    assert [each.get("name") for each in results_of(Twice, monkeypatch)] == names


class Marked(unittest.TestCase):
    __test__ = False  # but below

    def test_promise(self) -> None:
        pass

    @running.extended
    def test_rare_fault(self) -> None:
        pass


@pytest.mark.parametrize(
    ("is_extended", "names"), [(False, ["test_promise"]), (True, ["test_rare_fault"])]
)
def test_marked_tests_run_in_their_own_tier(is_extended: bool, names: List[str]) -> None:
    assert running.names_of_tier(unittest.TestLoader(), is_extended, Marked) == names
