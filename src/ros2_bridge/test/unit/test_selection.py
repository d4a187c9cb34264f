"""Selection of pairs, and their directions."""

from ros2_bridge.rules.selection import Rules, Route, parameter_services, rank_names, select_routes
from ros2_bridge.rules.renaming import Renaming

ALL = Rules(True, True, ["*"], [])


def test_names_of_each_side_are_bridged_to_the_other() -> None:
    routes = select_routes(ALL, {"/b", "/both"}, {"/a", "/both"})
    assert routes == [
        Route("/a", False),
        Route("/b", True),
        Route("/both", False),
        Route("/both", True),
    ]


def test_direction_can_be_disabled() -> None:
    assert select_routes(ALL._replace(to_ros1=False), {"/b"}, {"/a"}) == [Route("/b", True)]
    assert select_routes(ALL._replace(to_ros2=False), {"/b"}, {"/a"}) == [Route("/a", False)]


def test_patterns() -> None:
    rules = Rules(True, True, ["/robot/*", "/tf"], ["*/secret"])
    allowed = [
        name for name in ("/robot/a/b", "/tf", "/tf_static", "/robot/secret") if rules.allows(name)
    ]
    assert allowed == ["/robot/a/b", "/tf"]


def test_own_names_of_each_ros_are_not_bridged() -> None:
    for name in (
        *("/rosout", "/rosout_agg", "/parameter_events", "/statistics", "/a/_action/status"),
        *("/n/get_loggers", "/n/set_logger_level", "/n/get_type_description"),
        "/add/_service_event",
    ):
        assert not ALL.allows(name)
    assert ALL.allows("/tf_static") and ALL.allows("/clock")


def test_patterns_are_of_names_in_ros1() -> None:
    rules = Rules(True, True, ["/robot1/*"], ["/robot1/secret"], Renaming(["/robot1=/"]))
    assert rules.allows("/robot1/scan")
    assert not rules.allows("/scan") and not rules.allows("/robot1/secret")
    assert not rules.allows("/robot1/rosout")  # ROS 2 has that for itself
    assert not rules._replace(allow=["*"]).allows("/scan")  # /robot1/scan is called so there


def test_existing_names_rank_first_then_by_group() -> None:
    nodes, parts = {"/d", "/b", "/a"}, {"/c", "/b", "/aa"}
    assert rank_names([], nodes, parts) == ["/a", "/b", "/d", "/aa", "/c"]
    assert rank_names(["/gone", "/c", "/b"], nodes, parts) == ["/c", "/b", "/a", "/d", "/aa"]


def test_parameter_services_need_both_services() -> None:
    services = {"/a/describe", "/a/change", "/b/describe", "/c/change", "/describe", "/change"}
    found = {"/a/describe", "/a/change", "/describe", "/change"}
    assert parameter_services(services) == found
