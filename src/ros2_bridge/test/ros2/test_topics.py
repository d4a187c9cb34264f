"""Topics, both ways."""

import contextlib
import ctypes
import math
import pathlib
import struct
import threading
import xmlrpc.client
from functools import partial
from types import SimpleNamespace
from typing import Any, Callable, Dict, List, Tuple, cast

import both
import pytest
import rospy
from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.serialization import serialize_message
from std_msgs.msg import Float32, String, UInt8MultiArray

from basic_comms.msg import SignalMsg
from nodekit import Throttle
from nodekit.message_definitions import parse
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from ros2_bridge.health.topic_health import TopicCounts
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2 import rcl_take
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.rules.selection import Rules, Route
from ros2_bridge.rules.active_pairs import MISSED_POLLS, BridgedResources
from ros2_bridge.rules.rates import MaxRates, RateLimit
from ros2_bridge.rules.settings import QosProfiles, QosProfile
from ros2_bridge.rules.skip_log import SkipLog, Unbridgeable
from ros2_bridge.topics.all_topics import TopicBridge
from ros2_bridge.topics.one_topic import PairCounters, LatchedMessage, TopicToRos1, TopicToRos2
from ros2_bridge.topics.publishers import TopicPublishers
from ros2_bridge.types.codec import Codec

