"""Run nodes as separate processes, or all in one, and record their topics.

``node_processes.py separate|hosted SPACE`` runs every node of :data:`NODES` until it is ended.
"""

import importlib
import os
import signal
import sys
from typing import Any, Dict, List, Set

#: Nodes that are not run here, and the reason.
LEFT_OUT: Dict[str, str] = {
    "basic_comms.nodes.fleet": "hosts nodes of the list",
    "diff_drive_sim.nodes.diff_drive_fleet": "hosts nodes of the list",
    "bot_controller_demo.nodes.proportional_controller": "publishes on the random one's topic",
    "bot_controller_demo.nodes.teleop_keyboard": "needs a terminal",
    "lifecycle_manager.nodes.lifecycle_manager": "needs a list of nodes",
    "my_robot_package.nodes.service_client_node": "ends after its call",
    "robot_interfaces_demo.nodes.robot_status_demo": "hosts nodes of the list",
    "ros2_bridge.nodes.bridge": "needs ROS 2",
    "serial_link.nodes.avr_board": "needs a compiler for AVR",
    "serial_link.nodes.serial_node": "needs a board",
    "serial_link.nodes.simulated_board": "needs a terminal",
    "topic_scope.nodes.scope": "serves a web page",
}
#: Modules that most nodes import.
PRELOADED = (
    "dynamic_reconfigure.server",
    "geometry_msgs.msg",
    "nav_msgs.msg",
    "nodekit.entry_point",
    "numpy",
    "rospy",
    "sensor_msgs.msg",
    "std_msgs.msg",
    "std_srvs.srv",
)
#: Parameter with the topics that the recorder has received.
HEARD = "/{}/recorder/heard"

#: Modules of nodes that need no hardware, terminal, file or other program, by their namespace.
#: Nodes of one namespace work together.
NODES: Dict[str, List[str]] = {
    "signals": [
        f"basic_comms.nodes.{name}" for name in "talker listener signal_generator process".split()
    ],
    "loop": [
        f"pid_control.nodes.{name}" for name in "set_point_generator system controller".split()
    ],
    "motor": ["motor_control.nodes.dc_motor", "motor_control.nodes.set_point"],
    "plant": ["first_order_sys_sim.nodes.first_order_sys"],
    "robot": [
        "diff_drive_sim.nodes.diff_drive",
        "bot_controller_demo.nodes.waypoint_controller",
    ],
    "random": ["bot_controller_demo.nodes.random_controller"],
    "executors": [
        f"executors_demo.nodes.{name}"
        for name in (
            "emergency_stop mutex_reentrant parallel_node several_nodes single_threaded "
            "slow_service two_mutex"
        ).split()
    ],
    "sensors": [
        f"launch_files_demo.nodes.{name}_demo_node"
        for name in "camera lidar processing temperature".split()
    ],
    "managed": [f"lifecycle_demo.nodes.{name}_node" for name in "example lifecycle_aware".split()],
    "basics": [
        f"my_robot_package.nodes.{name}"
        for name in (
            "add_two_ints_server advanced_node another_node command_node efficient_node "
            "logging_node my_node parameterized_node robust_node"
        ).split()
    ],
    "parameters": [
        f"parameters_demo.nodes.{name}"
        for name in (
            "camera_demo configurable_node lidar_demo parameter_types parameterized_publisher "
            "processing_demo radar_demo"
        ).split()
    ],
    "status": [
        f"robot_interfaces_demo.nodes.{name}" for name in "fleet_monitor robot_monitor".split()
    ],
}


class Recorder:
    """Subscriber of all topics of a space; sets ``~heard`` to the topics with messages."""

    def __init__(self, node: Any) -> None:
        self._node, self._space = node, node.name.rpartition("/")[0]
        self._topics: Set[str] = set()
        self._heard: Set[str] = set()
        node.create_timer(5.0, self._subscribe_to_new)

    def _subscribe_to_new(self, _elapsed: float) -> None:
        rosgraph, roslib = map(importlib.import_module, ("rosgraph", "roslib.message"))
        master = rosgraph.Master(self._node.name)
        for topic, kind in master.getPublishedTopics(self._space + "/"):
            if topic not in self._topics:
                self._topics.add(topic)
                add = self._heard.add
                self._node.create_subscription(
                    topic, roslib.get_message_class(kind), lambda _, topic=topic: add(topic)
                )
        master.setParam(HEARD.format(self._space[1:]), sorted(self._heard))


def main() -> None:
    """Run the nodes until this process is ended."""
    how, space = sys.argv[1:]
    # Imported before the forks, to save time in each.
    for name in PRELOADED:
        importlib.import_module(name)
    nodekit = importlib.import_module("nodekit")
    for name in nodekit.__all__:  # which it imports when it is asked for them
        getattr(nodekit, name)
    nodes = [(f"{space}/{part}", module) for part, modules in NODES.items() for module in modules]
    nodes.append((space, "node_processes"))
    if how == "hosted":
        sys.argv[1:] = [member(*node) for node in nodes]
        importlib.import_module("nodekit.entry_point").run_command("host")
        return
    # Blocked before the forks, so that an early signal ends the children too.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    children = [fork(space, module) for space, module in nodes]
    signal.sigwait({signal.SIGTERM})
    for child in children:
        os.kill(child, signal.SIGTERM)
    for child in children:
        os.waitpid(child, 0)


def member(space: str, module: str) -> str:
    """Return a node as an argument of ``rosrun nodekit host``."""
    if module == "node_processes":
        return f"{space}/recorder=node_processes:Recorder"
    name = module.rpartition(".")[2]
    words = {"my_node": "MyRobotNode", "first_order_sys": "FirstOrderSystem"}
    cls = words.get(name, "".join(word.capitalize() for word in name.split("_")))
    return f"{space}/{name}={module}:{cls}"


def fork(space: str, module: str) -> int:
    """Run a node in a child; return its process id."""
    child = os.fork()
    if not child:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
        run(space, module)
    return child


def run(space: str, module: str) -> None:
    """Run the ``main`` of a module in a namespace, and end the process."""
    os.environ["ROS_NAMESPACE"] = space
    sys.argv[1:] = [f"__name:={module.rpartition('.')[2]}"]
    # Alone among the preloaded modules it reads arguments and environment when it is imported.
    importlib.reload(sys.modules["rospy.names"])
    if module == "node_processes":
        sys.argv[1:] = []
        importlib.import_module("nodekit").run("recorder", Recorder)
    else:
        importlib.import_module("nodekit.entry_point").main(module)


if __name__ == "__main__":
    main()
