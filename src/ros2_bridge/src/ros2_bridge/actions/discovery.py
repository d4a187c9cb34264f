"""Discovery of action servers from ROS 1 topics and ROS 2 services."""

from typing import Dict, Mapping, NamedTuple, Set, Tuple

#: Topics of a ROS 1 action, with the endings of their type names.
TOPICS = {
    "goal": "ActionGoal",
    "cancel": "actionlib_msgs/GoalID",
    "status": "actionlib_msgs/GoalStatusArray",
    "feedback": "ActionFeedback",
    "result": "ActionResult",
}
#: Endings of the service for new goals in ROS 2, and of its type.
_SERVICE, _TYPE = "/_action/send_goal", "_SendGoal"


class Server(NamedTuple):
    """An action server.

    :param kind: action type in its own ROS: ``package/Name`` or ``package/action/Name``
    :param node: name of its node
    """

    kind: str
    node: str


def is_of_action(topic: str, datatype: str) -> bool:
    """Return whether a ROS 1 topic is part of an action, which is bridged as a whole."""
    end = TOPICS.get(topic.rpartition("/")[2])
    return end is not None and datatype.endswith(end)


def servers_in_ros1(
    publishers: Mapping[str, Set[str]],
    subscribers: Mapping[str, Set[str]],
    types: Mapping[str, str],
) -> Dict[str, Server]:
    """Return the ROS 1 action servers by action name.

    :param publishers, subscribers: names of nodes by topic
    :param types: types by topic
    """
    found = {}
    for topic, datatype in types.items():
        name, _, part = topic.rpartition("/")
        if part != "result" or not is_of_action(topic, datatype):
            continue
        nodes = set(publishers.get(topic, ()))
        for other in ("status", "feedback"):
            nodes &= publishers.get(f"{name}/{other}", set())
        for other in ("goal", "cancel"):
            nodes &= subscribers.get(f"{name}/{other}", set())
        if name and nodes:
            found[name] = Server(datatype[: -len(TOPICS["result"])], min(nodes))
    return found


def servers_in_ros2(services: Mapping[str, Tuple[str, str]]) -> Dict[str, Server]:
    """Return the ROS 2 action servers by action name.

    :param services: type and node by name
    """
    return {
        name[: -len(_SERVICE)]: Server(kind[: -len(_TYPE)], node)
        for name, (kind, node) in services.items()
        if name.endswith(_SERVICE) and kind.endswith(_TYPE)
    }
