"""Names of nodes and types, the log, /tf and /clock."""

import struct
import subprocess
import sys
from functools import partial
from types import SimpleNamespace
from typing import Any, Dict, List, Set, cast

import both
import pytest
import rospy
from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from test_topics import publisher1
from tf2_msgs.msg import TFMessage

from nodekit.testing.waiting import wait_until
from ros2_bridge import node_bridge
from ros2_bridge.environment.ros1_messages import Header
from ros2_bridge.environment.ros1_messages import Log as Ros1Log
from ros2_bridge.node_bridge import NodeBridge, NodeToRos2
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.graph import Ros2Graph
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.rules.active_pairs import BridgedResources
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.topics.rosout import Rosout


def test_each_side_lists_the_other_s_nodes(ros: both.Both, bridge: both.Bridge) -> None:
    node = Node("lidar", namespace="/front")
    ros.executor.add_node(node)

    def in_ros1() -> bool:
        state = rospy.get_master().getSystemState()[2]
        return any("/front/lidar" in nodes for part in state for _, nodes in part)

    wait_until(in_ros1, lambda: "/front/lidar is not in rosnode list")
    assert ("rosout", "/") not in ros.node.get_node_names_and_namespaces()
    with both.Running("basic_comms", "talker.py", "__ns:=/lab") as talker:
        wait_until(
            lambda: ("talker", "/lab") in ros.node.get_node_names_and_namespaces(),
            lambda: str(ros.node.get_node_names_and_namespaces()),
        )
        wait_until(
            lambda: (
                ("/lab/chatter", ["std_msgs/msg/String"]) in ros.node.get_topic_names_and_types()
            ),
            lambda: str(ros.node.get_topic_names_and_types()),
        )
        log = ros.hear2("/rosout", Log)
        wait_until(
            lambda: [line for line in log.heard if line.name == "lab.talker"],
            lambda: str(log.heard),
        )
        log.end()
        talker.interrupt()
    wait_until(
        lambda: ("talker", "/lab") not in ros.node.get_node_names_and_namespaces(),
        lambda: "it stays there",
    )
    ros.executor.remove_node(node)
    node.destroy_node()
    wait_until(lambda: not in_ros1(), lambda: "/front/lidar stays in rosnode list")


def test_ros1_and_ros2_node_may_share_a_name(ros: both.Both, bridge: both.Bridge) -> None:
    node = Node("twice")
    ros.executor.add_node(node)

    def uri() -> Any:
        return rospy.get_master().lookupNode("/twice")[2]

    wait_until(uri, lambda: "/twice is not in rosnode list")
    of_bridge = uri()
    with both.Running("basic_comms", "talker.py", "__name:=twice") as talker:
        recorder = ros.hear2("/chatter", String)
        recorder.wait(3)  # what it publishes is not taken for the bridge's own
        assert uri() != of_bridge  # the master had the one before it shut down
        recorder.end()
        talker.interrupt()
    wait_until(lambda: uri() == of_bridge, lambda: "that of ROS 2 does not come back")
    ros.executor.remove_node(node)
    node.destroy_node()
    assert bridge.popen.poll() is None


def test_tf_and_clock(ros: both.Both, bridge: both.Bridge) -> None:
    static = publisher1(ros, "/tf_static", "tf2_msgs/TFMessage", latch=True)
    name = struct.pack("<I4s", 4, b"odom")
    header = struct.pack("<III", 0, 7, 8) + name
    static.send(struct.pack("<I", 1) + header + name + struct.pack("<7d", *range(7)))
    recorder = ros.hear2("/tf_static", TFMessage, latched=True)
    (transform,) = recorder.wait()[0].transforms
    assert (transform.header.stamp.sec, transform.child_frame_id) == (7, "odom")
    assert transform.transform.rotation.w == 6.0
    recorder.end()
    static.unregister()
    out = ros.node.create_publisher(Clock, "/clock", 10)
    clock = Clock()
    clock.clock.sec = 42
    recorder1 = ros.hear1("/clock", "rosgraph_msgs/Clock")
    wait_until(lambda: out.get_subscription_count(), lambda: "the bridge does not listen")
    out.publish(clock)
    assert recorder1.wait()[0]._buff == struct.pack("<II", 42, 0)
    recorder1.end()
    ros.node.destroy_publisher(out)


