"""Bridge to a ROS 2 node on another host, across a network without multicast."""

import subprocess
from typing import Dict, List, NamedTuple

from ..benchmark.peer_programs import (
    RCLPY,
    SCRIPTS,
    WORKSPACE,
    executable,
    make_rclpy,
    rclpy_environment,
)
from ..benchmark.recorder import wait_until
from .checks import Check
from .hosts import ADDRESSES, Hosts

#: Longest time until messages return, and time for which none may return [s].
WITHIN_S, SILENT_S = 45, 15
PORT = "11811"


class Way(NamedTuple):
    """Environment variables of both sides, and whether messages cross; see docs/ros2_bridge.md."""

    bridge: Dict[str, str]
    other: Dict[str, str]
    crosses: bool = True


SUBNET = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
PEER_OF_BRIDGE = {**SUBNET, "ROS_STATIC_PEERS": ADDRESSES["far"]}
PEER_OF_OTHER = {**SUBNET, "ROS_STATIC_PEERS": ADDRESSES["near"]}
SERVER = {"ROS_DISCOVERY_SERVER": f"{ADDRESSES['near']}:{PORT}"}
WAYS = {
    "neither peers nor a server": Way(SUBNET, SUBNET, crosses=False),
    "peers of the bridge": Way(PEER_OF_BRIDGE, SUBNET),
    "peers of the other host": Way(SUBNET, PEER_OF_OTHER),
    "peers, but two domains": Way(
        {**PEER_OF_BRIDGE, "ROS_DOMAIN_ID": "1"}, {**SUBNET, "ROS_DOMAIN_ID": "2"}, crosses=False
    ),
    "a discovery server": Way(SERVER, SERVER),
}


def run(hosts: Hosts) -> List[Check]:
    """Send messages from ROS 1 to the other host and back, in each way."""
    reason = make_rclpy()
    if reason:
        return [Check("the environment with ROS 2", "exists", reason, False)]
    for host in ADDRESSES:
        for chain in ("INPUT", "OUTPUT"):
            hosts.run_on(host, f"iptables -A {chain} -d 224.0.0.0/4 -j DROP".split())
    hosts.start_on("near", ["rosmaster", "--core", "-p", "11311"])
    hosts.start_on("near", executable("basic_comms", "talker.py"))
    wait_until(lambda: "/talker" in hosts.nodes(), 60.0, "talker")
    server = [str(WORKSPACE / "ci" / "ros2"), "fast-discovery-server", "-i", "0"]
    hosts.start_on("near", [*server, "-l", ADDRESSES["near"], "-p", PORT])
    return [check(hosts, name, way) for name, way in WAYS.items()]


def check(hosts: Hosts, name: str, way: Way) -> Check:
    """Check whether messages return from the other host."""
    echo = [str(RCLPY), str(SCRIPTS / "bridge" / "echo.py")]
    other = {name: text for name, text in rclpy_environment().items() if not name.startswith("ROS")}
    started = [
        hosts.start_on(
            "near",
            executable("ros2_bridge", "bridge"),
            {**hosts.environment_of("near"), **way.bridge},
        ),
        hosts.start_on("far", echo, {**other, **way.other}),
    ]
    within = ["timeout", str(WITHIN_S if way.crosses else SILENT_S)]
    try:
        hosts.run_on("near", [*within, "rostopic", "echo", "-n", "1", "/heard"])
        figure = "messages"
    except subprocess.CalledProcessError:
        figure = "nothing"
    hosts.stop(*started)
    bound = "messages" if way.crosses else "nothing"
    return Check(f"with {name}", bound, figure, figure == bound)
