"""Start and end of the bridge, and restarts of other processes."""

import contextlib
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from functools import partial
from types import SimpleNamespace
from typing import Any, List, Set
from unittest import mock

import both
import pytest
import rospkg
import rospy
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger
from test_topics import publisher1

from nodekit import Throttle
from nodekit.testing.processes import hanging
from nodekit.testing.waiting import wait_until
from ros2_bridge.environment.middleware import middleware
from ros2_bridge.graph_loop import GraphLoop
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros1.node_registrar import NodeRegistrar, Registration
from ros2_bridge.ros1.single_instance import domain
from ros2_bridge.ros2 import participant as participant_module
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import Route
from ros2_bridge.rules.skip_log import SkipLog

#: How long roslaunch waits for a node to end before it kills it [s]: its DEFAULT_TIMEOUT_SIGINT,
#: which cannot be imported where messages are those of ROS 2.
ROSLAUNCH_PATIENCE_S = 15.0


def test_clock_of_a_simulation_reaches_ros2(ros: both.Both) -> None:
    rospy.set_param("/use_sim_time", True)
    clock = publisher1(ros, "/clock", "rosgraph_msgs/Clock")
    try:
        with both.Bridge() as bridge:
            recorder = ros.hear2("/clock", Clock)
            wait_until(
                lambda: clock.send(struct.pack("<II", 12, 500)) or recorder.heard,
                lambda: f"no time in ROS 2: {bridge.logged()}",
            )
            assert (recorder.heard[0].clock.sec, recorder.heard[0].clock.nanosec) == (12, 500)
            recorder.end()
            assert bridge.interrupt() == 0
            assert not bridge.logged("Traceback") and not bridge.logged("_buff")
    finally:
        rospy.delete_param("/use_sim_time")
        clock.unregister()


def test_second_bridge_is_refused(ros: both.Both) -> None:
    with both.Bridge() as one, both.Bridge() as two:  # at the same moment, with the same name

        def ended() -> List[both.Bridge]:
            return [bridge for bridge in (one, two) if bridge.popen.poll() is not None]

        wait_until(ended, lambda: "both run")
        (refused,) = ended()
        assert refused.wait() == 1
        first = one if refused is two else two
        marker = f"/ros2_bridge_of_domain_{os.environ['ROS_DOMAIN_ID']}"
        ros.call1(marker, "std_srvs/Trigger", b"")

        def is_named() -> bool:  # if it answers within a second
            with both.Bridge("__name:=another") as second:
                assert second.wait() == 1
                return bool(second.logged("/ros2_bridge already connects this master and this"))

        wait_until(is_named, lambda: "the first one is not named")
        with hanging(first.popen.pid), both.Bridge("__name:=another") as second:
            assert second.wait() == 1
            assert second.logged("another bridge on this machine already connects")
        ros.call1(marker, "std_srvs/Trigger", b"")
        began = time.monotonic()
        assert first.interrupt() == 0
        assert time.monotonic() - began < ROSLAUNCH_PATIENCE_S
        assert not first.logged("Traceback")

        def is_gone() -> bool:
            return ("ros2_bridge", "/") not in ros.node.get_node_names_and_namespaces()

        wait_until(is_gone, lambda: "ROS 2 still lists it", 10.0)  # 20 s if it had been killed


