"""Tests of the draw of mutants, and of the selection of a module's tests."""

import pathlib
from typing import Any, Dict, List, Sequence, Set

import pytest

from ci.lint import code_rules
from ci.mutation import mutants
from ci.mutation.nearest import unit_tests

SOURCES = code_rules.SOURCES


def names(*arguments: Any) -> Set[str]:
    return {str(path.relative_to(SOURCES)) for path in mutants.modules_of(*arguments)}


def test_pure_modules_by_default() -> None:
    found = names(False, [], [])
    assert "nodekit/src/nodekit/timing/timetable.py" in found
    assert "topic_scope/src/topic_scope/analysis/steps.py" in found
    others = ("scheduler.py", "__init__.py", ".js", "/scripts/")
    assert not [path for path in found if any(other in path for other in others)]


def test_wiring_is_every_other_module_and_the_page() -> None:
    found = names(True, [], [])
    assert "nodekit/src/nodekit/node/ros_node.py" in found
    assert "topic_scope/www/js/state/sweep.js" in found
    others = ("/nodekit/transport/", "/nodekit/testing/", "/scripts/", "__init__.py")
    assert not [path for path in found if any(other in path for other in others)]
    assert not found & names(False, [], [])


def test_only_some_packages() -> None:
    found = names(True, ["nodekit", "serial_link"], [])
    assert {path.split("/")[0] for path in found} == {"nodekit", "serial_link"}


def test_paths_are_files_and_folders_each_module_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    library = SOURCES / "nodekit" / "src" / "nodekit"
    monkeypatch.chdir(library)
    found = mutants.modules_of(False, [], ["parameters/parameter_types.py", "parameters"])
    assert found.count(library / "parameters" / "parameter_types.py") == 1
    assert {path.parent.name for path in found} == {"parameters"}
    assert names(True, ["topic_scope"], [str(SOURCES / "topic_scope" / "www")]) == {
        path for path in names(True, [], []) if path.endswith(".js")
    }


@pytest.mark.parametrize("path", ["nowhere", "nodekit/test", "nodekit/package.xml"])
def test_path_without_modules_is_rejected(monkeypatch: "pytest.MonkeyPatch", path: str) -> None:
    monkeypatch.chdir(SOURCES)
    with pytest.raises(mutants.Unfit, match=path):
        mutants.modules_of(False, [], [path])


@pytest.mark.parametrize("name", ["nowhere", "lifecycle_msgs"])
def test_package_without_modules_is_rejected(name: str) -> None:
    with pytest.raises(mutants.Unfit, match=name):
        mutants.modules_of(True, ["nodekit", name], [])


def listed(text: str, kinds: Sequence[str]) -> List[Dict[str, Any]]:
    """Return a mutant of each line and type, as cosmic.py would list them."""
    module = str(SOURCES / "p" / "a.py")
    return [
        dict(module=module, kind=kind, place=f"f: {line}", recipe=[line, kind])
        for line in text.split()
        for kind in kinds
    ]


@pytest.fixture
def draw(monkeypatch: "pytest.MonkeyPatch") -> Any:
    """Draw from the lines of a text instead of from modules."""

    def draw_from(text: str, count: int, seed: int, kinds: Sequence[str] = ("operator",)) -> Any:
        found = listed(text, kinds)

        def ask(tool: str, **request: Any) -> List[Any]:
            return found if "list" in request else [f"{text} #{it}" for it in request["make"]]

        monkeypatch.setattr(mutants, "ask", ask)
        monkeypatch.setattr(pathlib.Path, "read_text", lambda *_: text)
        return mutants.draw("", [], count, seed)

    return draw_from


def test_draw_hardly_depends_on_other_lines_and_only_on_the_seed(draw: Any) -> None:
    text = " ".join(f"line{number}" for number in range(100))
    keys = {one.key for one in draw(text, 20, 1)}
    assert len(keys) == 20 and keys == {one.key for one in draw(text, 20, 1)}
    assert len(keys & {one.key for one in draw(f"other {text}", 20, 1)}) >= 19
    assert keys != {one.key for one in draw(text, 20, 2)}


def test_draw_is_balanced_over_the_types(draw: Any) -> None:
    kinds = [one.kind for one in draw("a b c", 8, 1, ["loop", "operator", "constant"])]
    assert all(kinds.count(kind) >= 2 for kind in ("loop", "operator", "constant"))
    assert len(draw("a b c", 100, 1, ["loop"])) == 3


def test_equal_lines_are_distinguished(draw: Any) -> None:
    assert len({one.key for one in draw("a a a", 9, 1)}) == 3


@pytest.mark.parametrize(
    "mutated, expected",
    [
        ("a\nb - c\nd\n", (2, "`b + c` → `b - c`")),
        ("a\nb + c; b + c\nd\n", (2, "`b + c` → `b + c; b + c`")),
        ("a\nd\n", (2, "`b + c` → ``")),
        ("a\nb +\n  e\nd\n", (2, "`b + c` → `b + e`")),
    ],
)
def test_change_is_reported_in_one_line(mutated: str, expected: object) -> None:
    assert mutants.change_of("a\nb + c\nd\n", mutated) == expected


def test_every_pure_module_has_unit_tests() -> None:
    modules = mutants.modules_of(False, [], [])
    places = [str(path.relative_to(SOURCES)) for path in modules]
    assert [path for path in places if not unit_tests(SOURCES / path.split("/")[0], path)] == []


def test_nearest_unit_tests_come_first() -> None:
    package = SOURCES / "topic_scope"
    found = unit_tests(package, "topic_scope/src/topic_scope/web/scope_session.py")
    assert found[0].name == "test_scope_session.py"
    assert package / "test" / "unit" / "test_ring.py" not in found


def test_unit_tests_are_found_through_their_helpers(tmp_path: pathlib.Path) -> None:
    unit = tmp_path / "nodekit" / "test" / "unit"
    unit.mkdir(parents=True)
    (unit / "helper.py").write_text("from nodekit.timing import timetable\n")
    (unit / "test_a.py").write_text("import helper\n")
    (unit / "test_b.py").write_text("import math\n")
    (unit / "test_c.py").write_text("from nodekit.timing.timetable import Timetable\n")
    (unit / "conftest.py").write_text("collect_ignore = ['test_c.py']\n")
    found = unit_tests(unit.parents[1], "nodekit/src/nodekit/timing/timetable.py")
    assert [test.name for test in found] == ["test_a.py"]


def test_script_of_the_page_has_the_unit_tests_that_name_it() -> None:
    found = unit_tests(SOURCES / "topic_scope", "topic_scope/www/js/base/link.js")
    assert [test.name for test in found] == ["test_requests.py"]