def test_types_that_do_not_fit_are_named(ros: both.Both, bridge: both.Bridge) -> None:
    out = publisher1(ros, "/mixed", "std_msgs/Float32")
    other: Any = ros.node.create_publisher(String, "/mixed", 10)
    bridge.wait_for_log("/mixed", "std_msgs/Float32 in ROS 1", "std_msgs/msg/String")
    out.unregister()
    ros.node.destroy_publisher(other)


def test_topic_with_two_types_is_logged(ros: both.Both, bridge: both.Bridge) -> None:
    out = publisher1(ros, "/half", "std_msgs/Float32")
    wait_until(
        lambda: ("/half", ["std_msgs/msg/Float32"]) in ros.node.get_topic_names_and_types(),
        lambda: "/half is not in ROS 2",
    )
    other: Any = ros.node.create_publisher(String, "/half", 10)
    line = "/half to ROS 1, as it has several types: std_msgs/Float32 in ROS 1, std_msgs/msg/String"
    bridge.wait_for_log(f"{line} (to ROS 2 it is bridged as std_msgs/Float32)")
    out.unregister()
    ros.node.destroy_publisher(other)


def test_pairs_are_printed(ros: both.Both) -> None:
    script = str(both.SOURCES / "ros2_bridge" / "scripts" / "bridge")
    done = subprocess.run(
        [sys.executable, script, "--print-pairs"], capture_output=True, text=True, timeout=60.0
    )
    pairs = done.stdout.splitlines()
    assert "basic_comms/signal_msg <=> basic_comms/msg/SignalMsg" in pairs
    assert "std_srvs/Trigger <=> std_srvs/srv/Trigger" in pairs
    assert "sensor_msgs/Range <=> sensor_msgs/msg/Range" in pairs
    assert "rosgraph_msgs/Log needs rosgraph_msgs/msg/Log, which is not installed" in done.stderr


class FewNodes(NodeBridge):
    """Shows nodes, but no parameters."""

    def __init__(self) -> None:
        self.log = SkipLog()
        self.qualities: List[QosProfile] = []

        def create_publisher(*given: Any) -> Any:
            self.qualities.append(given[3])
            return SimpleNamespace(publish=None)

        participant: Any = SimpleNamespace(
            node=None,
            create_publisher=create_publisher,
            create_subscription=lambda *given: self.qualities.append(given[2]),
            create_node=lambda _: object(),
            destroy_node=id,
        )
        nothing: Any = None
        super().__init__(nothing, participant, nothing, Renaming(), self.log, bool)
        self._to_ros2, self._to_ros1 = BridgedResources(1), BridgedResources(1)

    def _parameters(self, name: str, style: str) -> None:
        return None

    def shown(self, nodes: str, most: int = 100, parameters: bool = True) -> Dict[str, str]:
        """Poll a graph of such nodes."""
        self.update_nodes(self.graph(nodes), set(), (), parameters, most, False)
        return {name: node.style for name, node in self._to_ros2.items()}

    @staticmethod
    def graph(nodes: str) -> Ros1Graph:
        """Return a graph of such nodes, of which only /d describes its parameters."""
        services = {"/d/describe": "/d", "/d/change": "/d"} if "d" in nodes else {}
        heard = {"/rosout": {f"/{name}" for name in nodes}}
        return Ros1Graph({}, heard, {}, services, 1)


def test_no_more_nodes_appear_than_may() -> None:
    bridge = FewNodes()
    assert set(bridge.shown("bc")) == {"/b", "/c"}
    assert not bridge.log.next_line(0.0)
    assert set(bridge.shown("abcdefg", most=3)) == {"/a", "/b", "/c"}  # existing nodes stay
    line = "not bridged: nodes of ROS 1 beyond ~max_nodes, 3: /d, /e, /f and 1 more"
    assert bridge.log.next_line(0.0) == line
    bridge.shown("abcdef", most=3)
    assert bridge.log.next_line(2.0) == line.replace(" and 1 more", "")
    assert set(bridge.shown("ac1", most=1)) == {"/c"}
    assert set(bridge.shown("1ac", most=2)) == {"/a", "/c"}  # ROS 2 has no node /1
    assert bridge.shown("ac", most=0) == {}


