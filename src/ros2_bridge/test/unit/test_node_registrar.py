"""Registrations of ROS 2 nodes with the ROS 1 master."""

import os
from typing import Any, Dict, Iterator, List, Set, Tuple

import pytest

from nodekit.master import CONNECTED_ELSEWHERE
from nodekit.testing.waiting import wait_until
from ros2_bridge.ros1 import node_registrar
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros1.node_registrar import NodeRegistrar, Registration, _refuses

EVENTS = "/parameter_events"
ODOM = Registration("Publisher", "/odom", "nav_msgs/Odometry")
RESET = Registration("Service", "/reset")


class FakeMaster:
    """Fake master.

    :ivar calls: node, request and name of each call that changes it
    :ivar addresses: address of each node
    """

    def __init__(self) -> None:
        self.calls: List[Tuple[str, ...]] = []
        self.addresses: Dict[str, str] = {}

    def client(self, name: str, uri: str, _: float) -> "FakeClient":
        return FakeClient(self, name, uri)


class FakeClient:
    def __init__(self, master: FakeMaster, name: str, uri: str) -> None:
        self.master, self.name, self.uri = master, name, uri

    def __enter__(self) -> "FakeClient":
        return self

    def __exit__(self, *_: Any) -> None:
        pass

    def lookup_node(self, name: str) -> str:
        return self.master.addresses.get(name, "")

    def lookup_service(self, _: str) -> str:
        return "rosrpc://bridge"

    def request(self, calls: List[Any]) -> None:
        for call in calls:
            rest = [self.name if one == self.uri else one for one in call]
            self.master.calls.append((self.name, *rest))
        self.master.addresses[self.name] = self.uri


@pytest.fixture
def master(monkeypatch: "pytest.MonkeyPatch") -> FakeMaster:
    made = FakeMaster()
    monkeypatch.setattr(node_registrar, "MasterClient", made.client)
    return made


@pytest.fixture
def registrar(master: FakeMaster) -> Iterator[NodeRegistrar]:
    made = NodeRegistrar("/bridge")
    yield made
    made.close()


def graph(*nodes: str) -> Ros1Graph:
    """Return a graph that lists nodes of a bridge."""
    return Ros1Graph({}, {EVENTS: set(nodes)} if nodes else {}, {}, {}, 1)


def test_changes_of_a_node_are_registered_once(
    master: FakeMaster, registrar: NodeRegistrar
) -> None:
    def calls(*entries: Registration) -> Set[Tuple[str, ...]]:
        master.calls.clear()
        registrar.register({"/robot": set(entries)}, set(), False)
        return set(master.calls)

    assert calls(ODOM, RESET) == {
        ("/robot", "registerSubscriber", EVENTS, "rcl_interfaces/ParameterEvent", "/robot"),
        ("/robot", "registerPublisher", "/odom", "nav_msgs/Odometry", "/robot"),
        ("/robot", "registerService", "/reset", "rosrpc://bridge", "/robot"),
    }
    assert calls(ODOM, RESET) == set()
    assert calls() == {
        ("/robot", "unregisterPublisher", "/odom", "/robot"),
        ("/robot", "unregisterService", "/reset", "rosrpc://bridge"),
    }
    assert calls() == set()
    master.addresses.clear()
    registrar.register({"/robot": set()}, set(), True)  # the master was restarted
    assert [call[1] for call in master.calls] == ["registerSubscriber"]
    master.calls.clear()
    registrar.register({}, set(), False)
    assert [call[1:3] for call in master.calls] == [("unregisterSubscriber", EVENTS)]
    assert not registrar.names
    registrar.close()
    assert calls(ODOM) == set()


def test_name_of_a_ros1_node_is_left_to_it(master: FakeMaster, registrar: NodeRegistrar) -> None:
    master.addresses["/listener"] = "http://localhost:1/"
    registrar.register({"/talker": set(), "/listener": set()}, {"/talker"}, False)
    assert not master.calls and not registrar.names


def test_name_that_a_ros1_node_has_taken_is_dropped(
    master: FakeMaster, registrar: NodeRegistrar
) -> None:
    nodes: Dict[str, Set[Registration]] = {"/robot": set(), "/lidar": set()}
    registrar.register(nodes, set(), False)
    registrar._address.shutdown("/master")  # as of rosnode kill, too
    registrar.register(nodes, set(), False)
    assert registrar.names == {"/robot", "/lidar"}
    master.addresses["/robot"] = "http://localhost:1/"
    registrar.register(nodes, set(), False)  # the master has told nothing
    assert registrar.names == {"/robot", "/lidar"}
    registrar._address.shutdown("/master")
    registrar.register(nodes, set(), False)
    assert registrar.names == {"/lidar"}


def test_nodes_of_a_killed_bridge_are_removed_and_those_of_another_kept(
    master: FakeMaster, registrar: NodeRegistrar, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    refusing: Set[str] = {"http://dead/"}
    monkeypatch.setattr(node_registrar, "_refuses", refusing.__contains__)
    master.addresses = {"/dead": "http://dead/", "/other": "http://other/"}
    assert registrar.remove_stale(graph("/dead", "/other"))
    assert [call[:3] for call in master.calls] == [
        ("/dead", "registerSubscriber", EVENTS),
        ("/dead", "unregisterSubscriber", EVENTS),
    ]
    assert not registrar.remove_stale(graph("/other"))
    assert not registrar.remove_stale(graph())
    refusing.add("http://other/")  # it came back, and was killed
    assert registrar.remove_stale(graph("/other"))


def test_requests_of_ros1_to_the_nodes_are_answered(registrar: NodeRegistrar) -> None:
    nodes, caller = registrar._address, "/caller"
    assert nodes.getPid(caller) == [1, "", os.getpid()]
    assert nodes.getBusInfo(caller) == [1, CONNECTED_ELSEWHERE, []]
    assert nodes.getSubscriptions(caller) == [1, "", []]
    assert nodes.publisherUpdate(caller, "/odom", ["http://localhost:1/"]) == [1, "", 0]
    # The bridge sends the topic.
    assert nodes.requestTopic(caller, "/odom", [["TCPROS"]])[0] == 0
    assert nodes.shutdown(caller, "taken") == [1, "", 0] and nodes.is_taken.is_set()


def test_address_is_closed_with_the_registrar(registrar: NodeRegistrar) -> None:
    address = registrar._address.uri
    assert not _refuses(address)
    registrar.close()
    # The server's thread may be taking a connection just then.
    wait_until(lambda: _refuses(address), lambda: f"{address} still answers")
    assert not _refuses("http://localhost:nowhere/")  # which says nothing about a process
