"""Faults that users of other bridges report, as listed in docs/ros2_answers.md."""

import contextlib
import pathlib
import signal
import struct
import subprocess
import threading
from types import SimpleNamespace
from typing import Any, Dict, Iterator, List, cast

import both
import pytest
import rosbag
import rosgraph
import rospy
from builtin_interfaces.msg import Duration, Time
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger
from test_latched import TF, TF1, tf1
from test_topics import Keeping, publisher1
from tf2_msgs.msg import TFMessage

from nodekit.testing.processes import Process, free_port
from nodekit.testing.waiting import wait_until
from ros2_bridge.rules.active_pairs import MISSED_POLLS
from ros2_bridge.rules.settings import QosProfiles
from ros2_bridge.topics.all_topics import TopicBridge
from ros2_bridge.topics.one_topic import TopicToRos2

TRIGGER = "std_srvs/Trigger"
PLAY = ["/usr/lib/rosbag/play", "--quiet", "--keep-alive"]
#: Records three messages.
RECORD = ["/usr/lib/rosbag/record", "--quiet", "--limit=3", "-O"]


@contextlib.contextmanager
def running(command: List[str]) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a program of ROS 1 that is not written in Python; end it as Ctrl-C does."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20.0)


def services1() -> Dict[str, List[str]]:
    """Return the servers of each service of ROS 1."""
    return dict(rospy.get_master().getSystemState()[2][2])


def record_static_transform(ros: both.Both, path: pathlib.Path, node: str, child: str) -> str:
    """Write a bag with what a node latched on /tf_static; return its path."""
    raw = ros.types.message(TF1).raw
    header = {
        "topic": TF,
        "type": TF1,
        "md5sum": raw._md5sum,
        "message_definition": raw._full_text,
        "callerid": node,
        "latching": "1",
    }
    with rosbag.Bag(str(path), "w") as bag:
        bag.write(TF, (TF1, tf1(child), raw._md5sum, raw), raw=True, connection_header=header)
    return str(path)


def test_late_ros2_listener_gets_static_transforms_of_all_publishers_of_a_node(
    ros: both.Both, bridge: both.Bridge, tmp_path: pathlib.Path
) -> None:
    """As of rosbag, which plays those of several nodes, and of nodelets of one manager."""
    bags = [
        record_static_transform(ros, tmp_path / f"{name}.bag", f"/{name}", name)
        for name in ("left", "right")
    ]

    def children(recorder: both.MessageRecorder) -> List[str]:
        return [one.child_frame_id for message in recorder.heard for one in message.transforms]

    with running([*PLAY, *bags]):
        early = ros.hear2(TF, TFMessage, latched=True)
        wait_until(lambda: {*children(early)} == {"left", "right"}, lambda: str(children(early)))
        late = ros.hear2(TF, TFMessage, latched=True)
        wait_until(lambda: {*children(late)} == {"left", "right"}, lambda: str(children(late)))
        for recorder in (early, late):
            recorder.end()


def test_only_transforms_of_the_present_connection_are_joined(ros: both.Both) -> None:
    participant: Any = Keeping()
    kind, bridge = ros.types.message(TF1), cast(Any, SimpleNamespace(name="/bridge"))
    pair = TopicToRos2(bridge, participant, TF, TF, kind, QosProfiles(9, None))
    topics: Any = TopicBridge.__new__(TopicBridge)
    topics._ros2, topics._owners = {}, {}

    def poll(*nodes: str) -> None:
        topics._ros1 = SimpleNamespace(publishers={TF: set(nodes)})
        topics._update_publishers(pair)

    def sent(header: Dict[str, str], child: str) -> List[str]:
        """Receive a transform; return the frames in the message that is sent to ROS 2."""
        message = kind.raw()
        message._buff, message._connection_header = tf1(child), header
        pair._forward([message])
        latest = deserialize_message(participant.sent[-1][1], TFMessage)
        return [one.child_frame_id for one in latest.transforms]

    first, plain = {"callerid": "/play", "latching": "1"}, {"callerid": "/plain"}
    assert sent(first, "left") == ["left"]
    assert sent(first, "right") == ["left", "right"]
    assert sent({**first, "callerid": "/robot"}, "arm") == ["arm"]
    assert [sent(plain, child) for child in ("a", "b")] == [["a"], ["b"]]
    poll()  # the master has been restarted
    assert sent(first, "front") == ["left", "right", "front"]
    again = dict(first)  # the node was started again
    assert sent(again, "rear") == ["rear"]
    for _ in range(MISSED_POLLS):
        poll("/robot")
    assert sent(again, "top") == ["top"]


def test_client_without_server_offers_no_service(ros: both.Both, bridge: both.Bridge) -> None:
    client = ros.node.create_client(Trigger, "/nowhere")
    node = Node("seen_later")
    node.create_service(Trigger, "/somewhere", lambda _, response: response)
    ros.executor.add_node(node)
    wait_until(lambda: "/somewhere" in services1(), lambda: str(services1()))
    assert "/nowhere" not in services1()
    ros.executor.remove_node(node)
    node.destroy_node()
    ros.node.destroy_client(client)


def test_service_whose_server_does_not_answer_is_named(ros: both.Both, bridge: both.Bridge) -> None:
    uri, master = f"rosrpc://localhost:{free_port()}", rosgraph.Master("/gone")
    master.registerService("/gone/reset", uri, "http://localhost:1/")
    try:
        bridge.wait_for_log("not bridged: ", "/gone/reset of ROS 1: its server does not answer")
    finally:
        master.unregisterService("/gone/reset", uri)