RCLError = _rclpy.RCLError
HERE = pathlib.Path(__file__).resolve().parent
HEADER = f"""
{"=" * 80}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""


def publisher1(ros: both.Both, topic: str, kind: str, latch: bool = False) -> Any:
    raw = ros.types.message(kind).raw
    made = rospy.Publisher(topic, raw, queue_size=1000, latch=latch)

    def publish(data: bytes) -> None:
        message = raw()
        message._buff = data
        made.publish(message)

    made.send = publish
    return made


def test_signal_arrives_with_four_right_fields(ros: both.Both, bridge: both.Bridge) -> None:
    out = publisher1(ros, "/signal", "basic_comms/signal_msg")
    wait_until(lambda: ros.node.count_publishers("/signal"), lambda: "no /signal in ROS 2")
    recorder = ros.hear2("/signal", SignalMsg)
    wait_until(lambda: out.get_num_connections(), lambda: "the bridge does not listen")
    for number in range(3):
        out.send(struct.pack("<ffdf", 2.0, 6.25, 0.1 * number, -1.5))
    first, _, last = recorder.wait(3)
    assert (first.amplitude, first.frequency, first.signal_y) == (2.0, 6.25, -1.5)
    assert last.time_x == 0.1 * 2
    recorder.end()
    wait_until(lambda: not out.get_num_connections(), lambda: "the bridge goes on to listen")
    out.unregister()
    wait_until(lambda: not ros.node.count_publishers("/signal"), lambda: "/signal stays")


def test_text_arrives_in_ros1(ros: both.Both, bridge: both.Bridge) -> None:
    out = ros.node.create_publisher(String, "/chatter", 10)
    recorder = ros.hear1("/chatter", "std_msgs/String")
    wait_until(lambda: out.get_subscription_count(), lambda: "the bridge does not listen")
    out.publish(String(data="grüezi"))
    (message,) = recorder.wait()
    assert message._buff == struct.pack("<I", 7) + "grüezi".encode()
    assert message._connection_header["type"] == "std_msgs/String"
    recorder.end()
    ros.node.destroy_publisher(out)


def test_latched_topics_stay_latched(ros: both.Both, bridge: both.Bridge) -> None:
    latched = publisher1(ros, "/level1", "std_msgs/Float32", latch=True)
    latched.send(struct.pack("<f", 2.5))
    for _ in range(2):  # a late subscriber receives it, too
        recorder = ros.hear2("/level1", Float32, latched=True)
        assert recorder.wait()[0].data == 2.5
        recorder.end()
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    out = ros.node.create_publisher(Float32, "/level2", qos)
    out.publish(Float32(data=3.5))
    for _ in range(2):
        recorder = ros.hear1("/level2", "std_msgs/Float32")
        assert recorder.wait()[0]._buff == struct.pack("<f", 3.5)
        recorder.end()
    latched.unregister()
    ros.node.destroy_publisher(out)


def test_quality_of_service_fits_that_of_the_publisher(ros: both.Both, bridge: both.Bridge) -> None:
    out = ros.node.create_publisher(Float32, "/range", qos_profile_sensor_data)
    recorder = ros.hear1("/range", "std_msgs/Float32")
    # A subscriber that requests more than is offered gets no error.
    wait_until(lambda: out.get_subscription_count(), lambda: "the bridge does not listen")
    wait_until(lambda: out.publish(Float32(data=1.5)) or recorder.heard, lambda: "nothing is heard")
    assert recorder.heard[0]._buff == struct.pack("<f", 1.5)
    recorder.end()
    ros.node.destroy_publisher(out)


def test_a_topic_of_both_sides_has_no_echo(ros: both.Both, bridge: both.Bridge) -> None:
    check_no_echo(ros)


def check_no_echo(ros: both.Both) -> None:
    """Check that the running bridge sends no message back to its side."""
    out1 = publisher1(ros, "/both", "std_msgs/Float32")
    out2 = ros.node.create_publisher(Float32, "/both", 100)
    recorder1, recorder2 = ros.hear1("/both", "std_msgs/Float32"), ros.hear2("/both", Float32)
    wait_until(lambda: out1.get_num_connections() == 2, lambda: "no subscribers in ROS 1")
    wait_until(lambda: out2.get_subscription_count() == 2, lambda: "no subscribers in ROS 2")
    for number in range(10):
        out1.send(struct.pack("<f", number))
        out2.publish(Float32(data=100.0 + number))
    numbers = {float(number) for number in range(10)}
    both_kinds = numbers | {100.0 + number for number in numbers}
    recorder1.wait(20), recorder2.wait(20)
    out1.send(struct.pack("<f", -1.0))
    out2.publish(Float32(data=-2.0))  # behind an echo, if there was one
    recorder1.wait(22), recorder2.wait(22)
    both_kinds |= {-1.0, -2.0}
    assert sorted(message.data for message in recorder2.heard) == sorted(both_kinds)
    assert sorted(struct.unpack("<f", m._buff)[0] for m in recorder1.heard) == sorted(both_kinds)
    for recorder in (recorder1, recorder2):
        recorder.end()
    out1.unregister()
    ros.node.destroy_publisher(out2)


def test_type_change_is_detected(ros: both.Both, bridge: both.Bridge) -> None:
    def types2() -> Any:
        return dict(ros.node.get_topic_names_and_types()).get("/changing")

    def types1() -> Any:
        return dict(rospy.get_master().getTopicTypes()[2]).get("/changing")

    number1 = publisher1(ros, "/changing", "std_msgs/Float32")
    wait_until(lambda: types2() == ["std_msgs/msg/Float32"], lambda: str(types2()))
    number1.unregister()  # and at once, before the bridge takes it for gone:
    text1 = publisher1(ros, "/changing", "std_msgs/String", latch=True)
    text1.send(struct.pack("<I", 3) + b"abc")
    recorder = ros.hear2("/changing", String, latched=True)
    assert recorder.wait()[0].data == "abc"
    recorder.end()
    text1.unregister()
    wait_until(lambda: not types2(), lambda: str(types2()))
    # The master keeps its last type forever.
    number2 = ros.node.create_publisher(Float32, "/changing", 10)
    wait_until(lambda: types1() == "std_msgs/Float32", lambda: str(types1()))
    ros.node.destroy_publisher(number2)
    text2: List[Any] = []

    def is_made() -> bool:
        with contextlib.suppress(RCLError):  # the executor still holds the other one
            text2.append(ros.node.create_publisher(String, "/changing", 10))
        return bool(text2)

    wait_until(is_made, lambda: "no publisher of another type")
    wait_until(lambda: types1() == "std_msgs/String", lambda: str(types1()))
    ros.node.destroy_publisher(text2[0])
    assert not bridge.logged("Traceback") and not bridge.logged("/changing")


def test_single_topic_among_many(ros: both.Both, bridge: both.Bridge) -> None:
    for number in range(80):  # of a killed node: the master still lists them
        name = f"/many/of_a_group/topic{number}"
        args = ("/killed", name, "basic_comms/signal_msg", "http://localhost:1/")
        xmlrpc.client.ServerProxy(ros.master.uri).registerPublisher(*args)
    illegal = publisher1(ros, "/1/number", "std_msgs/Float32")
    out = publisher1(ros, "/many/last", "basic_comms/signal_msg", latch=True)
    out.send(struct.pack("<ffdf", 2.0, 6.25, 0.5, -1.5))
    recorder = ros.hear2("/many/last", SignalMsg, latched=True)
    assert recorder.wait()[0].signal_y == -1.5
    recorder.end()
    assert not bridge.logged("truncated")  # of harmless failures of type support
    bridge.wait_for_log("not bridged: /1/number", "token that starts with a number")
    out.unregister()
    illegal.unregister()


class Keeping:
    """Fake ROS 2 side, with a node of the bridge and any requested nodes.

    :ivar last: last message of each existing publisher, in order of creation
    :ivar sent: all published messages, with their publisher's node
    :ivar made: for each existing publisher, whether it latches, and its node
    :ivar depths: depth of each publisher, in order of creation
    """

    node = "bridge"

    def __init__(self) -> None:
        self.last: Dict[int, bytes] = {}
        self.sent: List[Tuple[str, bytes]] = []
        self.made: Dict[int, Tuple[bool, str]] = {}
        self.depths: List[int] = []

    def create_publisher(self, owner: str, _: Any, __: str, quality: QosProfile) -> Any:
        made = SimpleNamespace()
        self.made[id(made)] = quality.latched, owner
        self.depths.append(quality.depth)

        def publish(data: bytes) -> None:
            assert id(made) in self.made
            self.last[id(made)] = data
            self.sent.append((owner, data))

        made.publish = publish
        return made

    def destroy_publisher(self, owner: str, publisher: Any) -> None:
        assert self.made.pop(id(publisher))[1] == owner
        self.last.pop(id(publisher), None)


def keeping_pair(depth: int = 9, chosen: Any = None) -> Tuple[TopicPublishers, Keeping]:
    participant: Any = Keeping()
    kind: Any = SimpleNamespace(cls=None)
    qualities = QosProfiles(depth, chosen)
    pair = TopicToRos2(cast(Any, None), participant, "/map", "/map", kind, qualities)
    return pair.publishers, participant


def test_large_messages_are_held_in_a_bounded_number_of_bytes() -> None:
    publishers, participant = keeping_pair(1000)
    for size in (100, 60_000, 6_000_000, 100, 6_000_001):
        publishers.publish("/camera", bytes(size), False)
    assert participant.depths == [1000, 8]
    assert publishers.held_at_most() == 2**26
    assert [len(data) for _, data in participant.sent] == [100, 60_000, 6_000_000, 100, 6_000_001]
    publishers.publish("/camera", bytes(200_000_000), False)
    assert participant.depths[-1] == 1
    publishers.publish("/map_server", bytes(6_000_000), True)
    assert list(participant.made.values()) == [(False, "bridge"), (True, "bridge")]
    assert publishers.held_at_most() == 2**28 + 2**23


def test_depth_that_the_user_sets_holds_for_large_messages() -> None:
    publishers, participant = keeping_pair(1000, [{"topic": "/map", "depth": 50}])
    for size in (100, 6_000_000):
        publishers.publish("/camera", bytes(size), False)
    assert participant.depths == [50]


def test_message_is_latched_on_a_topic_that_the_user_makes_latched() -> None:
    chosen = {"topic": "/map", "durability": "transient_local", "depth": 9}
    publishers, participant = keeping_pair(9, [chosen])
    publishers.publish("/plain", b"a", False)
    assert not publishers.has_latched()
    publishers.publish("/map_server", b"b", True)
    assert publishers.has_latched()
    publishers.update_publishers({"/map_server"}, cast(Any, {"/map_server": "map_server"}), False)
    assert participant.sent[-1] == ("map_server", b"b")


def test_images_from_ros1_arrive_in_order(ros: both.Both, bridge: both.Bridge) -> None:
    """The first one makes the bridge hold fewer; none is lost or repeated by that."""
    recorder = ros.hear2("/images", UInt8MultiArray, depth=10)
    out = publisher1(ros, "/images", "std_msgs/UInt8MultiArray")
    wait_until(out.get_num_connections, lambda: "no subscriber in ROS 1")
    for number in range(1, 6):
        out.send(struct.pack("<III", 0, 0, 2_000_000) + bytes([number]) * 2_000_000)
        recorder.wait(number)
    assert [message.data[0] for message in recorder.heard] == list(range(1, 6))
    recorder.end()
    out.unregister()


def test_newest_large_messages_wait_while_the_bridge_is_busy(ros: both.Both) -> None:
    """Of 120 MB, 64 MB are kept, and passed on in batches; then messages flow again."""
    participant, topic, size = Participant("/busy"), "/busy_images", 4_000_000
    batches: List[List[int]] = []
    go_on = threading.Event()

    def receive(messages: List[ReceivedMessage]) -> None:
        if messages:
            batches.append([one.number or 0 for one in messages])
            go_on.wait(60.0)
            if len(batches) == 2:
                raise ValueError("the others must arrive nevertheless")

    quality = QosProfile(1000)
    end = participant.create_subscription(UInt8MultiArray, topic, quality, receive)
    publisher = participant.create_publisher(participant.node, UInt8MultiArray, topic, quality)
    wait_until(publisher.get_subscription_count, lambda: "no match")
    data = serialize_message(UInt8MultiArray(data=bytes(size)))
    for _ in range(31):
        publisher.publish(data)
        wait_until(lambda: batches, lambda: "no first message")
    assert publisher.wait_for_all_acked(Duration(seconds=60.0))
    go_on.set()
    kept = list(range(31 - 2**26 // len(data) + 1, 32))
    wait_until(lambda: sum(batches, []) == [1, *kept], lambda: str(batches))
    assert [len(one) for one in batches] == [1] + [2] * (len(kept) // 2)
    publisher.publish(data)
    wait_until(lambda: batches[-1] == [32], lambda: str(batches))
    end()
    participant.close()


class Camera(both.Running):
    """A ROS 1 node that shares memory."""

    def __init__(self) -> None:
        Process.__init__(self, str(HERE / "camera1.py"), [])


def test_images_reach_the_bridge_through_shared_memory(ros: both.Both, bridge: both.Bridge) -> None:
    ear = ros.hear2("/pictures", UInt8MultiArray, depth=100)
    plain = ros.hear1("/pictures", "std_msgs/UInt8MultiArray")
    with Camera():
        wait_until(lambda: len(plain.heard) > 5 < len(ear.heard), lambda: "too few pictures")
        uri = rospy.get_master().lookupNode("/camera1")[2]
        _, _, connections = cast(Any, xmlrpc.client.ServerProxy(uri).getBusInfo("/tests"))
    assert {one[3] for one in connections if one[4] == "/pictures"} == {"SHAREDMEM"}
    assert all(len(set(message.data)) == 1 for message in ear.heard)
    numbers = [message.data[0] for message in ear.heard]
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    assert all(len(set(message._buff[12:])) == 1 for message in plain.heard)
    ear.end()
    plain.end()


def test_latched_messages_of_ended_nodes_are_dropped() -> None:
    publishers, participant = keeping_pair()
    publishers.publish("/first", b"0", True)
    for number in range(1, 10):  # each from a node with its own name
        publishers.publish(f"/rostopic_{number}", b"%d" % number, True)
        for _ in range(4):
            publishers.update_publishers({"/first", f"/rostopic_{number}"}, {}, True)
    assert sorted(participant.last.values()) == [b"0", b"9"]
    publishers.update_publishers(
        {"/first"}, {}, True
    )  # a poll that began before the other one came
    publishers.publish("/another", b"10", True)
    for _ in range(9):
        publishers.update_publishers(set(), {}, True)  # the master has been restarted
    assert sorted(participant.last.values()) == [b"0", b"10", b"9"]
    publishers.close()
    assert not participant.made


def test_frequent_latching_keeps_message_of_another_node() -> None:
    publishers, participant = keeping_pair()
    publishers.publish("/seldom", b"a", True)
    for number in range(9):
        publishers.publish("/often", b"%d" % number, True)
    assert sorted(participant.last.values()) == [b"8", b"a"]
    assert all(is_latched for is_latched, _ in participant.made.values())


def test_volatile_message_is_not_latched() -> None:
    publishers, participant = keeping_pair()
    publishers.publish("/map_server", b"a", True)
    publishers.publish("/plain", b"b", False)
    publishers.publish("/another", b"c", True)
    kept = {participant.last[one]: is_latched for one, (is_latched, _) in participant.made.items()}
    assert kept == {b"a": True, b"b": False, b"c": True}


def test_each_node_publishes_its_own_messages() -> None:
    publishers, participant = keeping_pair()
    nodes: Any = {"/left": "left", "/right": "right"}
    publishers.update_publishers({"/left", "/hidden"}, nodes, True)
    assert sorted(owner for _, owner in participant.made.values()) == ["bridge", "left"]
    publishers.publish("/hidden", b"1", False)
    publishers.publish("/right", b"2", False)  # no poll has seen it yet
    publishers.update_publishers({"/left", "/right"}, nodes, True)
    publishers.publish("/left", b"3", False)
    publishers.publish("/right", b"4", False)
    assert participant.sent == [("bridge", b"1"), ("bridge", b"2"), ("left", b"3"), ("right", b"4")]
    for _ in range(4):
        publishers.update_publishers({"/left", "/right"}, nodes, True)
    assert sorted(owner for _, owner in participant.made.values()) == ["left", "right"]
    publishers.update_publishers({"/left", "/right"}, {}, False)  # neither is shown any longer
    assert len(participant.sent) == 4


def test_latched_message_moves_to_its_node_without_subscribers() -> None:
    publishers, participant = keeping_pair()
    publishers.publish("/map_server", b"a", True)  # before a poll has seen it
    nodes: Any = {"/map_server": "map_server"}
    publishers.update_publishers({"/map_server"}, nodes, True)
    assert participant.sent == [("bridge", b"a")]  # or its subscribers would get it twice
    publishers.update_publishers({"/map_server"}, nodes, False)
    assert list(participant.made.values()) == [(True, "map_server")]
    assert list(participant.last.values()) == [b"a"]
    publishers.update_publishers({"/map_server"}, {}, True)  # it does not appear any longer
    assert list(participant.made.values()) == [(True, "bridge")]
    assert list(participant.last.values()) == [b"a"]
    publishers.publish("/map_server", b"b", False)  # started again, and latches no longer
    publishers.update_publishers({"/map_server"}, nodes, True)
    assert list(participant.made.values()) == [(False, "map_server")]
    assert participant.sent[-1] == ("bridge", b"b")


def test_a_first_latched_message_waits_for_its_publisher_to_be_known(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    publishers, participant = keeping_pair()
    waits: List[Any] = []

    def sleep(_: float) -> None:
        waits.append((list(participant.made.values()), list(participant.sent)))
        publishers.publish("/plain", b"meanwhile", False)

    monkeypatch.setattr("ros2_bridge.topics.publishers.time", SimpleNamespace(sleep=sleep))
    for data in (b"a", b"b"):
        publishers.publish("/map_server", data, True)
    assert waits == [([(True, "bridge")], [])]
    assert [data for _, data in participant.sent] == [b"meanwhile", b"a", b"b"]
    closing, participant = keeping_pair()
    sleeping = SimpleNamespace(sleep=lambda _: closing.close())
    monkeypatch.setattr("ros2_bridge.topics.publishers.time", sleeping)
    closing.publish("/map_server", b"a", True)  # while the topic is closed
    assert not participant.sent and not participant.made


def test_lost_ros2_messages_are_counted(monkeypatch: "pytest.MonkeyPatch") -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair.topic, pair.count, pair._seq, pair._last = "/quick", PairCounters(), 0, {}
    pair._throttle = Throttle(60.0)
    pair._found, pair.limit = SimpleNamespace(latched=False), RateLimit()
    pair._participant = SimpleNamespace(is_own=lambda sender: sender == b"ours")
    codec = Codec("pkg/a", parse("pkg/a", f"Header header{HEADER}"))
    pair.kind = SimpleNamespace(raw=SimpleNamespace, codec=codec)
    passed: List[Any] = []
    stalled = SimpleNamespace(lost=4, held_bytes=50)
    pair._publisher = SimpleNamespace(publish_all=passed.extend, statistics=lambda: [stalled] * 2)
    good, bad = b"\0\1\0\0" + struct.pack("<iIIB", 5, 0, 1, 0), b""
    arrived = [
        (good, b"a", 1),
        (good, b"a", 4),
        (good, b"b", 7),
        (bad, b"a", 5),
        (good, b"b", 9),
        (good, b"ours", 1),
    ]
    pair._forward(False, [ReceivedMessage(*one) for one in arrived])
    assert vars(pair.count) == {"passed": 4, "lost": 3, "refused": 1, "thinned": 0}
    lost, refused = lines  # each at most once a second
    assert lost == "/quick: 2 messages were lost on the way from ROS 2"
    assert refused.startswith("/quick to ROS 1: ")
    # ROS 1 numbers the messages of a topic.
    assert [struct.unpack_from("<I", one._buff)[0] for one in passed] == [0, 1, 2, 3]
    pair.limit.set_rate(0.01)
    pair._forward(False, [ReceivedMessage(good, b"b", number) for number in (10, 11, 12)])
    assert pair.counts() == TopicCounts(5, lost=3, refused=1, unread=8, thinned=2, held=100)
    # Nothing is lost while the topic has no subscribers in ROS 1.
    pair._subscriptions, pair.kind.cls, pair._other = {}, None, "/quick"
    pair._participant.create_subscription = lambda *_: lambda: None
    for wanted in ({}, {False: QosProfile(9)}):
        pair._switch(wanted)
    pair._forward(False, [ReceivedMessage(good, b"b", 99)])
    assert pair.count.lost == 3


def test_messages_to_ros2_are_counted(ros: both.Both) -> None:
    participant: Any = Keeping()
    kind, bridge = ros.types.message("std_msgs/Float32"), cast(Any, SimpleNamespace(name="/bridge"))
    pair = TopicToRos2(bridge, participant, "/level", "/level", kind, QosProfiles(9, None))

    def forward(data: bytes) -> None:
        message = kind.raw()
        message._buff, message._connection_header = data, {"callerid": "/level_sensor"}
        pair._forward([message])

    pair.limit.set_rate(0.01)
    forward(bytes(4))
    forward(bytes(4))
    pair.limit.set_rate(math.inf)
    forward(b"")
    assert pair.counts() == TopicCounts(passed=1, refused=1, thinned=1, held=9 * 8)


def test_message_has_its_own_bytes_and_a_number_only_if_it_was_given_one(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    codes = [(0, 7), (0, 2**64 - 1), (401, 0), (1, 0)]
    memory = ctypes.create_string_buffer(b"now, and what a longer one has left")

    def take(_: Any, buffer: Any, info: Any, ___: Any) -> int:
        taken = buffer._obj
        taken.buffer = ctypes.addressof(memory)
        taken.buffer_length, taken.buffer_capacity = 3, len(memory)
        code, info._obj.publication_sequence_number = codes.pop(0)
        return code

    monkeypatch.setattr(rcl_take, "_take", take)
    taker = rcl_take.MessageTaker()
    handle = SimpleNamespace(pointer=0, get_topic_name=lambda: "/level")
    first, second, none = (taker.take(handle) for _ in range(3))
    assert first and second and (first.number, second.number, none) == (7, None, None)
    assert first.data == b"now"
    with pytest.raises(RuntimeError, match="cannot take a message of /level: 1"):
        taker.take(handle)


def test_subscription_outlasts_a_restart_of_the_publisher() -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair._found = before = SimpleNamespace(offers={True: False}, latched=True)
    pair.forget_all_but = set
    pair.follow_publishers(SimpleNamespace(offers={}, senders=set()))
    assert pair._found is before
    pair.topic, pair._qualities = "/map", QosProfiles(9, None)
    pair.follow_publishers(SimpleNamespace(offers={True: True}, senders=set()))
    assert pair._wanted == {True: QosProfile(9, latched=True, best_effort=True)}


def test_latched_message_of_ended_ros2_node_is_dropped_and_others_kept() -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair._lock, pair._kept = threading.Lock(), BridgedResources()
    latched: List[List[str]] = []
    pair._publisher = SimpleNamespace(latch_all=lambda messages: latched.append(list(messages)))
    pair._keep({b"gone": LatchedMessage("one"), b"here": LatchedMessage("two")})
    for _ in range(MISSED_POLLS):
        pair.forget_all_but({b"here"})
    assert latched == [["one", "two"], ["two"]]


def test_subscription_is_replaced_by_one_of_another_quality_and_ends_with_its_pair() -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    calls: List[Any] = []

    def subscribe(*given: Any) -> Any:
        calls.append(given[2])
        return partial(calls.append, f"unsubscribed {given[2].depth}")

    pair._participant, pair._subscriptions = SimpleNamespace(create_subscription=subscribe), {}
    pair.kind, pair._other, pair._last = SimpleNamespace(cls=None), "/level", {}
    pair._scope = SimpleNamespace(close=partial(calls.append, "unpublished"))
    before, after = QosProfile(7), QosProfile(8, best_effort=True)
    for quality in (before, before, after):
        pair._switch({False: quality})
    pair.close()
    assert calls == [before, "unsubscribed 7", after, "unsubscribed 8", "unpublished"]


def test_topic_that_cannot_be_subscribed_to_leaves_no_publisher() -> None:
    closed: List[str] = []

    def refuse(*_: Any) -> None:
        raise RCLError("of ROS 2")

    scope = SimpleNamespace(
        create_publisher=lambda *_, **__: None, close=partial(closed.append, "publisher")
    )
    node, participant = SimpleNamespace(create_scope=lambda: scope), cast(Any, SimpleNamespace())
    participant.create_subscription = refuse
    kind: Any = SimpleNamespace(cls=None, raw=None)
    found: Any = SimpleNamespace(offers={True: False}, latched=True)
    with pytest.raises(RCLError, match="of ROS 2"):
        TopicToRos1(cast(Any, node), participant, "/map", "/map", kind, QosProfiles(9, None), found)
    assert closed == ["publisher"]


def test_volatile_message_of_a_latched_topic_is_not_latched() -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    calls: List[Tuple[str, int]] = []
    pair._publisher = SimpleNamespace(
        publish_all=lambda messages: calls.append(("publish", len(messages))),
        latch_all=lambda messages: calls.append(("latch", len(messages))),
    )
    pair._participant = SimpleNamespace(is_own=lambda _: False)
    pair._found, pair._latching = SimpleNamespace(latched=True), {b"plain": False}
    pair._subscriptions, pair._seq, pair._last, pair._lock = {}, 0, {}, threading.Lock()
    pair._kept, pair.count, pair.limit = BridgedResources(), PairCounters(), RateLimit()
    codec = SimpleNamespace(to_ros1=lambda *_: b"")
    pair.kind = SimpleNamespace(raw=SimpleNamespace, codec=codec)
    pair.limit.set_rate(0.01)
    for kept, sender in ((False, b"plain"), (True, b"map"), (True, b"map")):
        pair._forward(kept, [ReceivedMessage(b"", sender, None)])
    # A latched topic keeps the last message until it is told which ones to keep.
    assert calls == [("publish", 1), ("latch", 0), *[("latch", 1), ("publish", 1)] * 2]


@pytest.mark.parametrize("latched", (True, False))
def test_common_subscription_is_best_effort_if_a_publisher_is(latched: bool) -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair.topic, pair._found = "/map", SimpleNamespace(offers={latched: True, not latched: False})
    pair._qualities = QosProfiles(9, [{"topic": "/map", "durability": "volatile"}])
    assert pair._wanted_qualities() == {False: QosProfile(9, best_effort=True)}


def test_failing_topic_does_not_affect_others() -> None:
    followed: List[str] = []

    def fail(_: Any) -> None:
        raise RCLError("one fails")

    def pair(switch: Callable[[Any], Any]) -> Any:
        made: Any = TopicToRos1.__new__(TopicToRos1)
        made._found, made._wanted = SimpleNamespace(latched=True), "wanted"
        made._switch, made.limit = switch, RateLimit()
        return made

    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, SkipLog())
    bridge.pairs.update({Route("/a", False): pair(fail), Route("/b", False): pair(followed.append)})
    with pytest.raises(RCLError, match="one fails"):
        bridge.follow_subscribers1()
    assert followed == ["wanted"]
    bridge.update_pairs = fail
    with pytest.raises(RCLError, match="one fails"):
        rules = Rules(True, True, ["*"], [], max_rates=MaxRates(["/b=5"]))
        bridge.update_topics(rules, Ros1Graph({}, {}, {}, {}, 1), {}, {})
    assert followed == ["wanted"] * 2
    limits = [bridge.pairs[Route(name, False)].limit for name in ("/a", "/b")]
    assert [[limit.passes(now) for now in (0.0, 0.1)] for limit in limits] == [
        [True, True],
        [True, False],
    ]


def test_topic_is_bridged_from_its_publishers() -> None:
    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, SkipLog())
    routes: List[Route] = []
    bridge.update_pairs = routes.extend
    heard = Topic({"std_msgs/msg/Float32"}, set(), set(), {"/display"}, {}, set())
    topics = {"/level": heard, "/speed": heard, "/power": heard._replace(publishers={"/meter"})}
    graph = Ros1Graph({"/level": {"/sensor"}}, {}, {}, {}, 1)
    bridge.update_topics(Rules(True, True, ["*"], []), graph, topics, {})
    assert sorted(routes) == [Route("/level", True), Route("/power", False)]


def test_type_of_a_subscriber_to_any_type_is_unknown() -> None:
    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, SkipLog())
    bridge._types = SimpleNamespace(ros1_name=lambda _: "std_msgs/Float32", message=str)
    bridge._ros1 = Ros1Graph({}, {}, {"/level": "*"}, {}, 1)
    bridge._ros2 = {"/level": Topic({"std_msgs/msg/Float32"}, set(), set(), set(), {}, set())}
    assert bridge._kind(Route("/level", False)) == "std_msgs/Float32"
    assert bridge._kind(Route("/level", True)) is None


def test_topic_with_subscribers_of_another_type_is_not_bridged_to_them() -> None:
    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, SkipLog())
    bridge._types = SimpleNamespace(ros1_name=lambda name: name.replace("/msg", ""), message=str)
    bridge._ros1 = Ros1Graph({}, {}, {"/level": "std_msgs/Float32"}, {}, 1)
    for name, is_same in (("Float32", True), ("String", False)):
        heard = Topic({f"std_msgs/msg/{name}"}, set(), set(), {"/display"}, {}, set())
        bridge._ros2 = {"/level": heard}
        if is_same:
            assert bridge._kind(Route("/level", True)) == "std_msgs/Float32"
            continue
        types = "std_msgs/Float32 in ROS 1, std_msgs/msg/String$"
        with pytest.raises(
            Unbridgeable, match=f"/level to ROS 2, as it has several types: {types}"
        ):
            bridge._kind(Route("/level", True))


@pytest.mark.parametrize("chosen", ([], [{"topic": "/map", "durability": "transient_local"}]))
def test_topic_without_subscribers_is_received_while_it_is_latched(chosen: Any) -> None:
    calls: List[str] = []

    def create_scope() -> Any:
        def close() -> None:
            calls.append("unsubscribed")

        def subscribe(*_: Any, **__: Any) -> None:
            calls.append("subscribed")

        return SimpleNamespace(create_batch_subscription=subscribe, close=close)

    node: Any = SimpleNamespace(create_scope=create_scope)
    participant, kind = cast(Any, Keeping()), cast(Any, SimpleNamespace(cls=None, raw=None))
    pair = TopicToRos2(node, participant, "/map", "/map", kind, QosProfiles(9, chosen))
    for is_heard in (True, False):
        pair.forward_while(is_heard)
    assert calls == (["subscribed"] if chosen else ["subscribed", "unsubscribed"])
    calls.clear()
    pair.forward_while(True)
    pair.publishers.publish("/map_server", b"a", True)
    pair.forward_while(False)
    assert calls == ([] if chosen else ["subscribed"])


def test_topic_keeps_its_type_in_ros1_and_is_bridged_again_once_it_is_latched() -> None:
    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, SkipLog())
    closed: List[str] = []
    to_ros1, to_ros2 = Route("/map", False), Route("/map", True)
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair.kind, pair._found = SimpleNamespace(ros1="a/Map"), SimpleNamespace(latched=False)
    pair.close = partial(closed.append, "volatile")
    bridge.pairs.update({to_ros1: pair, to_ros2: SimpleNamespace(kind=pair.kind)})
    bridge._has_same_type, bridge._has_known_definitions = (lambda *_: True), (lambda _: True)
    bridge._begin = lambda _: "latched"
    # ROS 2's subscriber has another type.
    mixed = Topic({"b/msg/Map"}, {"/map"}, set(), {"/view"}, {False: False}, set())
    bridge._rules, bridge._ros2 = Rules(True, True, ["*"], []), {"/map": mixed}
    bridge._types = SimpleNamespace(ros1_name=str, message=lambda name: SimpleNamespace(ros1=name))
    bridge.update_pairs([to_ros1])
    assert bridge.types() == dict.fromkeys([to_ros1, to_ros2], "a/Map") and not closed
    bridge._ros2 = {"/map": mixed._replace(offers={True: False})}
    bridge.update_pairs([to_ros1])
    assert bridge.pairs[to_ros1] == "latched" and closed == ["volatile"]


def test_topic_is_closed_when_a_publisher_of_another_definition_joins() -> None:
    def differ(_: Route) -> bool:
        raise Unbridgeable("/a: another definition")

    skip_log = SkipLog()
    bridge: Any = TopicBridge(*[cast(Any, None)] * 4, skip_log)
    closed: List[str] = []
    bridge._ros2, bridge._has_same_type = {}, lambda *_: True
    bridge._kind, bridge._has_known_definitions = lambda _: "a kind", differ
    bridge.pairs[Route("/a", False)] = SimpleNamespace(close=lambda: closed.append("/a"))
    bridge.update_pairs([Route("/a", False)])
    assert closed == ["/a"] and skip_log.current() == ["/a: another definition"]


def test_senders_without_number_are_not_all_remembered() -> None:
    pair: Any = TopicToRos1.__new__(TopicToRos1)
    pair._last = {}
    for number in range(5000):
        pair._count_lost(b"%d" % number, 1)
    assert len(pair._last) <= 1000


def test_subscriber_with_deadline_and_liveliness_matches_setting(
    ros: both.Both,
) -> None:
    participant = Participant("/offers")
    offered = {"deadline": 0.5, "liveliness": "manual_by_topic", "liveliness_lease_duration": 1.0}
    qualities = QosProfiles(7, [{"topic": "/heartbeat", **offered, "lifespan": 60.0}])
    quality = qualities.of("/heartbeat")
    publisher = participant.create_publisher(participant.node, Float32, "/heartbeat", quality)
    heard: List[Any] = []
    wanted = QoSProfile(
        depth=7,
        deadline=Duration(seconds=0.5),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=1.0),
    )
    recorder = ros.node.create_subscription(Float32, "/heartbeat", heard.append, wanted)
    wait_until(lambda: publisher.publish(Float32(data=1.0)) or heard, lambda: "they do not match")
    (found,) = ros.node.get_publishers_info_by_topic("/heartbeat")
    assert found.qos_profile.lifespan == Duration(seconds=60.0)
    # A subscription asks for nothing of it: publishers without a deadline match too.
    arrived: List[Any] = []
    end = participant.create_subscription(Float32, "/plain", quality, arrived.extend)
    plain = ros.node.create_publisher(Float32, "/plain", 7)
    wait_until(lambda: plain.publish(Float32(data=1.0)) or arrived, lambda: "it does not match")
    end()
    wait_until(lambda: participant.topics() == {"/heartbeat"}, lambda: str(participant.topics()))
    participant.destroy_publisher(participant.node, publisher)
    assert not participant.topics()
    participant.close()
    ros.node.destroy_subscription(recorder)
    ros.node.destroy_publisher(plain)
