"""Time available to a node itself, as seen from outside: none if the machine is busy."""

import rospy

from nodekit.testing.waiting import wait_until

#: Any parameter of these nodes that refuses to be negative.
_PARAMETERS = {"motor_sys": "sample_time", "sp_gen": "rate"}


def wait_for_put_backs(node: str, count: int) -> None:
    """Wait until a node has put a refused value back several times.

    It does so only after it has read the value twice, 20 ms apart, which is a period of the motor.

    :param node: its global name
    :param count: how often
    """
    key = f"{node}/{_PARAMETERS[node.rpartition('/')[2]]}"
    kept = rospy.get_param(key)
    for _ in range(count):
        rospy.set_param(key, -1.0)
        wait_until(lambda: rospy.get_param(key) == kept, lambda: f"{key} is not put back")
