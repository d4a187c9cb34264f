"""How rospy tells the master of topics and services: one by one, unless told otherwise."""

import contextlib
import xmlrpc.client
from typing import Any, Iterator, List, Tuple

import rosgraph
import rospy
import rospy.core
from rospy.impl.registration import (
    Registration,
    RegistrationListener,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

#: Most registrations in one request; the master's other clients are served between two.
_TOGETHER = 500

#: In this order: where what is published is known first, those who listen learn of it from the
#: answer to their own registration, and the master need not call each of them.
_METHODS = {
    Registration.PUB: "registerPublisher",
    Registration.SUB: "registerSubscriber",
    Registration.SRV: "registerService",
}

#: What is registered: kind, name, and its type or, of a service, its URI.
_Entry = Tuple[str, str, str]


def register_again() -> None:
    """Tell the master once more of every topic and service of this node.

    rospy registers each of them once, so after a restart of the master no new
    subscriber or client would find it. Connections that exist are not touched.
    """
    topics, services = get_topic_manager(), get_service_manager()
    entries: List[_Entry] = []
    for found, kind in (
        (topics.get_publications(), Registration.PUB),
        (topics.get_subscriptions(), Registration.SUB),
        (services.get_services(), Registration.SRV),
    ):
        entries += [(kind, name, type_or_uri) for name, type_or_uri in found]
    _register(get_registration_listeners().listeners, entries)


@contextlib.contextmanager
def registering_together() -> Iterator[None]:
    """Put off registrations, and make them in a few requests at the end.

    For a node that has thousands of topics and services: the requests would take most of its start.
    """
    listeners = get_registration_listeners()
    collector = _Collector()
    with listeners.lock:
        before, listeners.listeners = listeners.listeners, [collector]
    try:
        yield
    finally:
        with listeners.lock:
            # When the node ends, rospy has taken back what there was, and nothing must follow.
            ends = rospy.core.is_shutdown_requested()
            listeners.listeners = [] if ends else before
        if not ends:
            _register(before, collector.entries)


class _Collector(RegistrationListener):
    """Notes what is to be registered."""

    def __init__(self) -> None:
        self.entries: List[_Entry] = []

    def reg_added(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        self.entries.append((reg_type, resolved_name, data_type_or_uri))

    def reg_removed(self, resolved_name: str, data_type_or_uri: str, reg_type: str) -> None:
        self.entries.remove((reg_type, resolved_name, data_type_or_uri))


def _register(listeners: List[Any], entries: List[_Entry]) -> None:
    """Register with the master, or one by one with rospy's patience where it does not answer."""
    kinds = list(_METHODS)
    entries = sorted(entries, key=lambda entry: kinds.index(entry[0]))
    for start in range(0, len(entries), _TOGETHER):
        part = entries[start : start + _TOGETHER]
        try:
            answers = _request(part)
        except (OSError, xmlrpc.client.Error):
            answers = [None] * len(part)
        for (kind, name, type_or_uri), answer in zip(part, answers):
            for listener in listeners:
                if answer is None or answer[0] != 1:
                    listener.reg_added(name, type_or_uri, kind)
                elif kind == Registration.SUB:
                    _connect(listener, name, answer[2])


def _request(entries: List[_Entry]) -> List[Any]:
    with xmlrpc.client.ServerProxy(rosgraph.get_master_uri()) as master:
        batch = xmlrpc.client.MultiCall(master)
        for kind, name, type_or_uri in entries:
            getattr(batch, _METHODS[kind])(
                rospy.get_name(), name, type_or_uri, rospy.get_node_uri()
            )
        answers = batch()
        return [answers[i] for i in range(len(entries))]


def _connect(listener: Any, name: str, publishers: List[str]) -> None:
    """Connect to the publishers of a topic, but to those that need no connection."""
    topic = get_topic_manager().get_subscriber_impl(name)
    missing = [uri for uri in publishers if topic is None or not topic.has_connection(uri)]
    if missing:
        listener.publisher_update(name, missing)
