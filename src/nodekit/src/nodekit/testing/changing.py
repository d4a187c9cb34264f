"""Changes of a node's parameters that are in effect on return."""

from typing import Any

import rospy

from nodekit.node.parameter_client import ParameterClient


def change(node: str, **values: Any) -> None:
    """Change parameters; the node handles later messages with the new values.

    After ``rosparam set`` that moment is unknown: the node logs the change before its class is
    notified.

    :param node: global name of the node
    :param values: new values by name
    :raises ChangeRefused: if the node rejects one of them
    """
    rospy.wait_for_service(f"{node}/change", 30.0)
    ParameterClient(node, timeout=30.0).change(values)
