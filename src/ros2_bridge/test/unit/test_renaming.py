"""Names that differ between the ROSes."""

from typing import List, Optional

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.rules.renaming import Renaming

BOTH = ["/robot1=/", "/common=/common", "/scan=/lidar/front"]
PREFIX = ["/=/ros1", "/ros2=/"]


@pytest.mark.parametrize(
    "rules, ros1, ros2",
    [
        ([], "/scan", "/scan"),
        (["/robot1/scan=/scan"], "/robot1/scan", "/scan"),
        (["/robot1/scan=/scan"], "/robot1/scan/info", "/scan/info"),
        (["/robot1/scan=/scan"], "/robot1/scanner", "/robot1/scanner"),
        (BOTH, "/robot1/odom", "/odom"),
        (BOTH, "/robot1/a/b", "/a/b"),
        (BOTH, "/common/map", "/common/map"),
        (BOTH, "/scan", "/lidar/front"),
        (PREFIX, "/scan", "/ros1/scan"),
        (PREFIX, "/ros2/scan", "/scan"),
    ],
)
def test_names_there_and_back(rules: List[str], ros1: str, ros2: str) -> None:
    names = Renaming(rules)
    assert names.in_ros2(ros1) == ros2
    assert names.in_ros1(ros2) == ros1


@pytest.mark.parametrize(
    "rules, ros1",
    [
        (["/robot1/scan=/scan"], "/scan"),  # that name is /robot1/scan's in ROS 2
        (BOTH, "/odom"),
        (BOTH, "/robot1"),  # the result would be empty
        (BOTH, "/robot1/common/map"),
    ],
)
def test_colliding_name_is_unmapped_in_ros2(rules: List[str], ros1: str) -> None:
    assert Renaming(rules).in_ros2(ros1) is None


def test_colliding_name_is_unmapped_in_ros1() -> None:
    names = Renaming(["/robot1/scan=/scan"])
    assert names.in_ros1("/robot1/scan") is None
    assert names.in_ros1("/odom") == "/odom"


NAMES = st.lists(st.sampled_from("abc"), min_size=1, max_size=4).map(lambda p: "/" + "/".join(p))
RULES = st.lists(
    st.tuples(NAMES | st.just("/"), NAMES | st.just("/")),
    max_size=4,
    unique_by=(lambda rule: rule[0], lambda rule: rule[1]),
)


@given(RULES, NAMES)
def test_renaming_is_invertible(rules: List[tuple], name: str) -> None:
    names = Renaming([f"{one}={other}" for one, other in rules])
    other: Optional[str] = names.in_ros2(name)
    assert other is None or names.in_ros1(other) == name
    other = names.in_ros1(name)
    assert other is None or names.in_ros2(other) == name


@pytest.mark.parametrize(
    "rules, words",
    [
        (["/a"], "each rule must be NAME=NAME.*'/a' is not"),
        (["a=/b"], "'a=/b' is not"),
        (["/a=/b/"], "'/a=/b/' is not"),
        (["/a=/2b"], "is not"),
        (["/a="], "is not"),
        (["/a=/b", "/a=/c"], "in one rule only; '/a=/c' repeats one"),
        (["/a=/c", "/b=/c"], "in one rule only"),
    ],
)
def test_nonsense_is_refused(rules: List[str], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Renaming(rules)
