"""Tests of the comparison of docs/courses.csv with the tests' ids."""

import pathlib

import pytest

from ci.lint import courses

#: Separate from the ids, so that this file names none.
NAME = "Course"
HEAD = "id,part,document,command,ours,test\n"


def test_each_item_has_a_test_that_carries_its_id() -> None:
    items = courses.rows((courses.WORKSPACE / "docs" / "courses.csv").read_text("utf-8"))
    assert len(items) > 90
    assert all(list(row) == HEAD.strip().split(",") for row in items)
    assert all(row["command"] and row["ours"] for row in items)
    assert list(courses.breaches(items, courses.WORKSPACE)) == []


@pytest.fixture
def workspace(tmp_path: pathlib.Path) -> pathlib.Path:
    """Return a workspace with a test and a page."""
    place = tmp_path / "src" / "one" / "test" / "unit"
    place.mkdir(parents=True)
    (place / "test_a.py").write_text(f'"""{NAME}s 001-a-1,\n001-a-2."""\nx = "001-a-3"\n')
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "page.md").write_text(f"001-a-4\n% {NAME} 001-a-5.\n")
    return tmp_path


TEST, PAGE = "src/one/test/unit/test_a.py", "docs/page.md"
#: Rows that agree with the workspace.
GOOD = [f"001-a-1,1,001,c,o,{TEST}", f"001-a-2,9,001,c,o,{TEST}", f"001-a-5,1,001,c,o,{PAGE}"]


@pytest.mark.parametrize(
    "row, sentence",
    [
        ("001-b-1,1,001,c,o,", "001-b-1: names no test; carried by none"),
        (f"001-a-3,1,001,c,o,{TEST}", f"001-a-3: {TEST} does not carry it"),  # in no docstring
        (f"001-a-4,1,001,c,o,{PAGE}", f"001-a-4: {PAGE} does not carry it"),  # in no comment
        ("001-b-1,9,001,c,o,src/one/test/none.py", "001-b-1: src/one/test/none.py does not"),
        (GOOD[0], "docs/courses.csv: 001-a-1 has more than one row"),
    ],
)
def test_differences_are_reported(workspace: pathlib.Path, row: str, sentence: str) -> None:
    items = courses.rows(HEAD + "\n".join([*GOOD, row]))
    [found] = courses.breaches(items, workspace)
    assert found.startswith(sentence)


def test_unknown_id_is_reported_and_a_missing_row_names_its_test(
    workspace: pathlib.Path,
) -> None:
    items = courses.rows(HEAD + f"001-a-1,1,001,c,o,\n{GOOD[2]}")
    assert list(courses.breaches(items, workspace)) == [
        f"{TEST}: 001-a-2 is not an id in docs/courses.csv",
        f"001-a-1: names no test; carried by {TEST}",
    ]
