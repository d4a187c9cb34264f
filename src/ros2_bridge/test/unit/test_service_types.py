"""Whom the bridge asks for the types of services, and how often."""

import collections
import threading
from typing import Any, Counter, Dict, Iterator, List, cast

import pytest

from nodekit import CallError, MasterUnreachable
from nodekit.testing.waiting import wait_until
from ros2_bridge.types import service_types


class Servers:
    """Fake servers: some answer, some do not, one is defective."""

    def __init__(self) -> None:
        self.asked: "Counter[str]" = collections.Counter()
        self.places: Dict[str, str] = {}
        self.is_reachable = True
        self.answering = threading.Event()
        self.answering.set()

    def probe(self, name: str, _: float) -> Dict[str, str]:
        self.asked[name] += 1
        assert self.answering.wait(20.0)
        if name == "/defect":
            raise ValueError(self)
        if name == "/typeless":
            return {}
        if not name.startswith("/good"):
            raise CallError(name)
        return {"type": "std_srvs/Trigger"}

    def request(self, calls: List[Any]) -> List[Any]:
        """Return the servers' addresses, as the master does."""
        if not self.is_reachable:
            raise MasterUnreachable("no master")
        return [(1, "", self.places.get(name, "first")) for _, name in calls]


@pytest.fixture
def servers(monkeypatch: "pytest.MonkeyPatch") -> Iterator[Servers]:
    made = Servers()
    monkeypatch.setattr(service_types, "probe_service", made.probe)
    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    yield made


def poll(types: service_types.ServiceTypes, names: Any) -> None:
    """Poll once, and wait for the queried servers."""
    types.begin_poll(set(names))
    for name in names:
        types.of(name)
    wait_until(lambda: not types._asked, lambda: str(types._asked))


def test_the_silent_are_asked_again_in_turn(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    silent = [f"/silent{number}" for number in range(8)]
    poll(types, silent)
    assert set(servers.asked.values()) == {1} and len(servers.asked) == 8
    for _ in range(4):
        poll(types, silent)
    assert set(servers.asked.values()) == {2}  # two in each poll, and each of them once
    poll(types, [*silent, "/good"])
    assert types.of("/good") == "std_srvs/Trigger"  # no request waits for those
    assert sum(servers.asked.values()) == 8 + 8 + 2 + 1


def test_few_servers_are_asked_at_a_time_and_once_in_a_poll(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    names = [f"/silent{number}" for number in range(service_types._MOST + 2)]
    servers.answering.clear()
    types.begin_poll(set(names))
    for name in names:
        types.of(name)
    assert len(types._asked) == service_types._MOST
    servers.answering.set()
    wait_until(lambda: not types._asked, lambda: str(types._asked))
    types.begin_poll({names[0]})
    for _ in range(3):
        types.of(names[0])
        wait_until(lambda: not types._asked, lambda: str(types._asked))
    assert servers.asked[names[0]] == 2


def test_silent_server_is_reported_from_its_second_query_until_it_answers(
    servers: Servers,
) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    poll(types, ["/silent"])
    assert not types.unanswered()
    poll(types, ["/silent", "/good"])
    assert types.unanswered() == {"/silent": "/silent"}
    for _ in range(2):
        poll(types, ["/typeless"])
    assert types.unanswered() == {"/typeless": "its header has no type"}
    poll(types, ["/good"])
    assert not types.unanswered()


def test_silent_servers_that_are_not_requested_take_no_turn(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    unwanted, last = ["/gone", "/denied"], "/silent"
    poll(types, [*unwanted, last])
    for _ in range(2):
        types.begin_poll({*unwanted, last})
        types.of(last)
        wait_until(lambda: not types._asked, lambda: str(types._asked))
    assert servers.asked[last] == 2 and servers.asked["/gone"] == 1


def test_master_that_does_not_answer_changes_no_reason(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    for _ in range(2):
        poll(types, ["/silent"])
    reasons = types.unanswered()
    servers.is_reachable = False
    for name in ("/silent", "/unknown", "/unknown"):
        types._ask(name)
    assert types.unanswered() == reasons == {"/silent": "/silent"}


def test_missing_service_is_dropped(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    poll(types, ["/good", "/silent"])
    poll(types, [])
    poll(types, ["/good", "/silent"])
    assert servers.asked == {"/good": 2, "/silent": 2}


def test_a_defect_takes_nobody_s_turn(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    for _ in range(service_types._MOST + 1):
        poll(types, ["/defect"])
    assert servers.asked["/defect"] == service_types._MOST + 1


def test_moved_service_is_queried_again(servers: Servers) -> None:
    types = service_types.ServiceTypes(cast(Any, servers))
    several = [f"/good{number}" for number in range(3 * service_types._LOOKUPS)]
    for _ in range(len(several) // service_types._MOST + 1):
        poll(types, several)
    assert set(servers.asked.values()) == {1} and len(servers.asked) == len(several)
    servers.places = {several[0]: "second", several[-1]: "second"}
    for _ in range(2 * 3):
        poll(types, several)
    assert {name for name, count in servers.asked.items() if count > 1} == {*servers.places}
    assert servers.asked[several[0]] == servers.asked[several[-1]] == 2
