"""Talker node: publishes a text periodically."""

from functools import partial
from typing import Any, Dict, Optional

import rospy
from std_msgs.msg import String

from basic_comms.message_scope import SCOPES, as_text, candidates, message_text
from nodekit import EnumParameter, Node, ParameterSet, RateParameter, run


class TalkerParameters(ParameterSet):
    """Private parameters of the talker."""

    rate = RateParameter(10.0, help="messages published per second")
    message_scope = EnumParameter(
        "closest",
        choices=SCOPES,
        help="where Message is looked up: in one namespace, or from the node's own outwards",
    )


class Talker:
    """Publishes ``<Message> <ROS time>`` at a rate.

    :ROS Publishers:
        - ``chatter`` (std_msgs/String)

    :ROS Parameters:
        - private: see :class:`TalkerParameters`
        - ``Message`` (any scalar), at ``~``, in the enclosing namespaces and at ``/``: the text;
            read at run time, never written
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(TalkerParameters, exempt=["Message"])
        self._places = candidates(node.name)
        self._texts: Dict[str, Optional[str]] = {}
        for place in self._places:
            node.on_parameter(place, partial(self._set_text, place))
        self._publisher = node.create_publisher("chatter", String)
        self._log = node.create_rate_limited_log()
        node.create_timer(lambda: self._settings.values.rate, self._publish)

    def _set_text(self, place: str, value: Any) -> None:
        self._texts[place] = as_text(value)

    def _publish(self, _elapsed: float) -> None:
        message = message_text(self._texts, self._places, self._settings.values.message_scope)
        text = f"{message} {rospy.get_time()}"
        self._log.line(text)
        self._publisher.publish(text)


def main() -> None:
    """Run the node until it is shut down."""
    run("talker", Talker)