@pytest.mark.extended
def test_service_may_move_from_ros2_to_ros1_and_back(ros: both.Both, bridge: both.Bridge) -> None:
    raw = ros.types.service(TRIGGER).raw

    def answer1(_: Any) -> Any:
        response = raw._response_class()
        response._buff = b"\1" + struct.pack("<I", 4) + b"ROS1"
        return response

    def answer2(_: Any, response: Any) -> Any:
        response.message = "ROS2"
        return response

    for _ in range(2):
        server2 = ros.node.create_service(Trigger, "/moving", answer2)
        assert ros.call1("/moving", TRIGGER, b"")[-4:] == b"ROS2"
        ros.node.destroy_service(server2)
        wait_until(lambda: "/moving" not in services1(), lambda: "it is still offered in ROS 1")
        server1 = rospy.Service("/moving", raw, answer1)
        assert ros.call2(Trigger, "/moving").message == "ROS1"
        server1.shutdown()
        wait_until(lambda: not ros.offers2("/moving"), lambda: "it is still offered in ROS 2")


def test_listeners_that_come_and_go_are_all_served(ros: both.Both, bridge: both.Bridge) -> None:
    out1 = publisher1(ros, "/unstable", "std_msgs/Float32")
    out2 = ros.node.create_publisher(Float32, "/unstable2", 10)
    for _ in range(4):
        recorder2 = ros.hear2("/unstable", Float32)
        recorder1 = ros.hear1("/unstable2", "std_msgs/Float32")
        wait_until(
            lambda: out1.send(struct.pack("<f", 1.0)) or recorder2.heard, lambda: "none in ROS 2"
        )
        wait_until(lambda: out2.publish(Float32()) or recorder1.heard, lambda: "none in ROS 1")
        for recorder in (recorder1, recorder2):
            recorder.end()
        wait_until(lambda: not out1.get_num_connections(), lambda: "the bridge goes on to listen")
        wait_until(lambda: not out2.get_subscription_count(), lambda: "it goes on in ROS 2")
    out1.unregister()
    ros.node.destroy_publisher(out2)


def test_publishers_of_either_reliability_are_all_heard(
    ros: both.Both, bridge: both.Bridge
) -> None:
    policies = (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    outs = [
        ros.node.create_publisher(Float32, "/reliability", QoSProfile(depth=10, reliability=policy))
        for policy in policies
    ]
    recorder = ros.hear1("/reliability", "std_msgs/Float32")

    def heard() -> bool:
        for number, out in enumerate(outs):
            out.publish(Float32(data=float(number)))
        return {struct.unpack("<f", m._buff)[0] for m in list(recorder.heard)} == {0.0, 1.0}

    wait_until(heard, lambda: f"{len(recorder.heard)} messages")
    recorder.end()
    for out in outs:
        ros.node.destroy_publisher(out)


def test_times_are_bridged_as_topics_of_their_own(ros: both.Both, bridge: both.Bridge) -> None:
    """ROS 2 has them in another package."""
    heard2 = ros.hear2("/time1", Time)
    out1 = publisher1(ros, "/time1", "std_msgs/Time")
    wait_until(
        lambda: out1.send(struct.pack("<II", 7, 8)) or heard2.heard, lambda: str(bridge.logged())
    )
    assert (heard2.heard[0].sec, heard2.heard[0].nanosec) == (7, 8)
    out2 = ros.node.create_publisher(Duration, "/duration2", 10)
    heard1 = ros.hear1("/duration2", "std_msgs/Duration")
    wait_until(
        lambda: out2.publish(Duration(sec=-3, nanosec=9)) or heard1.heard,
        lambda: str(bridge.logged()),
    )
    assert heard1.heard[0]._buff == struct.pack("<iI", -3, 9)
    for recorder in (heard1, heard2):
        recorder.end()
    out1.unregister()
    ros.node.destroy_publisher(out2)


def test_text_that_is_published_once_reaches_a_waiting_listener(
    ros: both.Both, bridge: both.Bridge
) -> None:
    recorder = ros.hear2("/once", String)
    once = Process("/usr/bin/rostopic", ["pub", "--once", "/once", "std_msgs/String", "data: hi"])
    try:
        assert recorder.wait()[0].data == "hi"
        assert once.wait() == 0
    finally:
        once.end()
        recorder.end()


def test_bag_that_is_recorded_has_the_time_of_a_simulation_in_ros2(
    ros: both.Both, bridge: both.Bridge, tmp_path: pathlib.Path
) -> None:
    clock = ros.node.create_publisher(Clock, "/clock", 10)
    out = ros.node.create_publisher(Float32, "/simulated", 10)
    path = tmp_path / "simulated.bag"
    rospy.set_param("/use_sim_time", True)
    ticking = threading.Event()

    def tick() -> None:
        message = Clock()
        while not ticking.wait(0.02):
            message.clock.sec = 1234
            clock.publish(message)
            out.publish(Float32(data=1.5))

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        with running([*RECORD, str(path), "/simulated"]) as recorder:
            recorder.wait(30.0)
    finally:
        ticking.set()
        thread.join()
        rospy.delete_param("/use_sim_time")
    with rosbag.Bag(str(path)) as bag:
        times = [time.secs for _, _, time in bag.read_messages(raw=True)]
    assert times and {*times} == {1234}
    for made in (clock, out):
        ros.node.destroy_publisher(made)