def test_participant_closes_after_its_nodes(
    ros: both.Both, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    participant = Participant("/leaves")
    participant.create_node("/leaves_too")

    def listed() -> List[str]:
        names = ros.node.get_node_names_and_namespaces()
        return sorted(name for name, _ in names if name.startswith(("leaves", "_ros2_bridge")))

    wait_until(lambda: len(listed()) == 2, lambda: str(listed()))
    # Of a node's own, besides what the bridge offers for it.
    assert ros.node.get_service_names_and_types_by_node("leaves", "/") == []
    logs = ros.node.get_publishers_info_by_topic("/rosout")
    assert not [one.node_name for one in logs if one.node_name.startswith("leaves")]

    def temporary() -> List[str]:
        names = ros.node.get_topic_names_and_types()
        return [name for name, _ in names if name.startswith("/_")]

    # The topic by which it has found its id.
    wait_until(lambda: not temporary(), lambda: str(temporary()))
    seen: List[List[str]] = []

    def pause(_: float) -> None:
        wait_until(lambda: listed() == ["_ros2_bridge_ends"], lambda: str(listed()))
        seen.append(listed())

    with monkeypatch.context() as patched:
        patched.setattr(participant_module, "time", SimpleNamespace(sleep=pause))
        participant.close()
    assert seen
    wait_until(lambda: not listed(), lambda: str(listed()))


def test_invalid_domain_is_rejected(ros: both.Both, monkeypatch: "pytest.MonkeyPatch") -> None:
    for number in ("232", ""):
        monkeypatch.setenv("ROS_DOMAIN_ID", number)
        assert domain() == int(number or 0)
    for number in ("-1", "lab", "233"):
        monkeypatch.setenv("ROS_DOMAIN_ID", number)
        with pytest.raises(ValueError, match=rf"is '{number}': must be a whole number in"):
            domain()
    with both.Bridge() as bridge:
        assert bridge.wait() == 1
    assert bridge.error_lines == [
        "bridge: ROS_DOMAIN_ID is '233': must be a whole number in [0, 232]"
    ]


def udp_addresses(pid: int) -> Set[str]:
    """Return the addresses at which a process receives datagrams of IPv4."""
    links = set()
    for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # closed meanwhile
            links.add(os.readlink(link))
    rows = [row.split() for row in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]]
    found = [row[1].split(":")[0] for row in rows if f"socket:[{row[9]}]" in links]
    return {socket.inet_ntoa(struct.pack("=I", int(address, 16))) for address in found}


def test_only_the_loopback_interface_is_listened_to(ros: both.Both) -> None:
    with both.Bridge() as bridge:
        wait_until(lambda: udp_addresses(bridge.popen.pid), lambda: "it does not listen")
        recorder = ros.hear2("/rosout", Log)
        recorder.wait()
        assert udp_addresses(bridge.popen.pid) == {"127.0.0.1"}
        recorder.end()


#: Prints the sizes of the buffers of a participant's sockets that receive [bytes].
BUFFERS = """
import os, rclpy, socket
rclpy.init()
node = rclpy.create_node("buffers")
for name in os.listdir("/proc/self/fd"):
    try:
        one = socket.socket(fileno=os.dup(int(name)))
    except OSError:
        continue
    if one.family == socket.AF_INET and one.getsockname()[1] in range(7400, 65000):
        print(one.getsockname()[1], one.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF))
"""


@pytest.mark.parametrize("reach", ("LOCALHOST", "SUBNET"))
def test_sockets_hold_several_large_messages_if_linux_allows_it(reach: str) -> None:
    loopback = pathlib.Path(rospkg.RosPack().get_path("ros2_bridge"), "config", "loopback.xml")
    reached = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": reach}
    variables = {**os.environ, **middleware(reached, loopback)}
    output = subprocess.check_output([sys.executable, "-c", BUFFERS], env=variables, text=True)
    sizes = dict(map(int, line.split()) for line in output.splitlines())
    most = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text())
    # Linux doubles the size. Other sockets, with ports of its own choice, only send.
    assert list(sizes.values()).count(2 * min(most, 2**24)) >= 2, sizes


def test_doctor_calls_a_bridge_with_nodes_on_both_sides_healthy(
    ros: both.Both, tmp_path: pathlib.Path
) -> None:
    ros.master.kill()  # it lists nodes that earlier tests have killed
    ros.master.start()
    with both.Running("basic_comms", "talker.py"), both.Bridge():
        recorder = ros.hear2("/chatter", String)
        recorder.wait()
        done = subprocess.run(
            ["rosrun", "nodekit", "doctor"],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
            timeout=60.0,
        )
        recorder.end()
    assert done.returncode == 0, done.stdout
    assert done.stdout.endswith("healthy\n")


