#!/usr/bin/env python3
"""Many independent pairs of motor and set point, each motor with its own parameters."""

import unittest

import rosgraph
import rospy
from std_msgs.msg import Float32

from motor_control_msgs.srv import SetProcessBool
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

GROUPS = [f"/group{number}" for number in range(1, 4)]
#: Five groups of two nodes each, on a machine that may have other things to do.
TIMEOUT = 90.0


class Motors(unittest.TestCase):
    """All of them, started at the same time."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_motors")

    def test_all_run_and_only_their_own_topics_connect_them(self) -> None:
        recorders = [MessageRecorder(group + "/motor_speed_y", Float32) for group in GROUPS]
        for recorder in recorders:
            recorder.wait_for(lambda heard: heard.data != 0.0, TIMEOUT)
            recorder.close()
        publishers, subscribers, _ = rosgraph.Master("/test").getSystemState()
        for group in GROUPS:
            self.assertEqual(dict(publishers)[group + "/motor_input_u"], [group + "/sp_gen"])
            self.assertEqual(dict(subscribers)[group + "/motor_input_u"], [group + "/motor_sys"])
        self.assertNotIn("/motor_input_u", dict(publishers))

    def test_disabling_one_leaves_the_others_alone(self) -> None:
        one, other = (MessageRecorder(group + "/motor_speed_y", Float32) for group in GROUPS[:2])
        one.wait_for(lambda heard: heard.data != 0.0, TIMEOUT)
        rospy.ServiceProxy(GROUPS[0] + "/EnableProcess", SetProcessBool)(False)
        wait_until(lambda: one.messages()[-1].data == 0.0, lambda: "it does not stop")
        one.clear()
        other.clear()
        wait_until(lambda: len(other.messages()) > 20, lambda: "the other one stopped too")
        self.assertEqual(one.messages(), [])
        rospy.ServiceProxy(GROUPS[0] + "/EnableProcess", SetProcessBool)(True)
        one.wait_for(lambda heard: heard.data != 0.0, TIMEOUT)

    def test_parameters_from_yaml_reach_the_motors(self) -> None:
        for motor, gain, tau in (
            ("/lab/group1/motor_sys_1", 4.0, 0.9),
            ("/lab/group2/motor_sys_2", 1.75, 0.5),
        ):
            self.assertEqual(rospy.get_param(motor + "/sys_gain_K"), gain)
            self.assertEqual(rospy.get_param(motor + "/sys_tau_T"), tau)
        # The set points publish the same sine of amplitude 2, so only one speed exceeds 3.5.
        strong, weak = (
            MessageRecorder(f"/lab/group{number}/motor_speed_y", Float32) for number in (1, 2)
        )
        strong.wait_for(lambda heard: abs(heard.data) > 3.6, TIMEOUT)
        weak.wait_for(lambda heard: abs(heard.data) > 1.0, TIMEOUT)
        self.assertLess(max(abs(heard.data) for heard in weak.messages()), 3.5)


if __name__ == "__main__":
    rosrun("motor_control", "motors", Motors)
