"""Queries of rospy's registry of this process's topics and services, and a check of topic types.

A topic has one type: rospy would silently use the first type for all its users in the process.
"""

from typing import Any, ContextManager, List, Tuple

import rospy
import rospy.names
from rospy.impl.registration import Registration, get_service_manager, get_topic_manager

#: Entry type, name, and the message type of a topic or the URI of a service.
Entry = Tuple[str, str, str]


def all_entries() -> List[Entry]:
    """Return every topic and service of this process."""
    topics, services = get_topic_manager(), get_service_manager()
    entries: List[Entry] = []
    for found, reg_type in (
        (topics.get_publications(), Registration.PUB),
        (topics.get_subscriptions(), Registration.SUB),
        (services.get_services(), Registration.SRV),
    ):
        entries += [(reg_type, name, type_or_uri) for name, type_or_uri in found]
    return entries


def name_before_remapping(name: str) -> str:
    """Return the name to pass to rospy, which remaps a resolved name a second time.

    :param name: resolved and remapped name
    :returns: the name, unless it is remapped in turn, as if two names are swapped
    """
    remapped = rospy.names.get_resolved_mappings()
    if name not in remapped:
        return name
    return next((old for old, new in remapped.items() if new == name and old[0] == "/"), name)


def topic_lock() -> ContextManager[Any]:
    """Return the lock that prevents rospy from closing a topic while a user is added."""
    lock: ContextManager[Any] = get_topic_manager().lock
    return lock


class NameTaken(rospy.ROSException):
    """Error of a name that is in use in this process already; the text has the name."""


def check_topic_type(topic: Any, data_class: Any) -> None:
    """Check that a topic is used with one type only.

    :param topic: rospy's object for the topic; None if the topic is not in use
    :param data_class: message class
    :raises NameTaken: if the topic has another type
    """
    if topic is not None:
        used, name = topic.data_class, topic.resolved_name
        if (used._type, used._md5sum) != (data_class._type, data_class._md5sum):
            why = f"must be {used._type}, as elsewhere in this process"
            raise NameTaken(f"topic {name}: refused {data_class._type}: {why}")
