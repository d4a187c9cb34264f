"""ci/mutants runs the tests that belong to a module, and tells what they let pass."""

import json
from typing import Any, Optional

import pytest

from ci.lint import code_rules
from ci.mutation import pure_modules as mutants

DIFF = """--- mutation diff ---
--- a/src/a.py
+++ b/src/a.py
@@ -1,3 +1,3 @@
 if this:
-    return -1
+    return 1
"""


def test_each_pure_module_has_unit_tests() -> None:
    modules = mutants.modules_of([])
    names = {path.name for path in modules}
    assert {"reconciler.py", "timetable.py", "conditioner.py"} <= names
    assert "scheduler.py" not in names and "__init__.py" not in names
    assert all(mutants.tests_of(module) for module in modules)


def test_each_row_of_the_table_is_of_a_pure_module() -> None:
    places = [path.relative_to(code_rules.SOURCES) for path in mutants.modules_of([])]
    assert set(mutants.TESTS) <= {f"{path.parts[0]}/{path.stem}" for path in places}


def test_paths_are_files_and_folders_each_module_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    library = code_rules.SOURCES / "nodekit" / "src" / "nodekit"
    monkeypatch.chdir(library)
    found = mutants.modules_of(["parameters/kinds.py", "parameters"])
    assert found[0] == library / "parameters" / "kinds.py"
    assert found.count(found[0]) == 1
    assert {path.parent.name for path in found} == {"parameters"}


@pytest.mark.parametrize("path", ["nowhere", "nodekit/test", "nodekit/package.xml"])
def test_a_path_without_modules_is_refused(monkeypatch: "pytest.MonkeyPatch", path: str) -> None:
    monkeypatch.chdir(code_rules.SOURCES)
    with pytest.raises(mutants.Unfit, match=path):
        mutants.modules_of([path])


def test_a_module_without_tests_is_refused_by_name() -> None:
    scheduler = code_rules.SOURCES / "nodekit" / "src" / "nodekit" / "timing" / "scheduler.py"
    with pytest.raises(mutants.Unfit, match=r"timing/scheduler\.py has no test_scheduler\.py"):
        mutants.tests_of(scheduler)


def mutant(line: int, test: Optional[str], output: str = "", worker: str = "normal") -> str:
    """Return a line as cosmic-ray writes it."""
    item: Any = {"mutations": [{"module_path": "src/a.py", "start_pos": [line, 4]}]}
    return json.dumps(
        [item, dict(worker_outcome=worker, test_outcome=test, output=output, diff=DIFF)]
    )


def test_figures_are_of_what_was_tried() -> None:
    lines = [
        mutant(20, "survived"),
        mutant(5, "killed", "1 failed"),
        mutant(6, "killed", "timeout"),
        mutant(7, None, worker="skipped"),
        mutant(3, "survived"),
    ]
    found = mutants.tally("\n".join(lines))
    assert found.survivors == [
        "src/a.py:3: - return -1  + return 1",
        "src/a.py:20: - return -1  + return 1",
    ]
    assert found.line("src/a.py") == "src/a.py: 2 of 4 killed, 50.0 %, 1 of them by the time limit"


def test_a_module_without_mutants_is_a_good_one() -> None:
    assert mutants.tally("") == (0, 0, [])
    assert mutants.tally("").line("src/a.py") == "src/a.py: 0 of 0 killed, 100.0 %"


@pytest.mark.parametrize(
    "line", [mutant(1, "incompetent", "a reason"), '[{"mutations": []}, null]']
)
def test_a_mutant_that_was_not_tried_counts_neither_way(line: str) -> None:
    with pytest.raises(mutants.Unfit, match="a reason|None"):
        mutants.tally(line)


def test_a_change_is_told_in_one_line() -> None:
    assert mutants.change("-@property\n def a():") == "- @property"
    assert mutants.change("-    a(\n-        b)\n+    c") == "- a( b)  + c"
