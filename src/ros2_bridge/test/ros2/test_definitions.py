"""ROS 2 nodes with another definition of a type: no value is mixed up, and the user is informed."""

import os
import pathlib
import subprocess
import sys
from types import SimpleNamespace
from typing import Any, Callable, Iterator, List

import both
import pytest
import rospy
from std_msgs.msg import Int32
from test_topics import publisher1

from nodekit.testing.waiting import TIMEOUT_S
from ros2_bridge.environment import twin_builder
from ros2_bridge.ros2 import peer_definitions
from ros2_bridge.ros2.peer_definitions import PeerDefinitions
from ros2_bridge.rules.skip_log import Unbridgeable

PREFIX = pathlib.Path(sys.prefix)
#: Sends and receives a message; its fields are distinguished by their values.
PEER = """
import sys
import rclpy
from pid_control.msg import MotorInput, SetPoint

rclpy.init()
node = rclpy.create_node(sys.argv[2])
cls = {"MotorInput": MotorInput, "SetPoint": SetPoint}[sys.argv[2]]
message = cls()
for number, name in enumerate(cls.get_fields_and_field_types(), 1):
    setattr(message, name, float(number))
out = node.create_publisher(cls, sys.argv[1], 10)
node.create_timer(0.1, lambda: out.publish(message))
node.create_subscription(cls, sys.argv[1] + "_back", lambda message: print(message, flush=True), 10)
rclpy.spin(node)
"""
#: The same fields as the bridge's, in another order; and in the same order, one with another name.
SWAPPED = "float64 time\nfloat32 input\n"
RENAMED = "float32 wanted\nfloat64 time\n"


@pytest.fixture(scope="module")
def peer(tmp_path_factory: "pytest.TempPathFactory") -> Iterator[Callable[..., pathlib.Path]]:
    """Return a function that starts a node in an environment with other definitions of two types.

    It returns the file of the node's received messages.
    """
    place = tmp_path_factory.mktemp("other")
    prefix, twins = place / "ros2", place / "twins"
    subprocess.run(["cp", "-rs", str(PREFIX), str(prefix)], check=True)
    for library in (prefix / "lib").glob("libpid_control__*"):
        library.unlink()  # or the builder would write through the links
    source = twins / "pid_control" / "source"
    (source / "msg").mkdir(parents=True)
    given = PREFIX.with_name(PREFIX.name + "_twins") / "pid_control" / "source"
    (source / "package.xml").write_text((given / "package.xml").read_text())
    (source / "msg" / "MotorInput.msg").write_text(SWAPPED)
    (source / "msg" / "SetPoint.msg").write_text(RENAMED)
    python = str(prefix / "bin" / "python")
    builder = [python, twin_builder.__file__, str(twins), "pid_control"]
    # Without this process's, which name the libraries of the other environment.
    kept = ("HOME", "PATH", "ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")
    environment = {name: value for name, value in os.environ.items() if name in kept}
    environment["AMENT_PREFIX_PATH"] = str(prefix)
    subprocess.run(builder, env=environment, check=True)
    assert not (source.parent / "error").exists(), (source.parent / "error").read_text()
    script = place / "peer.py"
    script.write_text(PEER)
    running = []

    def start(topic: str, name: str) -> pathlib.Path:
        output = place / f"{name}.txt"
        with output.open("w") as file:
            running.append(
                subprocess.Popen([python, str(script), topic, name], env=environment, stdout=file)
            )
        return output

    yield start
    for each in running:
        each.kill()
        each.wait(TIMEOUT_S)


def test_swapped_fields_are_not_passed_and_both_definitions_are_named(
    ros: both.Both, bridge: both.Bridge, peer: Callable[..., pathlib.Path]
) -> None:
    recorder = ros.hear1("/swapped", "pid_control/motor_input")
    received = peer("/swapped", "MotorInput")
    out = publisher1(ros, "/swapped_back", "pid_control/motor_input")
    there, here = "(double time, float input) there", "(float input, double time) in the bridge"
    for topic in "/swapped", "/swapped_back":
        bridge.wait_for_log(
            f"{topic}: /MotorInput has another definition of pid_control/msg/MotorInput"
        )
        bridge.wait_for_log(topic, there, here)
    assert not ros.node.count_publishers("/swapped_back") and not out.get_num_connections()
    assert not recorder.heard and not received.read_text(), (recorder.heard, received.read_text())
    out.unregister()
    recorder.end()


def test_other_names_in_the_same_order_are_passed_with_a_warning(
    ros: both.Both, bridge: both.Bridge, peer: Callable[..., pathlib.Path]
) -> None:
    recorder = ros.hear1("/renamed", "pid_control/set_point")
    peer("/renamed", "SetPoint")
    assert len(recorder.wait()[0]._buff) == 12
    bridge.wait_for_log("/renamed: /SetPoint has another definition", "with other names", "wanted")
    recorder.end()


def test_other_definitions_of_ros1_are_named_with_both_checksums(
    ros: both.Both, bridge: both.Bridge
) -> None:
    raw = ros.types.message("std_msgs/Int32").raw
    older = type("Older", (raw,), {"_md5sum": "0" * 32, "__slots__": []})
    out = rospy.Publisher("/older", older, queue_size=1)
    received = ros.hear2("/older", Int32)
    bridge.wait_for_log("/older", "0" * 32, raw._md5sum)
    sent = ros.node.create_publisher(Int32, "/newer", 10)
    subscriber = rospy.Subscriber("/newer", older)
    bridge.wait_for_log("/newer", "0" * 32, raw._md5sum)
    assert not received.heard
    subscriber.unregister()
    ros.node.destroy_publisher(sent)
    received.end()
    out.unregister()