def test_parameters_of_ros2_nodes_are_limited(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    def made(*_: Any) -> Any:
        return SimpleNamespace(retry_write_all=dict, report_unfit=dict, close=dict)

    monkeypatch.setattr(node_bridge, "ParametersToRos1", made)
    bridge = FewNodes()
    bridge._update_to_ros1({"/b", "/c"}, 2, False)
    before = dict(bridge._to_ros1)
    assert set(before) == {"/b", "/c"} and not bridge.log.next_line(0.0)
    bridge._update_to_ros1({"/a", "/b", "/c"}, 2, False)
    assert bridge._to_ros1 == before  # existing nodes stay
    line = "not bridged: parameters of nodes of ROS 2 beyond ~max_nodes, 2: /a"
    assert bridge.log.next_line(0.0) == line


def test_parameters_are_bridged_as_the_node_and_the_user_want() -> None:
    bridge = FewNodes()
    assert bridge.shown("cd") == {"/c": "none", "/d": "described"}
    nodes = bridge.in_ros2()
    bridge._since["/c"] -= 6.0  # it has had its time to describe them
    assert bridge.shown("cd") == {"/c": "plain", "/d": "described"}
    assert bridge.shown("cd", parameters=False) == {"/c": "none", "/d": "none"}
    assert bridge.in_ros2() == nodes  # or calls of their services would be given up each time
    assert set(bridge.shown("d")) == {"/d"}
    assert bridge.shown("cd")["/c"] == "none"  # started again: it has its time again
    bridge.update_nodes(bridge.graph("cd"), {"/d"}, (), True, 100, False)  # of ROS 2 itself
    assert set(bridge.in_ros2()) == {"/c"}


def test_parameters_of_a_node_are_closed_before_others_and_with_it() -> None:
    closed: List[Any] = []
    participant: Any = SimpleNamespace(create_node=str)
    node = NodeToRos2(participant, "/arm", closed.append)
    parts: List[Any] = [SimpleNamespace(close=partial(closed.append, name)) for name in "ab"]
    node.set_parameters("plain", parts[0])
    node.set_parameters("described", parts[1])
    assert closed == ["a"]
    node.close()
    assert closed == ["a", "b", "/arm"]


def test_parameters_of_ros2_nodes_are_written_if_wanted_and_to_each_new_master(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    calls: List[str] = []

    def make(*given: Any) -> Any:
        names = ("report_unfit", "write_all", "retry_write_all", "close")
        return SimpleNamespace(**{name: partial(calls.append, name) for name in names})

    monkeypatch.setattr(node_bridge, "ParametersToRos1", make)
    bridge, names = FewNodes(), {"/b", "/c", "/d"}
    services = {f"{name}/list_parameters" for name in ("/b", "/c")}

    def poll(is_wanted: bool, is_restarted: bool = False) -> List[str]:
        calls.clear()
        graph = bridge.graph("c")  # a node of this name is in both
        bridge.update_nodes(graph, names, services, is_wanted, 9, is_restarted)
        return calls

    assert poll(False) == [] and not bridge._to_ros1
    assert poll(True) == [] and set(bridge._to_ros1) == {"/b"}
    assert poll(True) == ["report_unfit", "retry_write_all"]
    assert poll(True, is_restarted=True) == ["report_unfit", "write_all"]
    assert poll(False) == ["close"]


def test_changes_of_nodes_of_ros2_alone_are_written_to_ros1() -> None:
    bridge: Any = FewNodes()
    written: List[str] = []
    bridge._participant.is_own = lambda sender: sender == b"ours"
    bridge._names = Renaming(["/lab=/"])
    mirror: Any = SimpleNamespace(write_event=lambda event: written.append(event.node))
    bridge._to_ros1.update({"/lab/motor": mirror, "/motor": None})
    events = [serialize_message(ParameterEvent(node=name)) for name in ("/motor", "/unknown")]
    senders = (b"ours", b"theirs")
    bridge._forward_events([ReceivedMessage(one, who, 1) for one in events for who in senders])
    assert written == ["/motor"]
    assert bridge.qualities == [QosProfile(1000)] * 2  # as rclpy's, for many changes at once


def test_node_that_ros2_refuses_keeps_no_other_from_appearing(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    def make(name: str) -> Any:
        if "b" in name:
            raise ValueError("too long")
        return SimpleNamespace(retry_write_all=dict, report_unfit=dict, close=dict)

    bridge = FewNodes()
    bridge._participant.create_node = make
    for _ in range(2):
        assert bridge.shown("abc") == {"/a": "none", "/c": "none"}
    assert bridge.log.next_line(0.0) == "not bridged: /b: too long"
    monkeypatch.setattr(node_bridge, "ParametersToRos1", lambda *given: make(given[2]))
    bridge._update_to_ros1({"/d", "/e/b", "/f"}, 9, False)
    assert set(bridge._to_ros1) == {"/d", "/f"}
    assert bridge.log.next_line(2.0) == "not bridged: /e/b: too long"


class ManyTopics:
    """Fake graph with 200 own topics, one of which others use, too."""

    def __init__(self) -> None:
        self.node, self.asked = self, 0
        self.names = [f"/t{number}" for number in range(200)]

    def topics(self) -> Any:
        return set(self.names)

    def own_names(self) -> Any:
        return {"/bridge"}

    def is_alone_with(self, topic: str) -> bool:
        self.asked += 1
        return topic != "/t150"

    def is_own(self, gid: bytes) -> bool:
        return gid != b"theirs"

    def get_topic_names_and_types(self) -> Any:
        return [(name, []) for name in (*self.names, "/rosout", "/parameter_events")]

    def get_node_names_and_namespaces(self) -> Any:
        twice = [("bridge", "/"), ("lidar", "/front"), ("_daemon", "/")]
        return [*twice, *twice, ("camera", "/front")]

    def get_publisher_names_and_types_by_node(self, name: str, namespace: str) -> Any:
        return []

    get_subscriber_names_and_types_by_node = get_publisher_names_and_types_by_node

    def get_publishers_info_by_topic(self, topic: str) -> Any:
        return []

    def get_subscriptions_info_by_topic(self, topic: str) -> Any:
        assert topic != "/parameter_events"  # hundreds are published, by nodes of ours
        return [
            SimpleNamespace(
                endpoint_gid=b"theirs" if topic == "/t150" else b"ours",
                topic_type="",
                topic_type_hash="INVALID",
                node_name="_DDS_",
                node_namespace="/",
            )
        ]


def test_many_topics_of_ours_are_asked_about_in_turn() -> None:
    participant: Any = ManyTopics()
    graph, seen = Ros2Graph(participant, Renaming()), []
    for _ in range(8):
        seen.append("/t150" in graph.topics())
    first = seen.index(True)
    assert first < 4 and all(seen[first:])  # a program without a node is found, and stays
    assert participant.asked <= 8 * 53
    assert graph.shared_names == {"/front/lidar"}  # its services are those of one node only


def test_of_several_servers_of_a_service_the_last_by_name_counts() -> None:
    participant: Any = ManyTopics()
    reset = ("/reset", ["std_srvs/srv/Trigger"])
    participant.get_service_names_and_types_by_node = lambda *_: [reset]
    graph: Any = Ros2Graph(participant, Renaming())
    for nodes in (["/b", "/a"], ["/a", "/b"]):  # sets have any order
        assert graph.services(nodes) == {"/reset": ("std_srvs/srv/Trigger", "/b")}


def test_name_of_a_node_in_ros2_is_kept_to_ask_it() -> None:
    participant: Any = ManyTopics()
    participant.names = ["/t150"]
    topic = Ros2Graph(participant, Renaming(["/lab=/"])).topics()["/lab/t150"]
    assert topic.subscribers == {"/lab/_DDS_"}
    assert topic.definitions == {(False, "", "INVALID", "/_DDS_")}


def test_nodes_without_a_name_in_ros1_are_reported() -> None:
    participant: Any = ManyTopics()
    graph = Ros2Graph(participant, Renaming(["/front=/robot"]))
    assert graph.nodes() == set()
    assert graph.nameless == {"/front/lidar", "/front/camera"}


class TwoPublishers(ManyTopics):
    """Fake graph with a topic of two publishers of others.

    :param policies: their reliability
    """

    def __init__(self, *policies: ReliabilityPolicy) -> None:
        super().__init__()
        self.policies = policies

    def get_publishers_info_by_topic(self, topic: str) -> Any:
        found = self.get_subscriptions_info_by_topic(topic) * len(self.policies)
        return [
            SimpleNamespace(
                **vars(one),
                qos_profile=SimpleNamespace(
                    reliability=policy, durability=DurabilityPolicy.VOLATILE
                ),
            )
            for one, policy in zip(found, self.policies)
        ]


@pytest.mark.parametrize("order", (1, -1))
def test_topic_is_best_effort_if_a_publisher_is(order: int) -> None:
    policies = (ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE)[::order]
    participant: Any = TwoPublishers(*policies)
    participant.names = ["/t150"]
    assert Ros2Graph(participant, Renaming()).topics()["/t150"].offers == {False: True}


def test_type_of_a_topic_is_that_of_its_publishers_if_it_has_any() -> None:
    for policies, kind in (((), ""), ((ReliabilityPolicy.RELIABLE,), "std_msgs/msg/String")):
        participant: Any = TwoPublishers(*policies)
        participant.names = ["/t150"]
        found = participant.get_publishers_info_by_topic("/t150")
        for one in found:
            one.topic_type = kind
        participant.get_publishers_info_by_topic = lambda _, found=found: found
        assert Ros2Graph(participant, Renaming()).topics()["/t150"].types == {kind}


def test_log_line_of_ros1_is_the_same_in_ros2() -> None:
    sent: List[Any] = []
    participant: Any = SimpleNamespace(
        node="bridge", create_publisher=lambda *_: SimpleNamespace(publish=sent.append)
    )
    header = Header(stamp=rospy.Time(5, 7))
    line = Ros1Log(header, Ros1Log.ERROR, "/lab/arm", "it sticks", "arm.cpp", "move", 3, [])
    Rosout(cast(Any, None), participant, Renaming(["/lab=/"]))._forward(line)
    line.level = 3  # which ROS 1 does not have
    Rosout(cast(Any, None), participant, Renaming())._forward(line)
    log, other = sent
    assert (other.level, other.name) == (Log.INFO, "lab.arm")
    assert (log.stamp.sec, log.stamp.nanosec, log.level) == (5, 7, Log.ERROR)
    assert (log.name, log.msg, log.file) == ("arm", "it sticks", "arm.cpp")
    assert (log.function, log.line) == ("move", 3)


def test_log_line_is_that_of_the_present_node() -> None:
    sent: List[Any] = []
    ended: List[Any] = []
    qualities: Set[QosProfile] = set()

    def create_publisher(owner: Any, _: Any, __: str, quality: QosProfile) -> Any:
        qualities.add(quality)
        return SimpleNamespace(publish=lambda log: sent.append((owner, log.msg)))

    participant: Any = SimpleNamespace(
        node="bridge",
        create_publisher=create_publisher,
        destroy_publisher=lambda owner, _: ended.append(owner),
    )
    rosout, owners = Rosout(cast(Any, None), participant, Renaming()), cast(Any, dict)
    for nodes in ({}, {"/arm": "first"}, {"/arm": "again"}, {"/arm": "again"}, {}):
        rosout.update_nodes(owners(nodes))
        rosout._forward(Ros1Log(Header(), Ros1Log.INFO, "/arm", "it moves", "", "", 0, []))
    nodes_of_lines = ["bridge", "first", "again", "again", "bridge"]
    assert sent == [(node, "it moves") for node in nodes_of_lines]
    assert ended == ["first", "again"]
    assert qualities == {QosProfile(1000, latched=True)}  # as rclpy's nodes