def test_killed_and_started_again(ros: both.Both) -> None:
    out = ros.node.create_publisher(Float32, "/again", 10)
    recorder = ros.hear1("/again", "std_msgs/Float32")
    for number in range(3):

        def hears() -> bool:
            # ROS 2 notices only after 20 s that a killed subscriber is gone.
            out.publish(Float32(data=float(number)))
            return any(one._buff == struct.pack("<f", number) for one in list(recorder.heard))

        with both.Bridge() as bridge:
            wait_until(hears, lambda: "nothing comes through")
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
    recorder.end()
    ros.node.destroy_publisher(out)


def test_registrations_of_killed_bridge_are_replaced(ros: both.Both) -> None:
    node = Node("left_behind")

    def answer(_: Any, response: Any) -> Any:
        response.success = True
        return response

    node.create_service(Trigger, "left", answer)
    node.create_publisher(Float32, "/left_behind", 10)
    ros.executor.add_node(node)

    def listed() -> List[str]:
        publishers, _, services = rospy.get_master().getSystemState()[2]
        return dict(services).get("/left", []) + dict(publishers).get("/left_behind", [])

    def answers() -> bool:
        with contextlib.suppress(rospy.ServiceException):  # of the killed bridge
            return ros.call1("/left", "std_srvs/Trigger", b"")[:1] == b"\1"
        return False

    mine = ["/left_behind", "/ros2_bridge", "/left_behind"]
    for _ in range(2):
        with both.Bridge() as bridge:
            wait_until(lambda: listed() == mine and answers(), lambda: str(listed()))
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
    with both.Bridge() as bridge:
        wait_until(answers, lambda: str(listed()))
        ros.executor.remove_node(node)
        node.destroy_node()
        wait_until(lambda: not listed(), lambda: str(listed()))
        assert not bridge.logged("registered again")


def test_no_registration_after_close(ros: both.Both) -> None:
    nodes = NodeRegistrar("/ros2_bridge")
    nodes.register({"/early": set()}, set(), False)
    assert rospy.get_master().lookupNode("/early")[0] == 1
    nodes.close()
    nodes.register({"/early": set(), "/late": set()}, set(), False)  # by a poll that was slow
    assert rospy.get_master().lookupNode("/early")[0] == -1
    assert rospy.get_master().lookupNode("/late")[0] == -1


def test_poll_of_the_graphs_updates_each_part(monkeypatch: "pytest.MonkeyPatch") -> None:
    loop: Any = GraphLoop.__new__(GraphLoop)
    parts = ("parameters", "renaming", "graph", "nodes", "rosout", "topics", "services", "actions")
    for part in (*parts, "description", "nodes_in_ros1"):
        setattr(loop, f"_{part}", mock.MagicMock())
    loop._ended, loop._skip_log, loop._master_pid = threading.Event(), SkipLog(), 0
    loop._trouble, loop._polled_at = "nothing new is bridged", 0.0
    speed = Topic({"std_msgs/msg/Float32"}, {"/motor"}, set(), {"/display"}, {}, set())
    loop._graph.nodes.return_value = {"/motor", "/display"}
    loop._graph.topics.return_value = {"/speed": speed}
    loop._services.servers.return_value = {"/reset": "/motor"}
    kind = "std_msgs/Float32"
    loop._topics.types.return_value = {Route("/speed", True): kind, Route("/speed", False): kind}
    loop._renaming.in_ros2.return_value = None
    loop._graph.nameless, loop._graph.shared_names = {"/lost"}, {"/twice"}
    # The first poll finds nodes of a killed bridge; later the master is started again.
    pids, stale = [1, 1, 1, 2, 2], [True, False, False, False]
    loop._nodes_in_ros1.remove_stale.side_effect = stale
    graphs = [Ros1Graph({"/rosout": {"/a"}}, {}, {}, {"/free": "/rosout"}, pid) for pid in pids]
    read = iter(graphs)
    loop._read_ros1 = lambda: next(read)
    # Parts that fail keep no other from being updated.
    loop._throttle = Throttle(60.0)
    monkeypatch.setattr(rospy, "logerr", id)
    for part in (loop._topics.close_denied, loop._topics.update_topics, loop._description.update):
        part.side_effect = RuntimeError("of one part")
    loop._services.update_services.side_effect = RuntimeError("of another")
    restarted = []
    reasons = []
    for _ in stale:
        loop._poll_graphs()
        reasons.append([reason.partition(":")[0] for reason in loop._skip_log.current()])
        ros1, *_, is_restarted = loop._nodes.update_nodes.call_args[0]
        entries, _, is_registered_again = loop._nodes_in_ros1.register.call_args[0]
        restarted.append((is_restarted, is_registered_again))
    assert ros1 is graphs[-1]
    assert restarted == [(False, False), (False, False), (True, True), (False, False)]
    assert entries == {
        "/motor": {Registration("Publisher", "/speed", kind), Registration("Service", "/reset")},
        "/display": {Registration("Subscriber", "/speed", kind)},
    }
    for part in (loop._topics, loop._services, loop._actions):
        part.close_denied.assert_called_with(loop._parameters.values.bridged.return_value)
    assert loop._actions.update_actions.call_count == len(stale)
    assert loop._trouble == "" and loop._polled_at > 0.0
    of_ros1 = ["/a of ROS 1", "/free of ROS 1"]
    twice = "several nodes of ROS 2 are called /twice, or one that was killed is still listed"
    assert reasons[0] == [*of_ros1, "/lost of ROS 2", twice]
    assert reasons[-1] == of_ros1  # those of ROS 2 are of the first poll


