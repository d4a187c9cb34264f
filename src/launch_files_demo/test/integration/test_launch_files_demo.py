#!/usr/bin/env python3
"""The course's launch files start the right nodes, which publish the right topics."""

import re
import unittest
from contextlib import ExitStack
from typing import Any

import numpy
import rospy
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image, LaserScan, Temperature

from launch_files_demo.nodes.lidar_demo_node import SCANNER
from launch_files_demo.temperature import VARIANCE, true_temperature
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.running import rosrun
from parameters_demo.picture import HEIGHT, WIDTH, Picture
from parameters_demo.room import scan


class LaunchFilesDemo(unittest.TestCase):
    """demo5 and demo4 run; a unit test checks the others."""

    stack = ExitStack()
    log: MessageRecorder

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_launch_files_demo")
        cls.log = MessageRecorder("/rosout", Log)
        files = ("demo5.launch", "demo4.launch talker_arg:=true")
        launch = cls.stack.enter_context(launched(*(f"launch_files_demo {one}" for one in files)))
        launch.wait_until_up()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.stack.close()

    def message(self, topic: str, kind: type) -> Any:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder.wait_for(lambda one: True)

    def wait_for_log(self, node: str, pattern: str) -> None:
        self.log.wait_for(lambda one: one.name == node and re.search(pattern, one.msg))

    def test_talker_is_there_as_the_argument_says(self) -> None:
        """Course 001-launch-4."""
        self.wait_for_log("/listener", "^I heard 'hello world .*' from /talker$")

    def test_lidar(self) -> None:
        """Course 001-launch-8."""
        found = self.message("data/lidar", LaserScan)
        self.assertEqual((found.header.frame_id, len(found.ranges)), ("laser_frame", 361))
        self.assertAlmostEqual(found.angle_max, numpy.pi, 6)
        self.assertAlmostEqual(found.angle_increment, numpy.radians(1.0), 6)
        limits = found.range_min, found.range_max, found.scan_time
        self.assertEqual([round(limit, 6) for limit in limits], [0.2, 10.0, 0.1])
        expected = scan(SCANNER, found.header.stamp.to_sec())
        numpy.testing.assert_array_equal(numpy.array(found.ranges, "f4"), expected.astype("f4"))

    def test_camera(self) -> None:
        """Course 001-launch-9."""
        found = self.message("data/camera", Image)
        self.assertEqual((found.header.frame_id, found.encoding), ("camera_frame", "rgb8"))
        self.assertEqual((found.width, found.height, found.step), (WIDTH, HEIGHT, 3 * WIDTH))
        time = found.header.stamp.to_sec()
        cards = [Picture("camera_demo_node").draw(number, time) for number in range(100)]
        self.assertIn(found.data, map(bytes, cards))

    def test_temperature(self) -> None:
        """Course 001-launch-10."""
        found = self.message("data/temperature", Temperature)
        self.assertEqual(found.variance, VARIANCE)
        expected = true_temperature(found.header.stamp.to_sec())
        self.assertLess(abs(found.temperature - expected), 5.0)

    def test_processing_hears_all_three(self) -> None:
        """Course 001-launch-5, 001-launch-11."""
        for text in (
            r"^Received LiDAR data: nearest [0-9.]+ m$",
            "^Received Camera data: width=640, height=480$",
            "^Received Temperature data: -?[0-9.]+ °C$",
        ):
            self.wait_for_log("/processing_demo_node", text)


if __name__ == "__main__":
    rosrun("launch_files_demo", "launch_files_demo", LaunchFilesDemo)
