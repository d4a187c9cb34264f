#!/usr/bin/env python3
"""Course items on nodes with parameters, tested on running nodes."""

import collections
import os
import re
import statistics
import tempfile
import unittest
from contextlib import ExitStack
from typing import Any, Deque, Dict, List, Tuple

import numpy
import rosparam
import rospy
import yaml
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import String
from std_srvs.srv import Trigger

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from nodekit_msgs.srv import SetParameters
from parameters_demo.messages import radar_tracks
from parameters_demo.picture import HEIGHT, WIDTH, Picture
from parameters_demo.room import MODELS, scan
from parameters_demo.traffic import returns
from parameters_demo_msgs.msg import RadarTracks

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
FILES = [
    "parameters_demo demo3.launch lidar_model:=OS1 processing_mode:=lidar_only processing_rate:=20",
    "parameters_demo demo4.launch",
    "parameters_demo talker_listener_launch.launch rate:=20.0 topic_name:=my_topic",
]
#: Rows and columns of the name in the picture.
NAME = (slice(330, 390), slice(480))
DECLARED: Dict[str, Any] = {
    "flag": True,
    "count": 42,
    "ratio": 0.5,
    "title": "robot",
    "flags": [True, False],
    "counts": [1, 2, 3],
    "ratios": [0.5, 1.5],
    "titles": ["a", "b"],
    "blob": [0, 127, 255],
}
OTHERS: Dict[str, Any] = {
    "flag": False,
    "count": -7,
    "ratio": 1e-3,
    "title": "other",
    "flags": [False],
    "counts": [],
    "ratios": [2.5, -1.0],
    "titles": ["with: colon", "", "5"],
    "blob": list(range(256)),
}
WRONG: Dict[str, Any] = {
    "flag": 1,
    "count": 1.5,
    "ratio": "fast",
    "title": 5,
    "flags": [True, 1],
    "counts": [1, 2.5],
    "ratios": 1.0,
    "titles": ["a", 5],
    "blob": [256],
}


def name_on(image: Image) -> bytes:
    """Return the part of a picture that shows the camera's name."""
    return numpy.frombuffer(image.data, numpy.uint8).reshape(HEIGHT, WIDTH, 3)[NAME].tobytes()


def name_of(name: str) -> bytes:
    """Return the same part as it is drawn."""
    return name_on(Image(data=bytes(Picture(name).draw(0, 0.0))))


class Stamps:
    """The stamps of the latest images of a topic; without the images, which are large."""

    def __init__(self, topic: str) -> None:
        self._stamps: Deque[float] = collections.deque(maxlen=6)
        self.subscriber = rospy.Subscriber(topic, Image, self._on_image)

    def _on_image(self, image: Image) -> None:
        self._stamps.append(image.header.stamp.to_sec())

    def rate(self) -> float:
        """Return the usual rate of images [Hz]; 0 if there are few."""
        stamps = list(self._stamps)
        times = [late - early for early, late in zip(stamps, stamps[1:])]
        return 1.0 / statistics.median(times) if len(times) > 4 else 0.0


