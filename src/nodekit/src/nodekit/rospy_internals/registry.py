"""What this process publishes, subscribes to and serves at the moment, as rospy keeps it.

A topic has one type: rospy takes a second one in a process for the first, without a word.
"""

from typing import Any, ContextManager, List, Tuple

import rospy
import rospy.names
from rospy.impl.registration import Registration, get_service_manager, get_topic_manager

#: What is registered: kind, name, and its type or, of a service, its URI.
Entry = Tuple[str, str, str]


def all_entries() -> List[Entry]:
    """Return every topic and service of this process."""
    topics, services = get_topic_manager(), get_service_manager()
    entries: List[Entry] = []
    for found, kind in (
        (topics.get_publications(), Registration.PUB),
        (topics.get_subscriptions(), Registration.SUB),
        (services.get_services(), Registration.SRV),
    ):
        entries += [(kind, name, type_or_uri) for name, type_or_uri in found]
    return entries


def name_before_remapping(name: str) -> str:
    """Return what to call a topic or a service, whose name rospy remaps once more.

    :param name: resolved, and remapped if it is to be
    :returns: the name itself unless that is remapped in turn, as where two are swapped
    """
    remapped = rospy.names.get_resolved_mappings()
    if name not in remapped:
        return name
    return next((old for old, new in remapped.items() if new == name and old[0] == "/"), name)


def topic_lock() -> ContextManager[Any]:
    """Keep rospy from closing a topic, whose last user goes, while another one is made."""
    lock: ContextManager[Any] = get_topic_manager().lock
    return lock


class NameTaken(rospy.ROSException):
    """A name that this process uses for something else already; the text says which."""


def check_topic_type(topic: Any, data_class: Any) -> None:
    """Refuse to use a topic with a second type.

    :param topic: rospy's implementation object of the topic; None if there is none
    :param data_class: message class
    :raises NameTaken: if that is of another type
    """
    if topic is not None:
        used, name = topic.data_class, topic.resolved_name
        if (used._type, used._md5sum) != (data_class._type, data_class._md5sum):
            why = f"must be {used._type}, as elsewhere in this process"
            raise NameTaken(f"topic {name}: refused {data_class._type}: {why}")
