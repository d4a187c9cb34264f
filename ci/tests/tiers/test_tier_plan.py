"""Tests of the steps that a selection of tests consists of."""

import pathlib

import pytest

from ci.tiers import tier_plan
from ci.tiers.times import Times

UNMARKED = "def test_quick() -> None: ...\n"
MARKED = "import pytest\n@pytest.mark.extended\ndef test_slow() -> None: ...\n"


def test_marked_unit_tests_belong_to_the_extended_tier_alone(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    for package, text in ("one", UNMARKED), ("two", UNMARKED + MARKED):
        folder = tmp_path / package / "test" / "unit"
        folder.mkdir(parents=True)
        (folder / "test_some.py").write_text(text)
    packages = [tmp_path / "one", tmp_path / "two"]
    monkeypatch.setattr(tier_plan, "packages", lambda: packages)
    units = tier_plan.unit()
    assert [step.name for step in units] == ["one", "two"]
    assert all(step.command[-2:] == ["-m", "not extended"] for step in units)
    (extended,) = tier_plan.extended(None, Times(tmp_path / "times.json"))
    assert extended.name == "two, unit" and extended.command[-2:] == ["-m", "extended"]
    assert str(tmp_path / "two" / "test" / "unit" / "test_some.py") in extended.command
    assert tier_plan.extended({"one"}, Times(tmp_path / "times.json")) == []


def test_a_single_test_with_ros2_waits_for_the_environment() -> None:
    environment, test = tier_plan.single(pathlib.Path("a/test/ros2/test_some.py"), "test_one")
    assert environment.command[0].endswith("ci/ros2")
    assert (test.tier, test.after) == (environment.tier, environment.name)


def test_tests_with_ros2_are_divided_by_their_durations(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    folder = tmp_path / "one" / "test" / "ros2"
    folder.mkdir(parents=True)
    times = Times(tmp_path / "times.json")
    for name, seconds in ("a", 90.0), ("b", 40.0), ("c", 45.0), ("d", 30.0), ("e", 5.0):
        (folder / f"test_{name}.py").write_text("")
        times.add(f"one/test/ros2/test_{name}.py", seconds, 0.0)
    for name in "SOURCES", "WORKSPACE":
        monkeypatch.setattr(tier_plan, name, tmp_path)
    environment, *steps, recordings = tier_plan.ros2(None, times)
    assert [step.name for step in steps] == [f"clients {number}/4" for number in range(1, 5)]
    files = [[one[-4] for one in step.command if one.endswith(".py")] for step in steps]
    assert sorted(map(sorted, files)) == [["a"], ["b"], ["c"], ["d", "e"]]
    assert {step.after for step in steps} == {environment.name} and not recordings.after
    of_package = tier_plan.ros2({"one"}, times)[1:-1]
    assert [step.command for step in of_package] == [
        [*step.command, "-m", "not extended"] for step in steps
    ]
