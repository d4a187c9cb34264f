"""The action servers among the topics of ROS 1 and the services of ROS 2."""

from typing import Dict, Set

import pytest

from ros2_bridge.actions.discovery import Server, is_of_action, servers_in_ros1, servers_in_ros2

TYPES = {
    "/arm/reach/status": "actionlib_msgs/GoalStatusArray",
    "/arm/reach/feedback": "arm_msgs/ReachActionFeedback",
    "/arm/reach/result": "arm_msgs/ReachActionResult",
    "/arm/reach/goal": "arm_msgs/ReachActionGoal",
}
ENDS = ("status", "feedback", "result", "goal", "cancel")


def graph(node: str, *missing: str) -> "tuple[Dict[str, Set[str]], Dict[str, Set[str]]]":
    """Return publishers and subscribers of the topics of a server."""
    publishers = {f"/arm/reach/{end}": {node} for end in ENDS[:3] if end not in missing}
    subscribers = {f"/arm/reach/{end}": {node, "/echo"} for end in ENDS[3:] if end not in missing}
    return publishers, subscribers


def test_server_of_ros1_has_all_five_topics() -> None:
    assert servers_in_ros1(*graph("/arm"), TYPES) == {
        "/arm/reach": Server("arm_msgs/Reach", "/arm")
    }


@pytest.mark.parametrize("end", ENDS)
def test_incomplete_topics_are_not_a_server(end: str) -> None:
    assert servers_in_ros1(*graph("/arm", end), TYPES) == {}


def test_topics_of_several_nodes_make_no_server() -> None:
    publishers, subscribers = graph("/arm")
    publishers["/arm/reach/status"] = {"/other"}
    assert servers_in_ros1(publishers, subscribers, TYPES) == {}


@pytest.mark.parametrize(
    "topic, datatype, expected",
    [
        ("/arm/reach/cancel", "actionlib_msgs/GoalID", True),
        *((topic, datatype, True) for topic, datatype in TYPES.items()),
        ("/arm/status", "robot_msgs/Status", False),
        ("/arm/last_goal", "arm_msgs/ReachActionGoal", False),
        ("/arm/goal", "geometry_msgs/PoseStamped", False),
    ],
)
def test_topic_is_part_of_an_action_by_name_and_type(
    topic: str, datatype: str, expected: bool
) -> None:
    assert is_of_action(topic, datatype) is expected


def test_server_of_ros2_is_found_by_its_service() -> None:
    services = {
        "/arm/reach/_action/send_goal": ("arm_msgs/action/Reach_SendGoal", "/arm"),
        "/arm/reach/_action/get_result": ("arm_msgs/action/Reach_GetResult", "/arm"),
        "/add": ("arm_msgs/srv/Add", "/arm"),
    }
    assert servers_in_ros2(services) == {"/arm/reach": Server("arm_msgs/action/Reach", "/arm")}