def test_package_that_needs_a_failed_one_is_not_built(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(twin_builder, "SITE", tmp_path / "site")
    run_step = twin_builder.StepRunner()
    steps: List[str] = []

    def package(name: str, *needs: str) -> twin_builder.Package:
        (tmp_path / name).mkdir()
        return twin_builder.Package(name, tmp_path / name, list(needs))

    def fail() -> None:
        raise RuntimeError("x.c:3:\n  error: no")

    assert not run_step(package("odd"), fail)
    assert not run_step(package("user", "std_msgs", "odd"), lambda: steps.append("user"))
    assert run_step(package("good", "std_msgs"), lambda: steps.append("good"))
    assert steps == ["good"]
    reasons = {path.parent.name: path.read_text() for path in tmp_path.glob("*/error")}
    assert reasons == {"odd": "x.c:3: error: no", "user": "it needs odd, which does not build"}


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("echo In file x.c:; echo 'x.c:3: error: no'; echo 'error: 2'; exit 1", "x.c:3: error: no"),
        ("echo compiling; echo killed; exit 2", "killed"),
        ("exit 3", "sh ended with 3"),
    ],
)
def test_first_error_of_the_compiler_is_the_reason(script: str, reason: str) -> None:
    with pytest.raises(RuntimeError, match=f"^{reason}$"):
        twin_builder.run("sh", "-c", script)


def test_libraries_of_an_earlier_build_are_replaced(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(twin_builder, "LIBRARIES", tmp_path)
    monkeypatch.setattr(twin_builder, "link", lambda *_: None)
    monkeypatch.setattr(twin_builder, "add_to_index", lambda _: None)
    package = twin_builder.Package("acme_msgs", tmp_path / "acme_msgs", [])
    for _ in range(2):
        twin_builder.link_package(package, [])
    named = {path.name: os.readlink(path) for path in tmp_path.iterdir()}
    kinds = (twin_builder.FASTRTPS, twin_builder.INTROSPECTION)
    assert named == {f"libacme_msgs__{kind}.so": "libacme_msgs__twin.so" for kind in kinds}


class SilentClient:
    """Client of a service that is not offered."""

    made: "List[SilentClient]" = []

    def __init__(self, *_: Any) -> None:
        self.made.append(self)
        self.is_closed = False

    def is_ready(self) -> bool:
        return False

    def close(self) -> None:
        self.is_closed = True


def test_node_that_did_not_describe_its_type_is_asked_again(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(peer_definitions, "Ros2Client", SilentClient)
    definitions: Any = PeerDefinitions(None)  # type: ignore[arg-type]
    asked = ("/speed", "std_msgs/msg/Int32", "RIHS01_other", "/wheel")
    monkeypatch.setattr(peer_definitions, "_TIMEOUT_S", 0.0)
    with pytest.raises(Unbridgeable, match="/speed: /wheel has .* does not describe it"):
        definitions.are_known_to_fit(*asked)
    monkeypatch.setattr(peer_definitions, "_TIMEOUT_S", TIMEOUT_S)
    assert definitions.are_known_to_fit(*asked) is False
    assert definitions.are_known_to_fit(*asked[:3], "/arm") is False  # each node has its own
    assert [client.is_closed for client in SilentClient.made] == [True, False, False]
    assert definitions.are_known_to_fit(*asked[:2], "INVALID", "/of_an_older_ros2")
    assert len(SilentClient.made) == 3


def test_definition_is_requested_once_its_service_exists() -> None:
    ready, calls = iter((False, True, True)), []
    client: Any = SimpleNamespace(
        is_ready=lambda: next(ready),
        send=lambda request, _: calls.append(request),
        close=lambda: calls.append("closed"),
    )
    question = peer_definitions._DefinitionRequest(client, "request")
    assert not calls
    for count in (0, 1, 1):
        question.send_once_ready()
        assert calls == ["request"] * count
    question._receive(SimpleNamespace(successful=False))
    assert question.fields is None
    for _ in range(2):
        question.close()
    assert calls == ["request", "closed"]


def test_other_names_are_warned_of_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    definitions: Any = PeerDefinitions(None)  # type: ignore[arg-type]
    name, its_hash, node = "std_msgs/msg/Int32", "RIHS01_other", "/wheel"
    theirs = [one._replace(name="value") for one in definitions._own_definition(name)[1]]
    answered = SimpleNamespace(fields=theirs, close=lambda: None)
    definitions._questions[name, its_hash, node] = answered
    for _ in range(2):  # at each poll
        assert definitions.are_known_to_fit("/speed", name, its_hash, node)
    (line,) = lines
    assert line.startswith("/speed: /wheel has another definition of std_msgs/msg/Int32, with")
    _, fields = definitions._own_definition("std_msgs/msg/Header")
    names = [one.name for one in fields]
    assert names == ["stamp.sec", "stamp.nanosec", "frame_id"]  # compared as they are sent
