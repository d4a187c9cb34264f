"""Health of the bridge: /diagnostics in both ROSes, and rosrun ros2_bridge report."""

import contextlib
import os
import signal
import socket
import struct
import subprocess
import time
import xmlrpc.client
from types import SimpleNamespace
from typing import Any, Dict, Iterator, List

import both
import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message
from rosgraph.network import encode_ros_handshake_header
from std_msgs.msg import Float32, Header, String
from test_topics import publisher1

from nodekit.testing.waiting import wait_until
from ros2_bridge import diagnostics
from ros2_bridge.graph_loop import GraphLoop
from ros2_bridge.ros1.single_instance import marker
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.skip_log import SkipLog

REPORT = both.SOURCES / "ros2_bridge" / "scripts" / "report"
NAMES = ["bridge", "topics to ROS 2", "topics to ROS 1", "not bridged"]
#: After 2038-01-19, which ROS 2 cannot represent.
LATE = struct.pack("<IIII", 0, 2**31, 0, 0)


def report(**environment: str) -> "subprocess.CompletedProcess[str]":
    """Run the command with ROS 1's Python."""
    command = ["/usr/bin/python3", str(REPORT)]
    variables = {**os.environ, **environment}
    return subprocess.run(command, env=variables, capture_output=True, text=True, timeout=60.0)


class Diagnostics:
    """Diagnostics of the bridge, received in both ROSes; those of other nodes are ignored."""

    def __init__(self, ros: both.Both) -> None:
        self._to_cdr = ros.types.message("diagnostic_msgs/DiagnosticArray").codec.to_cdr
        self._recorders = (
            ros.hear1("/diagnostics", "diagnostic_msgs/DiagnosticArray"),
            ros.hear2("/diagnostics", DiagnosticArray),
        )

    def __enter__(self) -> "Diagnostics":
        return self

    def __exit__(self, *_: Any) -> None:
        for recorder in self._recorders:
            recorder.end()

    def latest(self) -> List[Dict[str, Any]]:
        """Return the latest statuses by name, from each ROS; empty before the first."""
        in_ros1 = [
            deserialize_message(self._to_cdr(one._buff), DiagnosticArray)
            for one in self._recorders[0].heard[-3:]
        ]
        return [
            {
                status.name.partition(": ")[2]: status
                for array in arrays
                for status in array.status
                if status.name.startswith("ros2_bridge: ")
            }
            for arrays in (in_ros1, self._recorders[1].heard[-3:])
        ]

    def age(self) -> float:
        """Return the age of the latest message in ROS 2 [s]."""
        return time.time() - float(self._recorders[1].heard[-1].header.stamp.sec)


def level(statuses: Dict[str, Any], name: str) -> int:
    return int.from_bytes(statuses[name].level, "little")


def test_passed_messages_are_reported_with_their_rate(ros: both.Both, bridge: both.Bridge) -> None:
    out = ros.node.create_publisher(Float32, "/healthy", 10)
    timer = ros.node.create_timer(0.05, lambda: out.publish(Float32(data=1.0)))
    recorder = ros.hear1("/healthy", "std_msgs/Float32")
    with Diagnostics(ros) as diagnostics:

        def rates() -> List[float]:
            found = []
            for statuses in diagnostics.latest():
                values = statuses["topics to ROS 1"].values if statuses else ()
                texts = [value.value for value in values if value.key == "/healthy"]
                found += [float(text.partition(" Hz, ")[0]) for text in texts]
            return found

        wait_until(
            lambda: len(rates()) == 2 and min(rates()) > 5.0, lambda: str(diagnostics.latest())
        )
        for statuses in diagnostics.latest():
            assert sorted(statuses) == sorted(NAMES)
            assert statuses["bridge"].message == "follows both graphs"
            assert statuses["bridge"].hardware_id == os.uname().nodename
            memory = next(v.value for v in statuses["bridge"].values if v.key == "memory [bytes]")
            assert 1e7 < int(memory) < 1e10
        assert diagnostics.age() < 60.0
    assert max(rates()) < 100.0
    (row,) = [line.split() for line in report().stdout.splitlines() if line.startswith("/healthy ")]
    assert row[1:3] == ["ROS", "1"]
    assert float(row[3]) > 5.0
    assert int(row[4]) >= 10
    ros.node.destroy_timer(timer)
    ros.node.destroy_publisher(out)
    recorder.end()


