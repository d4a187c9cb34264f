"""Tests of registrations that a master has lost, and of services taken over by other nodes."""

from typing import Any, Dict, List

import pytest
import rospy

from nodekit.master import Reading
from nodekit.rospy_internals import registration_listener
from nodekit.rospy_internals.master_registrations import LOOKUPS, MasterRegistrations

OWN, OTHER = "rosrpc://own:1", "rosrpc://other:1"


class Master:
    """Fake master that returns each service's provider; records the requests."""

    def __init__(self) -> None:
        self.owners: Dict[str, str] = {}
        self.asked: List[str] = []

    def request(self, calls: List[Any]) -> List[Any]:
        if calls == [("getSystemState",)]:
            return [(1, "", [[], [], [[name, ["/other"]] for name in self.owners]])]
        self.asked = [name for _, name in calls]
        return [
            (1, "", self.owners[name]) if name in self.owners else (-1, "", 0)
            for name in self.asked
        ]


class Rig:
    """MasterRegistrations with a fake master, and a record of requests and log lines."""

    def __init__(self, patch: "pytest.MonkeyPatch") -> None:
        self.master = Master()
        self.lines: List[str] = []
        self.accepts = True
        self.renewals = 0
        self.services = {"/a": OWN}
        self.tested = MasterRegistrations(self.master)  # type: ignore[arg-type]

        def log(text: str, *arguments: Any) -> None:
            self.lines.append(text % arguments)

        patch.setattr(rospy, "logwarn", log)
        patch.setattr(rospy, "loginfo", log)
        patch.setattr(registration_listener, "services", lambda: self.services)
        patch.setattr(registration_listener, "reregister_all", self.reregister_all)
        patch.setattr(registration_listener, "register_services", self.register_services)

    def reregister_all(self, _request: Any) -> bool:
        self.renewals += 1
        return self.accepts

    def register_services(self, names: List[str], _request: Any) -> None:
        self.master.owners.update({name: self.services[name] for name in names})

    def read(self, knows_node: bool, pid: int = 1) -> None:
        """Act as the watcher does."""
        self.tested.detect_loss(Reading({}, knows_node, pid))
        if self.tested.are_lost:
            self.tested.reregister()
            self.tested.log_reregistered()

    def reclaim_services(self) -> List[str]:
        """Reclaim the services; return the log lines."""
        before = len(self.lines)
        self.tested.reclaim_services()
        return self.lines[before:]


@pytest.fixture
def rig(monkeypatch: "pytest.MonkeyPatch") -> Rig:
    return Rig(monkeypatch)


def test_master_that_knows_the_node_is_left_alone(rig: Rig) -> None:
    for _ in range(3):
        rig.read(True)
    assert (rig.renewals, rig.lines) == (0, [])


def test_restarted_master_is_reported_once(rig: Rig) -> None:
    for knows, pid in ((True, 1), (False, 2), (True, 2), (True, 3), (True, 3)):
        rig.read(knows, pid)
    line = "the master was restarted: registered again, settings in force are kept"
    assert (rig.renewals, rig.lines) == (2, [line, line])


def test_forgotten_node_logs_it_and_claims_no_restart(rig: Rig) -> None:
    for knows in (True, False, True):
        rig.read(knows)
    line = "the master had forgotten this node: registered again, settings in force are kept"
    assert (rig.renewals, rig.lines) == (1, [line])


def test_master_that_refuses_everything_is_asked_once_and_no_restart_is_claimed(rig: Rig) -> None:
    rig.accepts = False
    for _ in range(5):
        rig.read(False)
    assert (rig.renewals, rig.lines) == (1, [])
    rig.accepts = True
    for _ in range(2):
        rig.read(False, pid=2)
    assert len(rig.lines) == rig.renewals - 1 > 0


def test_service_taken_over_is_registered_again_when_it_is_free(rig: Rig) -> None:
    rig.master.owners = {"/a": OWN}
    assert rig.reclaim_services() == []
    rig.master.owners = {"/a": OTHER}
    text = "taken over by another node, which is now called instead: service /a (/other)"
    assert [rig.reclaim_services(), rig.reclaim_services()] == [[text], []]
    rig.master.owners = {}
    assert rig.reclaim_services() == ["no longer offered by any node, registered again: service /a"]
    assert rig.master.owners == {"/a": OWN}
    assert rig.reclaim_services() == []
    rig.master.owners = {"/a": OTHER}
    assert rig.reclaim_services() == [text]


@pytest.mark.parametrize("frees", [False, True])
def test_service_taken_over_a_second_time_is_reported_again(rig: Rig, frees: bool) -> None:
    told = []
    for _ in range(2):
        rig.master.owners = {"/a": OTHER}
        told += rig.reclaim_services()
        # The other one has ended, or this node has registered it again before the other one has.
        rig.master.owners = {} if frees else {"/a": OWN}
        rig.reclaim_services()
    assert len(told) == 2 and told[0] == told[1]


def test_many_services_take_turns(rig: Rig) -> None:
    names = [f"/s{number:03}" for number in range(2 * LOOKUPS + 1)]
    rig.services = rig.master.owners = dict.fromkeys(names, OWN)
    seen: List[str] = []
    for _ in range(3):
        rig.reclaim_services()
        assert len(rig.master.asked) <= LOOKUPS
        seen += rig.master.asked
    assert seen == names
