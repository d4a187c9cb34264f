"""Parameter changes for tests: the node uses the new values once the call returns."""

from typing import Any

import rospy

from nodekit.node.parameter_client import ParameterClient
from nodekit.testing.waiting import TIMEOUT_S


def change(node: str, **values: Any) -> None:
    """Change parameters; the node handles later messages with the new values.

    ``rosparam set`` does not wait, and the node logs a change before it notifies its class.

    :param node: global name of the node
    :param values: new values by name
    :raises ChangeRefused: if the node rejects one of them
    """
    rospy.wait_for_service(f"{node}/change", TIMEOUT_S)
    ParameterClient(node, timeout=TIMEOUT_S).change(values)
