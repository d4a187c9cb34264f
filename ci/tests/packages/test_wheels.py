"""ci/ros2-wheels writes a list of versions and hashes from what pip reports."""

from typing import Any, List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.packages import wheels
from ci.packages.wheels import Wheel

WHEELS = st.builds(
    Wheel,
    st.sampled_from(["numpy", "PyYAML", "ros-rclpy"]),
    st.just("7.1.6"),
    st.text("0123456789abcdef", min_size=64, max_size=64),
)


def report(*found: Wheel) -> Any:
    """Return a report as pip 23 writes it, without what is not read."""
    return {
        "install": [
            {
                "download_info": {"archive_info": {"hashes": {"sha256": one.digest}}},
                "metadata": {"name": one.package, "version": one.version},
            }
            for one in found
        ]
    }


def test_list_has_each_package_once_with_all_its_hashes() -> None:
    found = [Wheel("ros-b", "1.2", "2f"), Wheel("a", "0.1", "3f"), Wheel("ros-b", "1.2", "1f")]
    text = wheels.requirements(wheels.wheels_in(report(*found)))
    assert text == (
        "a==0.1 \\\n    --hash=sha256:3f\n"
        "ros-b==1.2 \\\n    --hash=sha256:1f \\\n    --hash=sha256:2f\n"
    )


@given(st.lists(WHEELS))
def test_versions_are_read_back(found: List[Wheel]) -> None:
    text = wheels.HEADING + wheels.requirements(found)
    assert wheels.pins(text) == {one.package: one.version for one in found}


def test_oldest_python_chooses_for_all(monkeypatch: "pytest.MonkeyPatch") -> None:
    newest = {"3.9": "1.1", "3.11": "1.2"}
    asked = []

    def ask_pip(_: object, python: str, wanted: List[str]) -> List[Wheel]:
        asked.append((python, wanted))
        pinned = wheels.pins("\n".join(wanted)).get("a", newest[python])
        return [Wheel("a", pinned, f"for {python}")]

    monkeypatch.setattr(wheels, "PYTHONS", ((3, 11), (3, 9)))
    monkeypatch.setattr(wheels, "ask_pip", ask_pip)
    found = wheels.choose(wheels.WORKSPACE, ["a"])
    assert asked == [("3.9", ["a"]), ("3.11", ["a==1.1"])]
    assert found == [Wheel("a", "1.1", "for 3.9"), Wheel("a", "1.1", "for 3.11")]


def test_chosen_are_those_that_are_wanted() -> None:
    lines = wheels.WANTED.read_text("utf-8").splitlines()
    wanted = {line.partition("==")[0] for line in lines if line and not line.startswith("#")}
    assert "ros-rclpy" in wanted
    assert set(wheels.pins(wheels.CHOSEN.read_text("utf-8"))) == wanted