class ParametersDemo(unittest.TestCase):
    """All nodes run at the same time, most of them from the course's launch files."""

    stack = ExitStack()
    server = Server()
    log: MessageRecorder
    graph: Graph
    processes: Dict[str, Process] = {}

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_parameters_demo")
        cls.log = MessageRecorder("/rosout", Log)
        cls.server.set("/configurable_node/robot_name", "marvin")
        starts: List[Tuple[str, str]] = [
            ("configurable_node", "_update_rate:=20"),
            ("parameterized_publisher", "_publish_rate:=5.0"),
            ("parameter_types", "_limits:={speed: 1.5, turn: 2}"),
        ]
        for name, argument in starts:
            cls.processes[name] = Process(os.path.join(SCRIPTS, name), [argument])
        launch = cls.stack.enter_context(launched(*FILES))
        cls.graph = launch.graph
        launch.wait_until_up()

    @classmethod
    def tearDownClass(cls) -> None:
        for process in cls.processes.values():
            process.end()
        cls.stack.close()

    def recorder(self, topic: str, kind: type) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def wait_for_log(self, node: str, pattern: str) -> Any:
        """Wait for a line of a node that fits, and return the match."""
        found = self.log.wait_for(lambda one: one.name == node and re.search(pattern, one.msg))
        return re.search(pattern, found.msg)

    def change(self, node: str, text: str) -> Any:
        """Ask a node to change parameters."""
        rospy.wait_for_service(f"{node}/change")
        return rospy.ServiceProxy(f"{node}/change", SetParameters)(text)

    def test_camera_shows_its_name_number_and_time(self) -> None:
        """Course 001-params-1, 001-params-10."""
        for number, name in ((1, "right_side_camera"), (2, "left_side_camera")):
            images = self.recorder(f"camera{number}/image_color", Image)
            infos = self.recorder(f"camera{number}/camera_info", CameraInfo)
            image = images.wait_for(lambda one: True)
            self.assertEqual((image.width, image.height, image.encoding), (640, 480, "rgb8"))
            self.assertEqual((image.step, len(image.data)), (1920, 1920 * 480))
            self.assertEqual(image.header.frame_id, name + "_optical_frame")
            self.assertEqual(name_on(image), name_of(name))
            later = images.wait_for(lambda one: one.header.seq > image.header.seq)
            self.assertNotEqual(later.data, image.data)
            # Not each has its image here: a subscriber that is held up misses some.
            info = infos.wait_for(
                lambda one: any(
                    image.header.stamp == one.header.stamp for image in images.messages()
                )
            )
            self.assertEqual((info.width, info.height), (640, 480))

    def test_lidar_scans_the_room(self) -> None:
        """Course 001-params-2."""
        found = self.recorder("lidar/points", LaserScan).wait_for(lambda one: True)
        expected = scan(MODELS["OS1"], found.header.stamp.to_sec())
        numpy.testing.assert_array_equal(numpy.array(found.ranges, "f4"), expected.astype("f4"))
        self.assertEqual(found.header.frame_id, "top_lidar_frame")
        self.assertAlmostEqual(found.scan_time, 0.05)
        self.wait_for_log("/lidar_demo", r"^Published scan from: top_lidar \(OS1\)$")

    def test_radar_follows_what_moves(self) -> None:
        """Course 001-params-3."""
        recorder = self.recorder("radar/tracks", RadarTracks)
        found = recorder.wait_for(lambda one: recorder.count() > 5)
        for tracks in [found, recorder.messages()[5]]:
            expected = radar_tracks(tracks.header, returns(tracks.header.stamp.to_sec()))
            for one, other in zip(tracks.returns, expected.returns):
                for field in one.__slots__:
                    self.assertAlmostEqual(getattr(one, field), getattr(other, field), places=4)
            self.assertEqual(len(tracks.returns), len(expected.returns))
        self.wait_for_log("/radar_demo", r"^Published \d+ returns from: front_radar$")

    def test_mode_says_which_topics_are_heard(self) -> None:
        """Course 001-params-4, 001-params-9."""
        node, topics = (
            "/processing_demo",
            {
                "radar": "/radar/tracks",
                "camera": "/camera/image_color",
                "lidar": "/lidar/points",
            },
        )
        match = self.wait_for_log(node, r"^cycle (\d+): lidar #[1-9]\d*: nearest [0-9.]+ m$")
        self.assertEqual(int(match.group(1)) % 5, 0)
        self.assertEqual(self.change(node, "processing_mode: all").message, "")
        for topic in topics.values():
            self.graph.wait_for_subscribers(topic, node)
        self.wait_for_log(
            node,
            r"^cycle \d+: radar #\d+: \d+ returns.*; camera #\d+: brightness [0-9.]+; "
            r"lidar #\d+: nearest [0-9.]+ m$",
        )
        self.assertEqual(self.change(node, "processing_mode: camera_only").message, "")
        self.graph.wait_for_subscribers(topics["radar"])
        self.graph.wait_for_subscribers(topics["lidar"])
        self.wait_for_log(node, r"^cycle \d+: camera #\d+: brightness [0-9.]+$")
        answer = self.change(node, "{processing_mode: none, processing_rate: 31}")
        self.assertIn("must be one of all, radar_only, camera_only, lidar_only", answer.message)
        self.assertIn("refused 31: must be a whole number in [1, 30] (Hz)", answer.message)

    def test_camera_rate_is_taken_or_refused_with_a_reason(self) -> None:
        """Course 001-params-11, 001-params-13, 001-params-14."""
        node = "/camera_demo"
        stamps = Stamps("camera/image_color")
        self.addCleanup(stamps.subscriber.unregister)
        allowed = "must be a whole number in [10, 80] in steps of 10 (Hz)"
        for rate in (5, 15, 90):
            answer = self.change(node, f"camera_rate: {rate}")
            text = f"parameter {node}/camera_rate: refused {rate}: {allowed}"
            self.assertEqual((answer.success, answer.message), (False, text))
            self.server.set(f"{node}/camera_rate", rate)
            self.server.wait_for(f"{node}/camera_rate", 30)
            self.wait_for_log(node, re.escape(f"{text}; in force is camera_rate=30"))
        for rate in (10, 70):
            self.server.set(f"{node}/camera_rate", rate)
            self.wait_for_rate(stamps, rate)
        rospy.ServiceProxy(f"{node}/slow_down", Trigger)()
        self.assertEqual(self.server.get(f"{node}/camera_rate"), 40)
        self.wait_for_rate(stamps, 40)

    def wait_for_rate(self, stamps: Stamps, rate: float) -> None:
        """Wait until the rate of images is nearest to this rate, of those in the test [Hz]."""
        wait_until(
            lambda: 0.8 < stamps.rate() / rate < 1.2,
            lambda: f"{stamps.rate()} Hz, not {rate} Hz",
        )

    def test_camera_name_is_seen_in_the_log_and_on_the_picture(self) -> None:
        """Course 001-params-12."""
        images = self.recorder("camera/image_color", Image)
        self.wait_for_log("/camera_demo", "^Published frame from: front_camera$")
        self.server.set("/camera_demo/camera_name", "front_facing_camera")
        self.wait_for_log("/camera_demo", "^Published frame from: front_facing_camera$")
        expected = name_of("front_facing_camera")
        images.wait_for(lambda one: name_on(one) == expected)
        self.assertNotEqual(expected, name_of("front_camera"))

    def test_what_is_not_declared_is_an_error(self) -> None:
        """Course 001-params-15."""
        answer = self.change("/camera_demo", "camera_colour: red")
        self.assertFalse(answer.success)
        self.assertIn("/camera_demo/camera_colour: refused 'red'", answer.message)
        with self.assertRaises(KeyError):
            rospy.get_param("/camera_demo/camera_colour")
        self.server.set("/camera_demo/camera_nam", "x")
        self.addCleanup(self.server.delete, "/camera_demo/camera_nam")
        warning = "camera_nam is not used by this node; did you mean camera_name?"
        self.wait_for_log("/camera_demo", re.escape(warning))

    def test_each_type_is_taken_and_no_other(self) -> None:
        """Course 001-params-16, 004-bridge-10."""
        node = "/parameter_types"
        for name, value in DECLARED.items():
            self.server.wait_for(f"{node}/{name}", value)
        for name, value in OTHERS.items():
            self.server.set(f"{node}/{name}", value)
            self.wait_for_log(node, f"^Parameter changed: {name} = ")
        for name, value in WRONG.items():
            self.server.set(f"{node}/{name}", value)
            self.server.wait_for(f"{node}/{name}", OTHERS[name])
            self.wait_for_log(node, re.escape(f"parameter {node}/{name}: refused"))
        # Bytes are read and written back as a list: rosparam could not dump them.
        self.server.set(f"{node}/blob", b"ab")
        self.server.wait_for(f"{node}/blob", [97, 98])
        # Said at the start, when /rosout may not be connected yet.
        self.processes["parameter_types"].wait_for_log("Limits: speed up to 1.5, turn up to 2")
        self.server.set(f"{node}/limits/turn", 3)
        self.wait_for_log(node, "^Limits: speed up to 1.5, turn up to 3$")
        self.assert_starts_again("parameter_types", {**OTHERS, "blob": [97, 98]})

    def assert_starts_again(self, name: str, values: Dict[str, Any]) -> None:
        """Dump a node's parameters to a file; start another node with that file."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "my_params.yaml")
            rosparam.dump_params(path, f"/{name}")
            for held, _ in rosparam.load_file(path):
                rosparam.upload_params(f"/{name}_again", held)
        again = Process(os.path.join(SCRIPTS, name), [f"__name:={name}_again"])
        self.addCleanup(again.end)
        answer = self.change(f"/{name}_again", "{}")
        self.assertEqual(yaml.safe_load(answer.values), values)
        self.assertEqual(again.interrupt(), 0)

    def test_configurable_node_does_what_it_is_told(self) -> None:
        """Course 004-bridge-3, 004-bridge-4."""
        node, process = "/configurable_node", self.processes["configurable_node"]
        process.wait_for_log("Started: robot=marvin, rate=20.0Hz")
        process.wait_for_log("marvin: tick at 20.0Hz")
        self.server.set(f"{node}/update_rate", 10.0)
        process.wait_for_log("Parameter changed: update_rate = 10.0")
        process.wait_for_log("marvin: tick at 10.0Hz")
        for rate in (0, -1.5):
            answer = self.change(node, f"update_rate: {rate}")
            self.assertFalse(answer.success)
            said = f"parameter {node}/update_rate: refused {rate}: update_rate must be positive"
            self.assertEqual(answer.message, said)
        values = {"enabled": False, "robot_name": "zaphod", "update_rate": 10.0}
        changes = [("enabled", False)]
        # These take longer than a tick or two, if there were any.
        changes += [("robot_name", name) for name in ("arthur", "ford", "trillian", "zaphod")]
        for name, value in changes:
            self.server.set(f"{node}/{name}", value)
            process.wait_for_log(f"Parameter changed: {name} = {value}")
        self.assert_starts_again("configurable_node", values)
        self.server.set(f"{node}/enabled", True)
        process.wait_for_log("zaphod: tick at 10.0Hz")
        for name in ("arthur", "ford", "trillian"):
            self.assertEqual(process.logged(f"{name}: tick"), [])
        self.assertEqual(process.interrupt(), 0)

    def test_publisher_follows_its_prefix_and_its_rate(self) -> None:
        """Course 004-bridge-7."""
        node, process = "/parameterized_publisher", self.processes["parameterized_publisher"]
        self.server.wait_for(f"{node}/publish_rate", 5.0)
        recorder = self.recorder("chatter", String)
        recorder.wait_for(lambda one: re.fullmatch(r"Hello \d+", one.data))
        self.server.set(f"{node}/message_prefix", "Good day")
        recorder.wait_for(lambda one: re.fullmatch(r"Good day \d+", one.data))
        numbers = [int(one.data.split()[-1]) for one in recorder.messages()]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
        answer = self.change(node, "{publish_rate: 0, message_prefix: 5}")
        self.assertIn("refused 0: must be a number in [1e-06, 10000] (Hz)", answer.message)
        self.assertIn("refused 5: must be text", answer.message)
        self.assertEqual(process.interrupt(), 0)

    def test_talker_and_listener_meet_on_the_topic_of_the_argument(self) -> None:
        """Course 004-bridge-5, 004-bridge-8."""
        self.graph.wait_for_publishers("/robot1/my_topic", "/robot1/talker")
        self.graph.wait_for_subscribers("/robot1/my_topic", "/robot1/listener")
        self.wait_for_log("/robot1/listener", r"^I heard 'Hello \d+' from /robot1/talker$")


if __name__ == "__main__":
    rosrun("parameters_demo", "parameters_demo", ParametersDemo)
