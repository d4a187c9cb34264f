"""What this process publishes, subscribes to and serves at the moment, as rospy keeps it."""

from typing import Any, ContextManager, List, Tuple

from rospy.impl.registration import Registration, get_service_manager, get_topic_manager

#: What is registered: kind, name, and its type or, of a service, its URI.
Entry = Tuple[str, str, str]


def all_made() -> List[Entry]:
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


def topic_lock() -> ContextManager[Any]:
    """Keep rospy from closing a topic, whose last user goes, while another one is made."""
    lock: ContextManager[Any] = get_topic_manager().lock
    return lock
