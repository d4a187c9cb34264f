"""Environment variables of the ROS 2 middleware."""

import pathlib
from typing import Dict

import pytest

from ros2_bridge.environment.middleware import middleware

LOOPBACK = pathlib.Path("/bridge/loopback.xml")
BY_LOOPBACK = {
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4?sockets_size=16MB",
    "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(LOOPBACK),
}


@pytest.mark.parametrize("environ", ({}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}))
def test_only_nodes_of_this_machine_are_seen_unasked(environ: Dict[str, str]) -> None:
    assert middleware(environ, LOOPBACK) == BY_LOOPBACK
    assert middleware(BY_LOOPBACK, LOOPBACK) == BY_LOOPBACK  # as after the start of another Python


def test_other_machines_are_visible_on_request() -> None:
    given = middleware({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, LOOPBACK)
    assert given["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert given["FASTDDS_BUILTIN_TRANSPORTS"] == BY_LOOPBACK["FASTDDS_BUILTIN_TRANSPORTS"]
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in given


@pytest.mark.parametrize("name", ("ROS_STATIC_PEERS", "FASTRTPS_DEFAULT_PROFILES_FILE"))
def test_explicit_variables_are_kept(name: str) -> None:
    environ = {name: "mine", "FASTDDS_BUILTIN_TRANSPORTS": "DEFAULT", "HOME": "/home/me"}
    expected = {**BY_LOOPBACK, **environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    if name == "ROS_STATIC_PEERS":
        del expected["FASTRTPS_DEFAULT_PROFILES_FILE"]
    assert middleware(environ, LOOPBACK) == expected


def test_all_topics_of_a_discovery_server_are_visible() -> None:
    server = {"ROS_DISCOVERY_SERVER": "192.0.2.1:11811"}
    given = middleware(server, LOOPBACK)
    assert given["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert given["ROS_SUPER_CLIENT"] == "TRUE"
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in given
    server["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
    assert middleware(server, LOOPBACK)["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "OFF"
    assert middleware({**server, "ROS_SUPER_CLIENT": "0"}, LOOPBACK)["ROS_SUPER_CLIENT"] == "0"


def test_middleware_of_another_ros2_is_ignored() -> None:
    given = middleware({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, LOOPBACK)
    assert given["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