def test_graphs_are_polled_often_at_first_and_goals_followed_in_between(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    errors: List[str] = []
    monkeypatch.setattr(rospy, "logerr", errors.append)
    loop: Any = GraphLoop.__new__(GraphLoop)
    calls: List[str] = []

    def fail() -> None:
        calls.append("topics")
        raise RuntimeError("of one topic")

    loop._node, loop._throttle = SimpleNamespace(is_up=True), Throttle(60.0)
    loop._poll_graphs = partial(calls.append, "poll")
    loop._topics = SimpleNamespace(follow_subscribers1=fail)
    loop._actions = SimpleNamespace(follow=partial(calls.append, "goals"))
    ends = iter([False] * 15 + [True])
    loop._ended = SimpleNamespace(wait=lambda _: next(ends), is_set=lambda: False)
    loop._run()
    assert calls == [*["poll"] * 10, *["topics", "goals"] * 4, "poll"]
    assert len(errors) == 1 and "of one topic" in errors[0]


def test_failure_at_shutdown_does_not_stop_the_rest() -> None:
    ended: List[str] = []

    def fail() -> None:
        raise RuntimeError("a goal does not end")

    loop: Any = GraphLoop.__new__(GraphLoop)
    loop._ended, loop._thread = threading.Event(), threading.Thread()
    loop._thread.start()
    loop._actions = SimpleNamespace(end_goals=fail)
    for part in ("nodes_in_ros1", "participant"):
        setattr(loop, f"_{part}", SimpleNamespace(close=partial(ended.append, part)))
    loop.close()
    assert loop._ended.is_set() and ended == ["nodes_in_ros1", "participant"]


def test_no_message_is_lost_and_all_are_counted(ros: both.Both) -> None:
    with both.Bridge():
        out2 = ros.node.create_publisher(Float32, "/quick2", 1000)
        out1 = publisher1(ros, "/quick1", "std_msgs/Float32")
        recorder1, recorder2 = (
            ros.hear1("/quick2", "std_msgs/Float32"),
            ros.hear2("/quick1", Float32),
        )
        told = ros.hear1("/ros2_bridge/statistics", "std_msgs/String")

        def send(number: float) -> None:
            out1.send(struct.pack("<f", number))
            out2.publish(Float32(data=number))

        def numbers() -> List[List[float]]:
            heard = (
                [struct.unpack("<f", m._buff)[0] for m in recorder1.heard],
                [m.data for m in recorder2.heard],
            )
            return [[number for number in one if number >= 0.0] for one in heard]

        # Numbers of listeners do not tell when a way is open: ROS 2 counts those too that were
        # killed, and knows of one before it sends to it.
        wait_until(
            lambda: send(-1.0) or (recorder1.heard and recorder2.heard), lambda: "a way is shut"
        )
        for number in range(800):
            send(float(number))
        wait_until(lambda: min(map(len, numbers())) >= 800, lambda: str([*map(len, numbers())]))
        assert numbers() == 2 * [[float(number) for number in range(800)]]

        def counted() -> bool:
            text = [message._buff[4:] for message in told.heard[-1:]]
            topics = yaml.safe_load(text[0])["topics"] if text else {}
            found = [topics.get(way, {}).get(name, {}) for way, name in WAYS]
            passed = [one.get("passed") for one in found]
            return passed == [len(recorder1.heard), len(recorder2.heard)] and not any(
                one["lost"] or one["refused"] for one in found
            )

        wait_until(
            counted, lambda: f"{len(recorder1.heard), len(recorder2.heard)}, {told.heard[-1:]}"
        )
        for recorder in (recorder1, recorder2, told):
            recorder.end()
        out1.unregister()
        ros.node.destroy_publisher(out2)


WAYS = (("to_ros1", "/quick2"), ("to_ros2", "/quick1"))


#: Name of the bridge's own status on /diagnostics.
HEALTH = "ros2_bridge: bridge"


def test_master_dies_and_returns(ros: both.Both) -> None:
    node = Node("plant")
    node.declare_parameter("gain", 2.5)
    out = node.create_publisher(Float32, "/level", 10)
    ros.executor.add_node(node)
    with both.Running("basic_comms", "talker.py") as talker, both.Bridge() as bridge:
        recorder = ros.hear2("/chatter", String)
        recorder.wait()
        diagnostics = ros.hear2("/diagnostics", DiagnosticArray)

        def is_master_error_reported() -> bool:
            statuses = [s for a in diagnostics.heard[-1:] for s in a.status if s.name == HEALTH]
            # The second while it registers a topic, as it then asks until the master answers.
            words = ("nothing new is bridged: ", "the graphs have not been read for ")
            return any(
                s.level == DiagnosticStatus.ERROR and s.message.startswith(words) for s in statuses
            )

        wait_until(lambda: rospy.get_param("/plant/gain", None) == 2.5, lambda: "no gain")
        ros.master.kill()
        heard = len(recorder.heard)
        recorder.wait(heard + 3)  # what is connected goes on without it
        wait_until(is_master_error_reported, lambda: f"no error in {diagnostics.heard[-1:]}")
        ros.master.start()
        wait_until(lambda: not is_master_error_reported(), lambda: "still an error")
        diagnostics.end()
        wait_until(
            lambda: [n for _, n in rospy.get_master().getSystemState()[2][0] if "/talker" in n],
            lambda: "the talker does not come back",
        )
        recorder.wait(len(recorder.heard) + 20)
        assert ros.node.count_publishers("/chatter")

        def is_told_anew() -> bool:
            published = dict(rospy.get_master().getSystemState()[2][0])
            node_of_ros2 = rospy.get_master().lookupNode("/plant")[0] == 1
            is_published = "/ros2_bridge" in published.get("/level", [])
            return node_of_ros2 and is_published and rospy.get_param("/plant/gain", None) == 2.5

        wait_until(is_told_anew, lambda: "the new master does not know of ROS 2")
        talker.interrupt()
        wait_until(lambda: not ros.node.count_publishers("/chatter"), lambda: "it stays")
        assert not bridge.logged("Traceback")
        recorder.end()
    ros.executor.remove_node(node)
    node.destroy_publisher(out)
    node.destroy_node()


def test_bridge_may_start_before_master(ros: both.Both) -> None:
    out = ros.node.create_publisher(Float32, "/early", 10)
    with both.Bridge() as bridge:
        ros.master.kill()
        bridge.wait_for_log("waiting for the master")
        ros.master.start()
        recorder = ros.hear1("/early", "std_msgs/Float32")
        wait_until(
            lambda: out.publish(Float32(data=1.5)) or recorder.heard,
            lambda: f"nothing comes: {bridge.logged()}, {rospy.get_master().getSystemState()}",
        )
        recorder.end()
        assert bridge.interrupt() == 0
    ros.node.destroy_publisher(out)
