"""Tests of mutants of the page's scripts."""

from typing import List, Tuple

import pytest

from ci.mutation import javascript
from ci.mutation.mutants import change_of


def changes(line: str) -> List[Tuple[str, str]]:
    """Return type and changed line of each mutant of a line in a function."""
    text = f"function f() {{\n  {line}\n}}\n"
    found = [(one["kind"], one["made"]) for one in javascript.listed("a.js", text)]
    for _, made in found:
        assert made.startswith("function f() {\n") and made.endswith("\n}\n")
    return [(kind, change_of(text, made)[1].split("` → `")[1][:-1]) for kind, made in found]


@pytest.mark.parametrize(
    "line, expected",
    [
        ("const a = b + c;", [("operator", "const a = b - c;")]),
        ("if (a <= b) return;", [("comparison", "if (a < b) return;")]),
        ("if (a === b) return;", [("comparison", "if (a !== b) return;")]),
        ("return a && b;", [("condition", "return a || b;")]),
        ("return [0, 10, 0.5, true];", [
            ("constant", "return [0, 10, 0.5, false];"),
            ("constant", "return [1, 10, 0.5, true];"),
        ]),
        ("return Math.min(a, b);", [
            ("min for max", "return Math.max(a, b);"),
            ("swapped arguments", "return Math.min(b, a);"),
        ]),
        ("return a.at(-1)", [("constant", "return a.at(-0)"), ("first for last", "return a[0]")]),
        ("return a[0];", [("constant", "return a[1];"), ("first for last", "return a.at(-1);")]),
        ("this.a = b;", [("stale value", ";")]),
        ("this.socket?.close();", [("missing close", ";")]),
        ("clearTimeout(this.timer);", [("missing close", ";")]),
        ("this.show(a);", [("dropped statement", ";")]),
        ("send(a);", [("dropped statement", ";"), ("effect twice", "send(a); send(a);")]),
    ],
)  # fmt: skip
def test_fault(line: str, expected: List[Tuple[str, str]]) -> None:
    assert changes(line) == expected


@pytest.mark.parametrize(
    "line",
    [
        "// a + b, true and f(a, b)",
        "const a = 'b + c';",
        "const a = `f(b, ${c + 1})`;",
        "const a = b;",
        "return send(a);",
        "const f = (a, b) => a;",
    ],
)
def test_texts_and_definitions_stay(line: str) -> None:
    assert changes(line) == []


def test_element_that_is_set_stays_an_element() -> None:
    assert changes("a[0] = b;") == [("constant", "a[1] = b;")]


def test_continued_expression_is_not_dropped() -> None:
    assert changes("const a =\n    send(b);") == []
