"""Tests of the report of a mutation run: survivors, rates, known equivalents."""

import pathlib

import pytest

from ci.mutation import results
from ci.mutation.mutants import Mutant
from ci.mutation.results import Results, figures


def mutant(name: str, kind: str = "loop", module: str = "p/a.py") -> Mutant:
    return Mutant(module, kind, name, f"{name} changed", 3, f"`{name}` → `pass`")


@pytest.fixture(autouse=True)
def equivalent(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> pathlib.Path:
    """Return a list of known equivalents, empty at first, and a module of three lines."""
    module = tmp_path / "src" / "p" / "a.py"
    module.parent.mkdir(parents=True)
    module.write_text("one\ntwo\nthree\n")
    monkeypatch.setattr(results, "SOURCES", tmp_path / "src")
    monkeypatch.setattr(results, "EQUIVALENT", tmp_path / "survivors.md")
    (tmp_path / "survivors.md").write_text("")
    return tmp_path / "survivors.md"


def test_rate_has_its_interval() -> None:
    assert figures([True] * 78 + [False] * 40) == "78 of 118 killed, 66.1 % (95 %: 57 to 74)"
    assert figures([]) == "0 of 0 killed, 100.0 % (95 %: 0 to 100)"


def test_run_resumes_where_the_last_one_ended(tmp_path: pathlib.Path) -> None:
    asked = [mutant("one"), mutant("two", "operator"), mutant("three")]
    first = Results(tmp_path, asked)
    first.add(asked[0], "p/unit: test_one: 1 != 2", [])
    first.add(asked[1], "", ["p/slow: 1 != 2"])
    assert (tmp_path / "report.txt").read_text("utf-8") == (
        "left out, as it fails without a mutant: p/slow: 1 != 2\n"
        "survived: src/p/a.py:3: operator: `two` → `pass`\n"
        "kind loop: 1 of 1 killed, 100.0 % (95 %: 21 to 100)\n"
        "kind operator: 0 of 1 killed, 0.0 % (95 %: 0 to 79)\n"
        "package p: 1 of 2 killed, 50.0 % (95 %: 9 to 91)\n"
        "1 of 2 killed, 50.0 % (95 %: 9 to 91); wanted are 90 %; 3 were drawn;"
        " 0 more do the same by survivors.md\n"
        "killed:\n"
        "src/p/a.py:3: loop: `one` → `pass`\n"
        "    p/unit: test_one: 1 != 2\n"
    )
    # Killed mutants are not tested again; survivors are, after the others.
    assert Results(tmp_path, asked).waiting() == [asked[2], asked[1]]


def test_ninety_percent_are_good(tmp_path: pathlib.Path) -> None:
    asked = [mutant(str(number)) for number in range(10)]
    found = Results(tmp_path, asked)
    assert found.is_good()
    for one in asked[1:]:
        found.add(one, "a test", [])
    found.add(asked[0], "", [])
    assert found.is_good()
    found.add(asked[1], "", [])
    assert not found.is_good()


def test_known_equivalent_counts_neither_way(
    tmp_path: pathlib.Path, equivalent: pathlib.Path
) -> None:
    equivalent.write_text("- `src/p/a.py`: `one` → `pass`: it is replaced before it is read\n")
    found = Results(tmp_path, [mutant("one"), mutant("two")])
    found.add(mutant("one"), "", [])
    found.add(mutant("two"), "a test", [])
    assert found.is_good() and not found.outdated()
    assert "\n1 of 1 killed" in found.summary() and "; 1 more do the same" in found.summary()


@pytest.mark.parametrize(
    "row, killer",
    [
        ("`src/p/a.py`: `one` → `pass`", "a test"),
        ("`src/p/a.py`: `four` → `pass`", ""),
        ("`src/p/gone.py`: `one` → `pass`", ""),
    ],
)
def test_row_without_survivor_is_reported(
    tmp_path: pathlib.Path, equivalent: pathlib.Path, row: str, killer: str
) -> None:
    equivalent.write_text(f"- {row}: why\n")
    found = Results(tmp_path, [mutant("one")])
    found.add(mutant("one"), killer, [])
    said = (
        f"in survivors.md, but no survivor: {row.replace('`src', 'src', 1).replace('`:', ':', 1)}"
    )
    assert said in found.summary()


def test_page_has_a_rate_of_its_own(tmp_path: pathlib.Path) -> None:
    asked = [mutant("one", module="p/www/js/a.js"), mutant("two")]
    found = Results(tmp_path, asked)
    for one in asked:
        found.add(one, "a test", [])
    assert "package p, page: 1 of 1" in found.summary() and "package p: 1 of 1" in found.summary()


def test_every_row_is_of_a_line_that_exists(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.undo()
    assert Results(pathlib.Path("nowhere"), []).outdated() == []
