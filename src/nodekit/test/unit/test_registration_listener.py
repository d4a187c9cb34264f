"""Tests of the registration with a fake master."""

from unittest import mock
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rospy
import rospy.core
from rospy.impl.registration import Registration, RegManager, get_registration_listeners
from std_msgs.msg import String

from nodekit.messaging.publisher import Publisher
from nodekit.process_context import ProcessContext
from nodekit.rospy_internals import registration_listener
from nodekit.testing.waiting import in_thread, wait_until

PUB, SUB, SRV = Registration.PUB, Registration.SUB, Registration.SRV
URI = "http://here:1/"
OK = (1, "", [])
NO_PROVIDER = (-1, "no provider", "")


class Asked:
    """Fake master that records each request, and calls a test's function meanwhile."""

    def __init__(self, meanwhile=lambda calls: None):
        self.requests = []
        self.meanwhile = meanwhile

    def __call__(self, calls):
        self.requests.append(calls)
        self.meanwhile(calls)
        return [NO_PROVIDER if call[0] == "lookupService" else OK for call in calls]

    @property
    def calls(self):
        return [call for calls in self.requests for call in calls]


class Ending:
    """Whether the node has to end."""

    def __init__(self):
        self.requested = False

    def request(self, _calls=None):
        self.requested = True


@pytest.fixture
def ending(monkeypatch):
    state = Ending()
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: state.requested)
    monkeypatch.setattr(rospy, "get_node_uri", lambda: URI)
    monkeypatch.setattr(registration_listener, "_PAUSE_S", 0.001)
    return state


@pytest.fixture
def warnings(monkeypatch):
    texts = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: texts.append(text % values))
    return texts


def topics(count):
    return [(PUB, f"/{number}", "std_msgs/String") for number in range(count)]


def test_registrations_are_batched_by_five_hundreds(ending):
    ask = Asked()
    tested = registration_listener._BatchListener(None, ask)
    tested.add(topics(1201))
    tested.remove(topics(1201))
    assert [len(calls) for calls in ask.requests] == [500, 500, 201] * 2
    for method, calls in (
        ("registerPublisher", ask.calls[:1201]),
        ("unregisterPublisher", ask.calls[1201:]),
    ):
        assert [call[:2] for call in calls] == [(method, f"/{n}") for n in range(1201)]


def test_publishers_are_registered_before_subscribers(ending):
    ask = Asked()
    entries = [(SRV, "/s", "rosrpc://here:2"), (SUB, "/t", "*"), (PUB, "/t", "*")]
    registration_listener._BatchListener(None, ask).add(entries)
    lookups, *requests = ask.requests
    assert lookups == [("lookupService", "/s")]
    assert requests == [
        [
            ("registerPublisher", "/t", "*", URI),
            ("registerSubscriber", "/t", "*", URI),
            ("registerService", "/s", "rosrpc://here:2", URI),
        ]
    ]


def test_node_ended_during_its_start_leaves_nothing_registered(ending):
    ask = Asked(lambda calls: len(ask.requests) == 2 and ending.request())
    registration_listener._BatchListener(None, ask).add(
        topics(1201) + [(SRV, "/s", "rosrpc://here:2")]
    )
    registered = [call[1] for call in ask.calls if call[0].startswith("register")]
    taken_back = [call[1] for call in ask.calls if call[0].startswith("unregister")]
    assert len(registered) == 1000, "nothing more is registered once the node ends"
    # rospy itself unregisters earlier entries; unregistering too much is harmless.
    assert taken_back[:500] == registered[500:]


def test_master_that_does_not_answer_is_asked_again_until_it_does(ending, warnings):
    def fail_three_times(_calls):
        if len(ask.requests) <= 3:
            raise ConnectionError("no answer")

    ask = Asked(fail_three_times)
    registration_listener._BatchListener(None, ask).add(topics(1))
    assert len(ask.requests) == 4
    assert warnings == ["cannot register yet: no answer"]