@pytest.mark.extended
def test_refused_message_is_a_warning_and_an_exit_status_of_the_report(
    ros: both.Both, bridge: both.Bridge
) -> None:
    out = publisher1(ros, "/late", "std_msgs/Header")
    recorder = ros.hear2("/late", Header)
    with Diagnostics(ros) as diagnostics:

        def is_seen() -> bool:
            found = diagnostics.latest()
            return all(
                one
                and level(one, "topics to ROS 2") == 1
                and "/late (" in one["topics to ROS 2"].message
                for one in found
            )

        wait_until(lambda: out.send(LATE) or is_seen(), lambda: str(diagnostics.latest()))
        done = report()
        assert (done.returncode, done.stderr) == (1, "")
        assert "WARN topics to ROS 2: in the last 10 s: " in done.stdout
        (row,) = [line.split() for line in done.stdout.splitlines() if line.startswith("/late ")]
        assert row[1:3] == ["ROS", "2"]
        assert int(row[6]) >= 1  # refused
        # The warning ends some seconds after the last fault; the counter stays.
        wait_until(
            lambda: all(
                "/late (" not in one["topics to ROS 2"].message for one in diagnostics.latest()
            ),
            lambda: str(diagnostics.latest()),
        )
    recorder.end()
    out.unregister()


@contextlib.contextmanager
def mute_subscriber(ros: both.Both, topic: str) -> Iterator[None]:
    """Subscribe to a topic of the bridge in ROS 1, as /mute, and never read."""
    raw = ros.types.message("std_msgs/String").raw
    uri = rospy.get_master().lookupNode(both.NAME)[2]
    proxy: Any = xmlrpc.client.ServerProxy(uri)
    _, _, (_, host, port) = proxy.requestTopic("/mute", topic, [["TCPROS"]])
    with socket.create_connection((host, port)) as mute:
        fields = {"topic": topic, "md5sum": raw._md5sum, "type": raw._type, "callerid": "/mute"}
        mute.sendall(encode_ros_handshake_header(fields))
        yield


def test_messages_dropped_for_a_stalled_subscriber_are_counted(
    ros: both.Both, bridge: both.Bridge
) -> None:
    out = ros.node.create_publisher(String, "/unread", 10)
    message = String(data="x" * 3_000_000)

    def row() -> List[str]:
        lines = report().stdout.splitlines()
        return next((line.split() for line in lines if line.startswith("/unread ")), [])

    recorder = ros.hear1("/unread", "std_msgs/String")
    wait_until(lambda: out.publish(message) or recorder.heard, lambda: "not bridged")
    with mute_subscriber(ros, "/unread"), Diagnostics(ros) as diagnostics:

        def is_seen() -> bool:
            out.publish(message)
            return all(
                one and "dropped for subscribers that do not" in one["topics to ROS 1"].message
                for one in diagnostics.latest()
            )

        wait_until(is_seen, lambda: str(diagnostics.latest()))
        found = row()
        assert int(found[7]) >= 1  # unread
        assert int(found[9]) > 3_000_000  # queue [bytes]
    wait_until(lambda: row()[7:] == ["0", "0", "0", "bytes"], lambda: str(row()))
    recorder.end()
    ros.node.destroy_publisher(out)


