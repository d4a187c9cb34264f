"""Tests of the lint of tests that assert nothing if their data is empty."""

import ast
import textwrap

import pytest

from ci.lint.vacuous_tests import idle_tests

HEAD = """
NAMES = ["a", "b"]

def both():
    return ["a", "b"]

"""
#: Bodies of tests that assert nothing if their data is empty.
IDLE = [
    "for one in found(): assert one",
    "for one in []: assert one",
    "for one in range(0): assert one",
    "for one in found():\n    for other in NAMES: assert other",
    "for one, other in zip(NAMES, found()): self.assertTrue(one)",
    "for one in [each for each in NAMES if each]: assert one",
    "names = found()\nfor name in names: assert name",
    "names = ['a']\nnames = found()\nfor name in names: assert name",
    "assert all(one for one in found())",
    "assert not any(one for one in found())",
    "self.assertTrue(all(found()))",
    "def inner(): assert True\nfor one in found(): wait_until(inner)",
    "for one in found():\n    with pytest.raises(ValueError): one()",
]
#: Bodies of tests that assert something, or nothing at all.
BUSY = [
    "for one in found(): assert one\nassert found()",
    "for one in NAMES: assert one",
    "for one in both(): assert one",
    "for number, one in enumerate(sorted(NAMES)): assert one",
    "for key, value in {'a': 1}.items(): assert value",
    "for one in (*found(), 'a'): assert one",
    "for one in range(3): assert one",
    "for one in itertools.product(NAMES, (1, 2)): assert one",
    "names = [name.upper() for name in NAMES]\nfor name in names: assert name",
    "assert all(one for one in NAMES)",
    "assert found() and all(found())",
    "assert any(one for one in found())",
    "while True: assert True",
    "for one in found(): one()",
]


def told(body: str, decorator: str = "") -> int:
    """Return the number of reported tests."""
    text = f"{HEAD}{decorator}\ndef test_it(self):\n{textwrap.indent(body, '    ')}\n"
    return len(list(idle_tests(ast.parse(text))))


@pytest.mark.parametrize("body", IDLE)
def test_vacuous_assertion_is_reported(body: str) -> None:
    assert told(body) == 1


@pytest.mark.parametrize("body", BUSY)
def test_any_other_is_not(body: str) -> None:
    assert told(body) == 0


def test_values_of_hypothesis_are_not_always_empty() -> None:
    assert told(IDLE[0], "@given(st.lists(st.integers()))") == 0