def test_master_that_does_not_answer_holds_no_node_up_that_ends(ending, warnings):
    def fail(_calls):
        if len(ask.requests) == 3:
            ending.request()
        raise ConnectionError("no answer")

    ask = Asked(fail)
    registration_listener._BatchListener(None, ask).add(topics(1))
    assert [calls[0][0] for calls in ask.requests] == ["registerPublisher"] * 3 + [
        "unregisterPublisher"
    ]


@pytest.fixture
def asked(ending, monkeypatch):
    """Register all topics and services by requests that are recorded."""
    ask = Asked()
    monkeypatch.setattr(registration_listener, "PROCESS", ProcessContext())
    tested = registration_listener.PROCESS.get(
        registration_listener._BatchListener,
        lambda: registration_listener._BatchListener(None, ask),
    )
    monkeypatch.setattr(get_registration_listeners(), "listeners", [tested])
    return ask


def test_topic_created_again_while_it_is_unregistered_stays_registered(asked):
    old, new = (Publisher("/topic", String) for _ in range(2))
    old.open()
    with registration_listener.together():
        old.close()
        in_thread(new.open).join()
    told = [call[0] for call in asked.calls]
    new.close()
    assert told[-1] == "registerPublisher", told


def test_topic_closed_while_it_is_registered_is_unregistered(asked):
    publisher = Publisher("/topic", String)
    with registration_listener.together():
        publisher.open()
        in_thread(publisher.close).join()
    told = [call[0] for call in asked.calls]
    assert told[-1] == "unregisterPublisher", told


def test_service_closed_while_it_is_registered_again_is_unregistered(asked, monkeypatch):
    offered = {"/closed": mock.Mock(), "/open": mock.Mock()}
    entries = [(SRV, name, "rosrpc://here:2") for name in offered]
    registration_listener.PROCESS.find(registration_listener._BatchListener).add(entries)
    manager = mock.Mock(get_service=offered.get)
    monkeypatch.setattr(registration_listener, "get_service_manager", lambda: manager)
    asked.meanwhile = lambda calls: offered.pop("/closed", None)
    asked.requests.clear()
    registration_listener.register_services(list(offered), asked)
    told = [call[:3] for call in asked.calls if call[0] != "lookupService"]
    assert told[:2] == [("registerService", *entry[1:]) for entry in entries]
    assert told[2:] == [("unregisterService", "/closed", "rosrpc://here:2")]
    assert list(registration_listener.services()) == ["/open"]


class Handler:
    """Stands in for rospy's object that connects to publishers."""

    def __init__(self):
        self.done = False
        self.connected = set()

    def _connect_topic(self, _topic, uri):
        self.connected.add(uri)
        return 1, "", 0


def test_publishers_just_announced_to_rospy_are_kept(ending):
    handler = Handler()
    listener = RegManager(handler)
    listener.publisher_update("/topic", ["http://there:1/", "http://there:2/"])
    registration_listener._BatchListener(listener, Asked()).connect("/topic", ["http://there:3/"])
    running = in_thread(listener.run)
    wait_until(lambda: len(handler.connected) == 3, lambda: str(handler.connected))
    handler.done = True
    running.join()


def test_without_rospys_listener_its_own_server_learns_of_publishers(ending, monkeypatch):
    told = []
    with SimpleXMLRPCServer(("localhost", 0), logRequests=False) as server:
        server.register_multicall_functions()
        server.register_function(lambda *call: told.append(call) or OK, "publisherUpdate")
        uri = f"http://localhost:{server.server_address[1]}/"
        monkeypatch.setattr(rospy, "get_node_uri", lambda: uri)
        monkeypatch.delattr(get_registration_listeners(), "listeners")
        monkeypatch.setattr(
            registration_listener, "all_entries", lambda: [(SUB, "/topic", "std_msgs/String")]
        )
        serving = in_thread(server.handle_request)
        assert registration_listener.reregister_all(lambda calls: [(1, "", ["http://there:1/"])])
        serving.join()
    assert told == [(rospy.get_name(), "/topic", ["http://there:1/"])]
