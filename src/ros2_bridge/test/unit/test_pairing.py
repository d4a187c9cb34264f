"""What is bridged, which way, and until when."""

from ros2_bridge.rules.pairing import Patience, Rules, Way, ranked, wanted
from ros2_bridge.rules.renaming import Renaming

ALL = Rules(True, True, ["*"], [])


def test_what_either_side_has_goes_to_the_other() -> None:
    ways = wanted(ALL, {"/b", "/both"}, {"/a", "/both"})
    assert ways == [
        Way("/a", False),
        Way("/b", True),
        Way("/both", False),
        Way("/both", True),
    ]


def test_a_way_can_be_shut() -> None:
    assert wanted(ALL._replace(to_ros1=False), {"/b"}, {"/a"}) == [Way("/b", True)]
    assert wanted(ALL._replace(to_ros2=False), {"/b"}, {"/a"}) == [Way("/a", False)]


def test_patterns() -> None:
    rules = Rules(True, True, ["/robot/*", "/tf"], ["*/secret"])
    allowed = [
        name for name in ("/robot/a/b", "/tf", "/tf_static", "/robot/secret") if rules.allows(name)
    ]
    assert allowed == ["/robot/a/b", "/tf"]


def test_what_each_ros_has_for_itself_is_left_alone() -> None:
    for name in ("/rosout", "/parameter_events", "/n/get_loggers", "/a/_action/status"):
        assert not ALL.allows(name)
    assert ALL.allows("/tf_static") and ALL.allows("/clock")


def test_patterns_are_of_names_in_ros1() -> None:
    rules = Rules(True, True, ["/robot1/*"], ["/robot1/secret"], Renaming(["/robot1=/"]))
    assert rules.allows("/robot1/scan")
    assert not rules.allows("/scan") and not rules.allows("/robot1/secret")
    assert not rules.allows("/robot1/rosout")  # ROS 2 has that for itself
    assert not rules._replace(allow=["*"]).allows("/scan")  # /robot1/scan is called so there


def test_who_appears_already_comes_first_then_kind_by_kind() -> None:
    nodes, parts = {"/d", "/b", "/a"}, {"/c", "/b", "/aa"}
    assert ranked([], nodes, parts) == ["/a", "/b", "/d", "/aa", "/c"]
    assert ranked(["/gone", "/c", "/b"], nodes, parts) == ["/c", "/b", "/a", "/d", "/aa"]


def test_gone_is_what_is_missing_look_after_look() -> None:
    patience: Patience[str] = Patience(3)
    there = {"a": 1, "b": 2}
    assert patience.gone(there, ["a"]) == []
    assert patience.gone(there, ["a"]) == []
    assert patience.gone(there, ["a", "b"]) == []  # it was back: counted anew
    for _ in range(2):
        assert patience.gone(there, ["a"]) == []
    assert patience.gone(there, ["a"]) == ["b"]
