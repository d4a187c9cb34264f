"""Change parameters of a node, and know when it goes by them."""

from typing import Any

import rospy

from nodekit.node.parameter_client import ParameterClient


def change(node: str, **values: Any) -> None:
    """Change parameters; a message that is sent after this finds the node with the new values.

    After ``rosparam set`` nothing tells of that: what the log says comes before the node's class
    hears of it.

    :param node: its global name
    :param values: by name
    :raises ChangeRefused: if the node refuses them
    """
    rospy.wait_for_service(f"{node}/change", 30.0)
    ParameterClient(node, timeout=30.0).change(values)
