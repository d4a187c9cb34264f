"""Discovery of action servers among the topics of ROS 1 and the services of ROS 2."""

from typing import Dict, Mapping, NamedTuple, Set, Tuple

#: The topics of an action in ROS 1, and what the names of their types end with.
TOPICS = {
    "goal": "ActionGoal",
    "cancel": "actionlib_msgs/GoalID",
    "status": "actionlib_msgs/GoalStatusArray",
    "feedback": "ActionFeedback",
    "result": "ActionResult",
}
#: Ends of the service that a client of ROS 2 sends its goals to, and of its type.
_SERVICE, _TYPE = "/_action/send_goal", "_SendGoal"


class Server(NamedTuple):
    """A server of an action.

    :param kind: type of the action, as its ROS names it: ``package/Name``, ``package/action/Name``
    :param node: that offers it
    """

    kind: str
    node: str


def is_of_action(topic: str, datatype: str) -> bool:
    """Tell whether a topic of ROS 1 is a part of an action, which is bridged as a whole."""
    end = TOPICS.get(topic.rpartition("/")[2])
    return end is not None and datatype.endswith(end)


def servers_in_ros1(
    publishers: Mapping[str, Set[str]],
    subscribers: Mapping[str, Set[str]],
    types: Mapping[str, str],
) -> Dict[str, Server]:
    """Return the action servers of ROS 1 by the names of their actions.

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
    """Return the action servers of ROS 2 by the names of their actions in ROS 2.

    :param services: type and node by name
    """
    return {
        name[: -len(_SERVICE)]: Server(kind[: -len(_TYPE)], node)
        for name, (kind, node) in services.items()
        if name.endswith(_SERVICE) and kind.endswith(_TYPE)
    }
