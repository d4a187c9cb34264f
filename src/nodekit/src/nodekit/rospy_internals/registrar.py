"""How rospy tells the master of topics and services: one by one and without a time-out.

Its listener for them is replaced by one of ours, which does as much with requests that have a
time-out, several registrations at once where it is told to.
"""

import contextlib
import threading
import time
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
from nodekit.rospy_internals.registry import Entry, all_entries

#: Sends calls (method, argument, ...) to the master and returns its answers (code, message,
#: value); raises ConnectionError where it does not answer in time.
Request = Callable[[List[Tuple[Any, ...]]], List[Any]]
#: Most registrations in one request; the master's other clients are served between two.
_TOGETHER = 500
#: Pause before a master that does not answer is asked again, s.
_PAUSE_S = 0.2
#: Longest wait for this process's own server, s.
_OWN_SERVER_S = 5.0
#: Most services that a line of the log names.
_NAMED = 5

#: Methods of the master's interface that add and remove each kind. In this order: where what is
#: published is known first, those who listen learn of it from the answer to their own
#: registration, and the master need not call each of them.
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
    """What is to be added and removed together."""

    def __init__(self) -> None:
        self.added: List[Entry] = []
        self.removed: List[Entry] = []


class _Registrar(RegistrationListener):
    """Stands in for rospy's listener.

    :param listener: rospy's own, which connects subscribers to publishers
    :param request: asks the master

    :ivar services: those that the master has taken, each with its URI; without the node's private
        ones, as no other node has its name
    """

    def __init__(self, listener: Any, request: Request) -> None:
        self.request = request
        self.services: Dict[str, str] = {}
        self.local = threading.local()
        self._private = rospy.get_name() + "/"
        self._listener = listener

    def reg_added(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        """Note, or register at once, what rospy has made."""
        entry = (reg_type, resolved_name, data_type_or_uri)
        batch: Optional[_Batch] = getattr(self.local, "batch", None)
        if batch is not None:
            batch.added.append(entry)
        else:
            self.add([entry])

    def reg_removed(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        """Note, or take back at once, what rospy has closed."""
        entry = (reg_type, resolved_name, data_type_or_uri)
        batch: Optional[_Batch] = getattr(self.local, "batch", None)
        if batch is None:
            self.remove([entry])
        elif entry in batch.added:
            batch.added.remove(entry)
        else:
            batch.removed.append(entry)

    def add(self, entries: List[Entry], request: Optional[Request] = None) -> bool:
        """Register, connect to the publishers that there are, and tell whose services there were.

        :param entries: what is new
        :param request: asks the master; by default, as often as it takes to have an answer
        :returns: whether the master has taken any of it
        :raises ConnectionError: if the request does
        """
        taken = False
        request = request or self._ask_until_answered
        entries = sorted(entries, key=lambda entry: _KINDS.index(entry[0]))
        uri = rospy.get_node_uri()
        for start in range(0, len(entries), _TOGETHER):
            part = entries[start : start + _TOGETHER]
            _warn_of_others({name: uri for k, name, uri in part if k == Registration.SRV}, request)
            calls: List[Tuple[Any, ...]] = [
                (_ADD[kind], name, type_or_uri, uri) for kind, name, type_or_uri in part
            ]
            for (kind, name, type_or_uri), answer in zip(part, request(calls)):
                if answer[0] != 1:
                    rospy.logerr("the master refused to register %s: %s", name, answer[1])
                    continue
                taken = True
                if kind == Registration.SUB:
                    self.connect(name, answer[2])
                elif kind == Registration.SRV and not name.startswith(self._private):
                    self.services[name] = type_or_uri
            if rospy.core.is_shutdown_requested():  # rospy's own farewell may have come before
                self.remove(part)
        return taken

    def apply_later_changes(self, batch: _Batch) -> None:
        """Tell the master what another thread has made or closed since the batch has noted it."""
        made = {entry[:2]: entry for entry in all_entries()}
        self.add([made[entry[:2]] for entry in batch.removed if entry[:2] in made])
        self.remove([entry for entry in batch.added if entry[:2] not in made])

    def _ask_until_answered(self, calls: List[Tuple[Any, ...]]) -> List[Any]:
        # When the node ends, rospy takes back what there was, and nothing must follow.
        told = False
        while not rospy.core.is_shutdown_requested():
            try:
                return self.request(calls)
            except ConnectionError as error:
                if not told:
                    rospy.logwarn("cannot register yet: %s", error)
                    told = True
                time.sleep(_PAUSE_S)
        return []

    def remove(self, entries: List[Entry]) -> None:
        """Take registrations back; a master that does not answer is left as it is.

        :param entries: what is no more
        """
        for kind, name, _ in entries:
            if kind == Registration.SRV:
                self.services.pop(name, None)
        uri = rospy.get_node_uri()
        calls: List[Tuple[Any, ...]] = [
            (_REMOVE[kind], name, type_or_uri if kind == Registration.SRV else uri)
            for kind, name, type_or_uri in entries
        ]
        try:
            for start in range(0, len(calls), _TOGETHER):
                self.request(calls[start : start + _TOGETHER])
        except ConnectionError as error:
            rospy.logwarn("cannot unregister yet what was closed: %s", error)

    def connect(self, name: str, publishers: List[str]) -> None:
        """Connect to publishers of a topic, given by URI, but to those that need no connection."""
        topic = get_topic_manager().get_subscriber_impl(name)
        missing = [uri for uri in publishers if topic is None or not topic.has_connection(uri)]
        connect_one = getattr(self._listener, "_connect_topic_thread", None)
        if connect_one is not None:
            # As rospy's own thread does it, which takes the latest list of a topic for all there
            # are, and would forget others that the master has just told it of.
            for uri in missing:
                threading.Thread(target=connect_one, args=(name, uri), daemon=True).start()
        elif missing:
            self._listener.publisher_update(name, missing)


class _OwnServer:
    """Connects subscribers to publishers as the master does, where rospy's listener is unknown."""

    @staticmethod
    def publisher_update(name: str, publishers: List[str]) -> None:
        with MasterClient(
            rospy.get_name(), timeout=_OWN_SERVER_S, master_uri=rospy.get_node_uri()
        ) as server:
            server.request([("publisherUpdate", name, publishers)])


_registrar: Optional[_Registrar] = None


def _listeners() -> List[Any]:
    """Return rospy's listeners for what is made and closed: its own alone, if it is known here."""
    return list(getattr(get_registration_listeners(), "listeners", ()))


def install(request: Request) -> None:
    """Register through these requests from now on; the node must have been initialised.

    :param request: asks the master, with a time-out
    """
    global _registrar
    listeners = get_registration_listeners()
    with listeners.lock:
        found = _listeners()
        if _registrar is None and len(found) == 1:
            _registrar = _Registrar(found[0], request)
            listeners.listeners = [_registrar]
    if _registrar is None:
        rospy.logwarn("unsupported rospy version: what is made is registered one by one")


def connect(name: str, publisher: str) -> None:
    """Connect a subscribed topic soon to a publisher, given by its URI, unless it is connected."""
    if _registrar is not None:
        _registrar.connect(name, [publisher])


@contextlib.contextmanager
def together() -> Iterator[None]:
    """Put off what this thread registers and takes back; tell the master of all of it at the end.

    For a node that has thousands of topics and services: the requests would take most of its start.
    """
    registrar = _registrar
    if registrar is None or getattr(registrar.local, "batch", None) is not None:
        yield
        return
    batch = registrar.local.batch = _Batch()
    try:
        yield
    finally:
        registrar.local.batch = None
        if batch.removed:
            registrar.remove(batch.removed)
        if batch.added:
            registrar.add(batch.added)
        if batch.removed or batch.added:
            registrar.apply_later_changes(batch)


def reregister_all(request: Request) -> bool:
    """Tell the master once more of every topic and service of this node.

    rospy registers each of them once, so after a restart of the master no new
    subscriber or client would find it. Connections that exist are not touched.

    :param request: asks the master
    :returns: whether the master has taken any of it
    :raises ConnectionError: if that does
    """
    registrar = _registrar or _Registrar((_listeners() or [_OwnServer])[0], request)
    return registrar.add(all_entries(), request)


def services() -> Dict[str, str]:
    """Return the services that the master has taken from this process, each with its URI.

    In the order in which they were registered, without the node's private ones.
    """
    return dict(_registrar.services) if _registrar is not None else {}


def register_services(names: List[str], request: Request) -> None:
    """Register services of this process again, unless they have just been closed.

    :param names: of those that the master had taken
    :param request: asks the master
    :raises ConnectionError: if that does
    """
    registered = services()
    entries = [(Registration.SRV, name, registered[name]) for name in names if name in registered]
    if _registrar is not None:
        _registrar.add(entries, request)
        manager = get_service_manager()
        _registrar.remove([entry for entry in entries if manager.get_service(entry[1]) is None])


# Whose a service is: the master knows one node for each name, the latest that registered it.


def with_owners(names: Sequence[str], request: Request) -> str:
    """Return services with the nodes that offer them, as text.

    :param names: of the services
    :param request: asks the master
    :raises ConnectionError: if that does
    """
    state = request([("getSystemState",)])
    nodes = {name: ", ".join(found) for name, found in state[0][2][2]} if state else {}
    texts = [f"{name} ({nodes.get(name, 'unknown')})" for name in names[:_NAMED]]
    more = len(names) - _NAMED
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def _warn_of_others(services: Mapping[str, str], request: Request) -> None:
    """Warn of services that are just being registered and are another node's until then.

    :param services: names, each with this process's URI
    :param request: asks the master
    :raises ConnectionError: if that does
    """
    answers = request([("lookupService", name) for name in services]) if services else []
    owners: Dict[str, str] = {n: uri for n, (code, _, uri) in zip(services, answers) if code == 1}
    others = [name for name, uri in owners.items() if uri != services[name]]
    if others:
        text = "already offered; from now on this node is called instead: service %s"
        rospy.logwarn(text, with_owners(others, request))
