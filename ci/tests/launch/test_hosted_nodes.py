"""Tests that every node publishes the same topics in its own process and hosted with all others."""

import os
import pathlib
import subprocess
import sys
from typing import Dict, Iterator, List, Set

import pytest
import rosgraph

from nodekit.testing.processes import Master
from nodekit.testing.waiting import wait_until

from . import node_processes

HERE = pathlib.Path(__file__).parent
SOURCES = HERE.parents[2] / "src"
WAYS = ["separate", "hosted"]
#: Services of a process, not of a node.
OF_PROCESS = ("/get_loggers", "/set_logger_level")
#: Longest start of all nodes on a busy machine [s].
TIMEOUT_S = 120.0
#: The topics with messages, without those of dynamic_reconfigure.
HEARD = {
    "basics/output_topic",
    "basics/robot_command",
    "basics/topic_name",
    "loop/controller/terms",
    "loop/motor_input",
    "loop/motor_output",
    "loop/set_point",
    "managed/lifecycle_aware_node/heartbeat",
    "managed/lifecycle_aware_node/state",
    "motor/motor_input_u",
    "motor/motor_speed_y",
    "motor/motor_state",
    "parameters/camera/camera_info",
    "parameters/camera/image_color",
    "parameters/chatter",
    "parameters/lidar/points",
    "parameters/radar/tracks",
    "plant/output",
    "random/cmd_vel",
    "robot/contact",
    "robot/ground_truth",
    "robot/joint_states",
    "robot/odom",
    "robot/world",
    "sensors/data/camera",
    "sensors/data/lidar",
    "sensors/data/temperature",
    "signals/chatter",
    "signals/proc_signal",
    "signals/signal",
    "signals/signal_generator/status",
    "status/robot_status",
}
#: Further advertised topics, with messages only after events.
SILENT = {
    "managed/lifecycle_aware_node/transition_event",
    "robot/cmd_vel",
    "robot/scan",
    "robot/waypoint_controller/arrived",
    "robot/waypoint_controller/current_goal",
    "robot/waypoint_controller/progress",
    "basics/mean_brightness",
}


@pytest.fixture(scope="module")
def master() -> Iterator[rosgraph.Master]:
    """Run all nodes separately and hosted; yield a client of their master."""
    server = Master()
    path = f"{HERE}:{os.environ['PYTHONPATH']}"
    environment = {**os.environ, "ROS_MASTER_URI": server.uri, "PYTHONPATH": path}
    processes: List[subprocess.Popen] = []
    try:
        for way in WAYS:
            command = [sys.executable, str(HERE / "node_processes.py"), way, way]
            processes.append(
                subprocess.Popen(
                    command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
                )
            )
        yield rosgraph.Master("/test", server.uri)
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait(TIMEOUT_S)
        server.kill()


def of_nodes(way: str, topics: List[str]) -> Set[str]:
    """Return topics without their space, and without those of dynamic_reconfigure."""
    return {
        topic[len(f"/{way}/") :]
        for topic in topics
        if not topic.endswith(("/parameter_descriptions", "/parameter_updates"))
    }


def heard(master: rosgraph.Master) -> Dict[str, Set[str]]:
    """Return the topics that a subscriber in the same or in another process has received.

    Whether it is connected before the first event of a topic in SILENT is a matter of chance.
    """
    found: Dict[str, Set[str]] = {}
    for way in WAYS:
        key = node_processes.HEARD.format(way)
        topics = of_nodes(way, master.getParam(key) if master.hasParam(key) else [])
        found[way] = topics - SILENT
    return found


def advertised(master: rosgraph.Master) -> Dict[str, Set[str]]:
    """Return the advertised topics."""
    topics = [topic for topic, _ in master.getPublishedTopics("/")]
    return {
        way: of_nodes(way, [topic for topic in topics if topic.startswith(f"/{way}/")])
        for way in WAYS
    }


def services(master: rosgraph.Master) -> List[Set[str]]:
    """Return the services of nodes."""
    names = [name for name, _ in master.getSystemState()[2] if not name.endswith(OF_PROCESS)]
    return [{name[len(way) + 2 :] for name in names if name.startswith(f"/{way}/")} for way in WAYS]


def differences(found: Dict[str, Set[str]], expected: Set[str]) -> str:
    return str({way: topics ^ expected for way, topics in found.items()})


def test_hosted_nodes_publish_the_same_as_separate_nodes(master: rosgraph.Master) -> None:
    # Some nodes have no message that could be waited for, and register last.
    for found, expected in (heard, HEARD), (advertised, HEARD | SILENT):
        wait_until(
            lambda: found(master) == {way: expected for way in WAYS},
            lambda: differences(found(master), expected),
            TIMEOUT_S,
        )

    def separate_and_hosted_are_equal() -> bool:
        separate, hosted = services(master)
        return hosted == separate and len(hosted) > 0

    wait_until(separate_and_hosted_are_equal, lambda: str(services(master)), TIMEOUT_S)


def test_every_node_is_run_or_left_out_for_a_reason() -> None:
    modules = {
        f"{path.parents[1].name}.nodes.{path.stem}"
        for path in SOURCES.glob("*/src/*/nodes/*.py")
        if path.stem != "__init__"
    }
    run = {module for part in node_processes.NODES.values() for module in part}
    assert run.isdisjoint(node_processes.LEFT_OUT)
    assert run.union(node_processes.LEFT_OUT) == modules
