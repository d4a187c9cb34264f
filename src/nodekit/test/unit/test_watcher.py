"""Tests of the watcher of the parameter server, with a fake server."""

import itertools
import threading
import time

import pytest

from nodekit.master import Reading
from nodekit.parameter_server import watcher as watching
from nodekit.parameter_server.watched_key import WatchedKey
from nodekit.parameters.parameter_types import MISSING
from nodekit.rospy_internals import parameter_cache, registration_listener, shutdown
from nodekit.testing.waiting import wait_until

#: More than are read each second; they take three turns.
MANY = [f"/many/{number}" for number in range(2 * watching.RECONCILE_KEYS + 50)]


class Client:
    """Fake master that records the requests."""

    def __init__(self):
        self.values = {}
        self.reads = []
        self.subscribed = set()
        self.knows_node = True

    def read(self, keys):
        self.reads.append(list(keys))
        values = {key: self.values.get(key, MISSING) for key in keys}
        return Reading(values, self.knows_node, 1)

    def subscribe(self, keys):
        self.subscribed.update(keys)

    def unsubscribe(self, keys):
        self.subscribed.difference_update(keys)

    def restart(self):
        self.subscribed.clear()
        self.knows_node = False

    def request(self, calls):
        raise AssertionError(calls)


class Told:
    """A key that records its values."""

    def __init__(self, key):
        self.values = []
        self.watched = WatchedKey(key, self.is_news, self.on_reading)

    def is_news(self, raw):
        return raw is not MISSING and raw not in self.values

    def on_reading(self, seen):
        self.values.append(seen.raw)
        return True


@pytest.fixture
def client():
    return Client()


@pytest.fixture
def notify():
    """Notify as the master does; to be called once there is a watcher."""
    functions = []

    def notify(key, value):
        return functions[-1](key, value)

    notify.functions = functions
    return notify


@pytest.fixture
def watcher(monkeypatch, client, notify):
    monkeypatch.setattr(
        parameter_cache, "on_push", lambda handle: notify.functions.append(handle) or 1
    )
    monkeypatch.setattr(parameter_cache, "cache", lambda key, value: None)
    monkeypatch.setattr(shutdown, "at_end", lambda ending, function: None)
    made = watching.Watcher(client)
    yield made
    made.shut_down()
    wait_until(
        lambda: "parameter_watcher" not in [thread.name for thread in threading.enumerate()],
        lambda: "the thread does not end",
    )


@pytest.mark.parametrize(
    "key, rings",
    [
        ("/a/b", ["/a", "/a/b"]),
        ("/a/b/", ["/a", "/a/b"]),
        ("/a/b/c", ["/a", "/a/b"]),
        ("/a/bc", ["/a", "/a/bc"]),
        ("/a/bc/d", ["/a", "/a/bc"]),
        ("/a", ["/a"]),
        ("/ab", []),
    ],
)
def test_notification_concerns_the_key_and_its_children_but_no_sibling(
    monkeypatch, watcher, notify, key, rings
):
    every = [Told(name).watched for name in ("/a", "/a/b", "/a/bc")]
    watcher.watch(every)
    monkeypatch.setattr(watcher, "wake", lambda: None)  # nothing is handed over meanwhile
    assert notify(key, 1) is bool(rings)
    assert [watched.key for watched in every if watched.is_due] == rings


def test_keys_that_are_many_take_turns(monkeypatch, client, watcher):
    monkeypatch.setattr(watching, "RECONCILE_S", 0.01)
    watcher.watch([Told(key).watched for key in MANY])
    watcher.wake()  # or it waits for a second with the old period
    client.reads.clear()
    wait_until(lambda: len([keys for keys in client.reads if keys]) > 6, lambda: "no reads")
    turns = [keys for keys in client.reads if keys][:6]
    sizes = [len(keys) for keys in turns]
    assert max(sizes) == watching.RECONCILE_KEYS
    start = sizes.index(min(sizes)) + 1  # the turn after the shortest starts again
    assert sum(turns[start : start + 3], []) == MANY


def test_change_of_any_key_is_noticed_without_a_notification(monkeypatch, client, watcher):
    monkeypatch.setattr(watching, "RECONCILE_S", 0.01)
    told = [Told(key) for key in MANY]
    watcher.watch([one.watched for one in told])
    watcher.wake()
    for one in (told[0], told[watching.RECONCILE_KEYS], told[-1]):
        client.values[one.watched.key] = 5
        wait_until(lambda: one.values == [5], lambda: f"{one.watched.key} is not noticed")


def test_unhandled_reading_is_delivered_again(monkeypatch, client, watcher):
    monkeypatch.setattr(watching, "RECONCILE_S", 0.01)

    class Busy(Told):
        def on_reading(self, seen):
            return super().on_reading(seen) and len(self.values) > 1

    told = Busy("/n")
    client.values["/n"] = 5
    watcher.watch([told.watched])
    watcher.wake()
    wait_until(lambda: told.values == [5, 5], lambda: f"told: {told.values}", 10.0)


def test_constantly_changing_value_is_delivered(monkeypatch, client, watcher):
    monkeypatch.setattr(watching, "RECONCILE_S", 0.01)
    told, numbers, read = Told("/busy"), itertools.count(), client.read

    def read_another(keys):
        client.values["/busy"] = next(numbers)
        return read(keys)

    watcher.watch([told.watched])
    monkeypatch.setattr(client, "read", read_another)
    watcher.wake()
    wait_until(lambda: len(told.values) >= 2, lambda: f"told: {told.values}", 10.0)


def test_notifications_resume_after_a_restart_of_the_master(monkeypatch, client, watcher, notify):
    """The read once a second would hide missing notifications."""
    again = []
    monkeypatch.setattr(registration_listener, "reregister_all", again.append)
    told = Told("/n")
    watcher.watch([told.watched])
    before = set(client.subscribed)
    client.restart()
    watcher.wake()
    wait_until(lambda: client.subscribed == before, lambda: str(client.subscribed))
    assert again == [client.request]
    client.knows_node = True
    client.values["/n"] = 5
    assert notify("/n", 5)
    wait_until(lambda: 5 in told.values, lambda: str(told.values))


def test_idle_watcher_uses_no_cpu_time(client, watcher):
    watcher.watch([Told("/n").watched])
    watcher.wake()
    wait_until(lambda: ["/n"] in client.reads or [] in client.reads, lambda: str(client.reads))
    before = len(client.reads)
    time.sleep(0.3)
    assert len(client.reads) - before <= 3
