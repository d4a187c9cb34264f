"""Tests of the selection of steps by the words of ci/test and by changed files."""

import pathlib
from typing import Dict, List, Set

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.tiers import tier_plan
from ci.tiers.selection import TIERS, Selection, UnknownWord, of_change
from ci.tiers.times import Times, estimate
from ci.tiers.workspace import dependencies, packages, with_dependents

NEEDS: Dict[str, Set[str]] = {"base": set(), "middle": {"base"}, "top": {"middle"}, "other": set()}
NO_TIMES = Times(pathlib.Path("/nowhere"))


def chosen(*words: str) -> Selection:
    selection = Selection()
    for word in words:
        selection.add_word(word, set(NEEDS), pathlib.Path("/"))
    return selection


def test_a_package_has_its_lint_its_units_and_its_integration_tests() -> None:
    assert chosen("middle").packages == {
        tier: {"middle"} for tier in ("lint", "unit", "integration")
    }


def test_unknown_word_is_an_error_with_a_hint() -> None:
    with pytest.raises(UnknownWord, match="'midle' is not a tier, .*--list"):
        chosen("midle")


def test_a_place_may_name_a_test(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "test_a.py"
    file.write_text("")
    selection = Selection()
    selection.add_word(f"{file}::test_b", set(), tmp_path)
    (step,) = tier_plan.plan(selection, NO_TIMES)
    assert step.command[-1] == f"{file}::test_b"


def test_file_that_is_not_a_test_is_refused(tmp_path: pathlib.Path) -> None:
    selection = Selection(places=[(tmp_path / "notes.md", "")])
    with pytest.raises(UnknownWord, match="is not a test file"):
        tier_plan.plan(selection, NO_TIMES)


@pytest.mark.parametrize(
    "files, packages_, whole",
    [
        (["src/base/src/base/a.py"], {"base", "middle", "top"}, ["docs"]),
        (["src/top/test/unit/test_a.py"], {"top"}, ["docs"]),
        (["ci/tiers/steps.py"], {"ci"}, ["ci"]),
        (["pyproject.toml"], {"ci"}, ["ci"]),
        (["docs/design.md"], set(), ["docs"]),
        (["README.md"], {"ci"}, ["ci", "docs"]),
        (["src/CMakeLists.txt"], set(), []),
        ([], set(), []),
    ],
)
def test_change_selects_dependent_packages(
    files: List[str], packages_: Set[str], whole: List[str]
) -> None:
    selection = of_change(files, NEEDS, "HEAD~1")
    assert selection.packages.get("lint", set()) == packages_
    assert selection.whole == whole
    assert selection.pages_since == ("HEAD~1" if "docs" in whole else "")


def test_dependencies_are_read_from_the_manifests() -> None:
    assert {"nodekit", "basic_comms"} <= dependencies()["motor_control"]
    assert "motor_control" in with_dependents({"first_order_sys_sim"}, dependencies())


def test_each_tier_and_each_package_has_steps() -> None:
    for tier in TIERS:
        assert tier_plan.steps_of(tier, None, NO_TIMES) or tier == "extended", tier
    for package in packages():
        selection = Selection()
        selection.add_package(package.name)
        assert tier_plan.plan(selection, NO_TIMES), package.name


def test_each_rostest_file_is_run_by_one_step() -> None:
    files = [
        str(path)
        for folder in ("integration", "extended")
        for path in tier_plan.SOURCES.glob(f"*/test/{folder}/*.test")
    ]
    steps = tier_plan.plan(Selection(whole=["integration", "extended"]), NO_TIMES)
    run = [word for step in steps for word in step.command if word.endswith(".test")]
    assert sorted(run) == sorted(files)


def test_each_file_of_the_tests_of_ci_is_run() -> None:
    steps = tier_plan.plan(Selection(whole=["ci", "install", "catkin_build"]), NO_TIMES)
    places = [pathlib.Path(word) for step in steps for word in step.command]
    files = sorted((tier_plan.CI / "tests").rglob("test_*.py"))
    assert files
    for file in files:
        assert any(place in (file, file.parent) for place in places), file


@given(st.lists(st.floats(0.0, 100.0)), st.integers(1, 4))
def test_an_estimate_is_between_the_longest_step_and_all_of_them(
    durations: List[float], lanes: int
) -> None:
    least = max([sum(durations) / lanes, *durations])
    assert least - 1e-6 <= estimate(durations, lanes) <= sum(durations) + 1e-6
