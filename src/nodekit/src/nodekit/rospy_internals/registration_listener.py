"""Listener of rospy's registrations: registers topics and services in batches, with time-outs.

rospy registers one by one and without a time-out. The listener here replaces rospy's; its requests
have a time-out, and may hold several registrations.
"""

import contextlib
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import rospy
import rospy.core
from rospy.impl.registration import (
    Registration,
    RegistrationListener,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

from nodekit.master import MasterClient
from nodekit.process_context import PROCESS
from nodekit.rospy_internals.connection_watch import ConnectionWatch
from nodekit.rospy_internals.registry import Entry, all_entries

#: Sends calls (method, argument, ...) to the master and returns its replies (code, message,
#: value); raises ConnectionError if the master does not reply in time.
Request = Callable[[List[Tuple[Any, ...]]], List[Any]]
#: Most registrations in one request; the master serves other clients between two requests.
_TOGETHER = 500
#: Pause before another request to a master that does not reply [s].
_PAUSE_S = 0.2
#: Timeout of a request to this process's own server [s].
_OWN_SERVER_S = 5.0
#: Most services named in one log line.
_NAMED = 5

#: Methods of the master's interface that add and remove each type. Publishers are first, so that
#: subscribers learn of them from the reply to their own registration, without a call by the master.
_ADD = {
    Registration.PUB: "registerPublisher",
    Registration.SUB: "registerSubscriber",
    Registration.SRV: "registerService",
}
_REMOVE = {
    Registration.PUB: "unregisterPublisher",
    Registration.SUB: "unregisterSubscriber",
    Registration.SRV: "unregisterService",
}
_KINDS = list(_ADD)


class _Batch:
    """Registrations to add and to remove together."""

    def __init__(self) -> None:
        self.added: List[Entry] = []
        self.removed: List[Entry] = []


class _BatchListener(RegistrationListener):
    """Replacement of rospy's registration listener.

    :param listener: rospy's listener, which connects subscribers to publishers
    :param request: sends calls to the master

    :ivar services: URIs of registered services, by name; without the node's private services,
        because no other node can take their names
    """

    def __init__(self, listener: Any, request: Request) -> None:
        self.request = request
        self.services: Dict[str, str] = {}
        self.local = threading.local()
        self.watch = ConnectionWatch(request)
        self._private = rospy.get_name() + "/"
        self._listener = listener
        connect_one = getattr(listener, "_connect_topic_thread", None)
        if connect_one is not None:
            listener._connect_topic_thread = partial(self._connect_one, connect_one)

    def _connect_one(self, connect_one: Callable[[str, str], None], name: str, uri: str) -> None:
        self.watch.begin(name, uri)
        connect_one(name, uri)

    def reg_added(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        """Register a new topic or service, or add it to the batch of this thread."""
        entry = (reg_type, resolved_name, data_type_or_uri)
        batch: Optional[_Batch] = getattr(self.local, "batch", None)
        if batch is not None:
            batch.added.append(entry)
        else:
            self.add([entry])

    def reg_removed(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        """Unregister a closed topic or service, or add it to the batch of this thread."""
        entry = (reg_type, resolved_name, data_type_or_uri)
        batch: Optional[_Batch] = getattr(self.local, "batch", None)
        if batch is None:
            self.remove([entry])
        elif entry in batch.added:
            batch.added.remove(entry)
        else:
            batch.removed.append(entry)

    def add(self, entries: List[Entry], request: Optional[Request] = None) -> bool:
        """Register entries, connect to their publishers, and warn about services of other nodes.

        :param entries: new topics and services
        :param request: sends calls to the master; by default, retries until it replies
        :returns: whether the master has accepted any entry
        :raises ConnectionError: if the request fails
        """
        taken = False
        request = request or self._ask_until_answered
        entries = sorted(entries, key=lambda entry: _KINDS.index(entry[0]))
        uri = rospy.get_node_uri()
        for start in range(0, len(entries), _TOGETHER):
            part = entries[start : start + _TOGETHER]
            _warn_of_others({name: uri for k, name, uri in part if k == Registration.SRV}, request)
            calls: List[Tuple[Any, ...]] = [
                (_ADD[reg_type], name, type_or_uri, uri) for reg_type, name, type_or_uri in part
            ]
            for (reg_type, name, type_or_uri), answer in zip(part, request(calls)):
                if answer[0] != 1:
                    rospy.logerr("the master rejected the registration of %s: %s", name, answer[1])
                    continue
                taken = True
                if reg_type == Registration.SUB:
                    self.connect(name, answer[2])
                elif reg_type == Registration.SRV and not name.startswith(self._private):
                    self.services[name] = type_or_uri
            if rospy.core.is_shutdown_requested():  # rospy may have unregistered everything already
                self.remove(part)
        return taken

    def apply_later_changes(self, batch: _Batch) -> None:
        """Register what other threads have opened or closed since it was added to the batch."""
        made = {entry[:2]: entry for entry in all_entries()}
        self.add([made[entry[:2]] for entry in batch.removed if entry[:2] in made])
        self.remove([entry for entry in batch.added if entry[:2] not in made])

    def _ask_until_answered(self, calls: List[Tuple[Any, ...]]) -> List[Any]:
        # rospy unregisters everything at shutdown; later registrations would remain.
        warned = False
        while not rospy.core.is_shutdown_requested():
            try:
                return self.request(calls)
            except ConnectionError as error:
                if not warned:
                    rospy.logwarn("cannot register yet: %s", error)
                    warned = True
                time.sleep(_PAUSE_S)
        return []

    def remove(self, entries: List[Entry]) -> None:
        """Unregister entries; do not retry if the master does not reply.

        :param entries: closed topics and services
        """
        for reg_type, name, _ in entries:
            if reg_type == Registration.SRV:
                self.services.pop(name, None)
        uri = rospy.get_node_uri()
        calls: List[Tuple[Any, ...]] = [
            (_REMOVE[reg_type], name, type_or_uri if reg_type == Registration.SRV else uri)
            for reg_type, name, type_or_uri in entries
        ]
        try:
            for start in range(0, len(calls), _TOGETHER):
                self.request(calls[start : start + _TOGETHER])
        except ConnectionError as error:
            rospy.logwarn("cannot unregister closed topics and services yet: %s", error)

    def connect(self, name: str, publishers: List[str]) -> None:
        """Connect to publishers of a topic, given by URI, unless they need no connection."""
        topic = get_topic_manager().get_subscriber_impl(name)
        missing = [uri for uri in publishers if topic is None or not topic.has_connection(uri)]
        connect_one = getattr(self._listener, "_connect_topic_thread", None)
        if connect_one is not None:
            # As rospy's own thread does; publisher_update() would take this list for all publishers
            # of the topic, and drop others that the master has just announced.
            for uri in missing:
                threading.Thread(target=connect_one, args=(name, uri), daemon=True).start()
        elif missing:
            self._listener.publisher_update(name, missing)


class _PublisherUpdateListener:
    """Listener that sends this node publisherUpdate as the master does, for an unknown version."""

    @staticmethod
    def publisher_update(name: str, publishers: List[str]) -> None:
        with MasterClient(
            rospy.get_name(), timeout=_OWN_SERVER_S, master_uri=rospy.get_node_uri()
        ) as server:
            server.request([("publisherUpdate", name, publishers)])


def _listeners() -> List[Any]:
    """Return rospy's registration listeners; exactly one in known versions."""
    return list(getattr(get_registration_listeners(), "listeners", ()))


def install(request: Request) -> None:
    """Register through these requests from now on; requires an initialised node.

    :param request: sends calls to the master, with a time-out
    """
    listeners = get_registration_listeners()
    with listeners.lock:
        found = _listeners()
        if PROCESS.find(_BatchListener) is None and len(found) == 1:
            listener = PROCESS.get(_BatchListener, lambda: _BatchListener(found[0], request))
            listeners.listeners = [listener]
    if PROCESS.find(_BatchListener) is None:
        rospy.logwarn("unsupported rospy version: topics and services are registered one by one")


def connect(name: str, publisher: str) -> None:
    """Connect a subscribed topic to a publisher, given by its URI, unless it is connected."""
    listener = PROCESS.find(_BatchListener)
    if listener is not None:
        listener.connect(name, [publisher])


def connection_failed(name: str, publisher: str, error: object) -> None:
    """Keep the reason why a subscribed topic has no connection to a publisher, for a warning.

    :param name: topic, resolved
    :param publisher: URI of the publisher
    :param error: the reason
    """
    listener = PROCESS.find(_BatchListener)
    if listener is not None:
        listener.watch.fail(name, publisher, error)


@contextlib.contextmanager
def together() -> Iterator[None]:
    """Collect the registrations of this thread, and send them together at the end.

    Single requests would take most of the start of a node with thousands of topics and services.
    """
    listener = PROCESS.find(_BatchListener)
    if listener is None or getattr(listener.local, "batch", None) is not None:
        yield
        return
    batch = listener.local.batch = _Batch()
    try:
        yield
    finally:
        listener.local.batch = None
        if batch.removed:
            listener.remove(batch.removed)
        if batch.added:
            listener.add(batch.added)
        if batch.removed or batch.added:
            listener.apply_later_changes(batch)


def reregister_all(request: Request) -> bool:
    """Register every topic and service of this node again.

    rospy registers each of them once, so that after a restart of the master no new
    subscriber or client would find it. Existing connections are not touched.

    :param request: sends calls to the master
    :returns: whether the master has accepted any of them
    :raises ConnectionError: if the request fails
    """
    listener = PROCESS.find(_BatchListener) or _BatchListener(
        (_listeners() or [_PublisherUpdateListener])[0], request
    )
    return listener.add(all_entries(), request)


def services() -> Dict[str, str]:
    """Return the URIs of the registered services of this process, by name.

    In the order of registration, without the node's private services.
    """
    listener = PROCESS.find(_BatchListener)
    return dict(listener.services) if listener is not None else {}


def register_services(names: List[str], request: Request) -> None:
    """Register services of this process again, unless they have just been closed.

    :param names: names of services that were registered before
    :param request: sends calls to the master
    :raises ConnectionError: if the request fails
    """
    listener, registered = PROCESS.find(_BatchListener), services()
    entries = [(Registration.SRV, name, registered[name]) for name in names if name in registered]
    if listener is not None:
        listener.add(entries, request)
        manager = get_service_manager()
        listener.remove([entry for entry in entries if manager.get_service(entry[1]) is None])


# The master knows one node for each service: the latest that registered it.


def with_owners(names: Sequence[str], request: Request) -> str:
    """Return services with the nodes that offer them, as text.

    :param names: names of the services
    :param request: sends calls to the master
    :raises ConnectionError: if the request fails
    """
    state = request([("getSystemState",)])
    nodes = {name: ", ".join(found) for name, found in state[0][2][2]} if state else {}
    texts = [f"{name} ({nodes.get(name, 'unknown')})" for name in names[:_NAMED]]
    more = len(names) - _NAMED
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def _warn_of_others(services: Mapping[str, str], request: Request) -> None:
    """Warn about services that another node offers under the same name.

    :param services: URIs of this process, by name of the service to register
    :param request: sends calls to the master
    :raises ConnectionError: if the request fails
    """
    answers = request([("lookupService", name) for name in services]) if services else []
    owners: Dict[str, str] = {n: uri for n, (code, _, uri) in zip(services, answers) if code == 1}
    others = [name for name, uri in owners.items() if uri != services[name]]
    if others:
        text = "already offered; from now on this node is called instead: service %s"
        rospy.logwarn(text, with_owners(others, request))