def test_topic_that_is_not_bridged_is_a_warning_until_it_ends(
    ros: both.Both, bridge: both.Bridge
) -> None:
    class Unknown(rospy.AnyMsg):  # type: ignore[misc]
        _type, _md5sum, _full_text = "nowhere_msgs/Odd", "0" * 32, ""

    publisher = rospy.Publisher("/odd_type", Unknown, queue_size=1)
    with Diagnostics(ros) as diagnostics:

        def reasons() -> List[bool]:
            return [
                bool(one) and any("nowhere_msgs/Odd" in v.value for v in one["not bridged"].values)
                for one in diagnostics.latest()
            ]

        wait_until(lambda: all(reasons()), lambda: str(diagnostics.latest()))
        assert all(level(one, "not bridged") == 1 for one in diagnostics.latest())
        done = report()
        assert done.returncode == 1
        assert [line for line in done.stdout.splitlines() if line.startswith("not bridged: ")]
        publisher.unregister()
        wait_until(lambda: not any(reasons()), lambda: str(diagnostics.latest()))


def test_bridge_that_has_not_read_the_graphs_for_10_s_reports_an_error() -> None:
    published: List[Any] = []
    loop: Any = GraphLoop.__new__(GraphLoop)
    loop._node, loop._trouble = SimpleNamespace(name="/ros2_bridge"), ""
    loop._skip_log, times = SkipLog(), []
    loop._monitor = SimpleNamespace(update=lambda now, _: times.append(now) or {})
    loop._topics = SimpleNamespace(counts=lambda: {})
    loop._services, loop._actions = SimpleNamespace(pairs={1, 2}), SimpleNamespace(pairs={1})
    loop._diagnostics = SimpleNamespace(has_subscribers=lambda: True, publish=published.append)
    for seconds, is_well in ((0.0, True), (9.0, True), (12.0, False)):
        loop._polled_at = time.monotonic() - seconds
        loop.update_health()
        assert (published[-1][0].level == 0) is is_well
        assert loop.report()[0] is is_well
    assert loop.report()[1].startswith("/ros2_bridge: ERROR the graphs have not been read for 12")
    assert "services 2, actions 1, memory" in loop.report()[1]
    assert times == sorted(times) and times[0] > loop._polled_at  # of now, for the rates


def test_diagnostics_have_their_name_and_subscribers_in_ros2(ros: both.Both) -> None:
    names: List[str] = []
    heard = {"/diagnostics": 0, "/lab/diagnostics": 0}

    def create(name: str) -> Any:
        names.append(name)
        return SimpleNamespace(
            get_num_connections=lambda: heard[name], get_subscription_count=lambda: heard[name]
        )

    node: Any = SimpleNamespace(create_publisher=lambda *given: create(given[0]))
    participant: Any = SimpleNamespace(node=None, create_publisher=lambda *given: create(given[2]))
    made = diagnostics.Diagnostics(node, participant, ros.types, Renaming(["/=/lab"]))
    assert names == list(heard) and not made.has_subscribers()
    for name in names:
        heard.update({"/diagnostics": 0, "/lab/diagnostics": 0, name: 1})
        assert made.has_subscribers()


def test_report_without_a_bridge_fails_with_the_reason(ros: both.Both) -> None:
    other = report(ROS_DOMAIN_ID="231")
    assert (other.returncode, other.stdout) == (2, "")
    (line,) = other.stderr.splitlines()
    assert line.startswith("report: no bridge to domain 231 is running; start one with 'roslaunch")
    invalid = report(ROS_DOMAIN_ID="233")
    assert (invalid.returncode, invalid.stdout) == (2, "")
    assert "ROS_DOMAIN_ID is '233': must be a whole number in [0, 232]" in invalid.stderr
    missing = report(ROS_MASTER_URI="http://localhost:1/")
    assert (missing.returncode, missing.stdout) == (2, "")
    assert missing.stderr.startswith("report: no master at ")


def test_report_of_a_suspended_bridge_fails_with_the_reason(
    ros: both.Both, bridge: both.Bridge
) -> None:
    wait_until(lambda: not rospy.wait_for_service(marker(), 10.0), lambda: "no marker")
    bridge.popen.send_signal(signal.SIGSTOP)
    try:
        done = report()
    finally:
        bridge.popen.send_signal(signal.SIGCONT)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("report: the bridge does not answer: ")
