"""How rospy tells the master of topics and services."""

from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)


def register_again() -> None:
    """Tell the master once more of every topic and service of this node.

    rospy registers each of them once, so after a restart of the master no new
    subscriber or client would find it. Connections that exist are not touched.
    """
    listeners = get_registration_listeners()
    topics, services = get_topic_manager(), get_service_manager()
    for entries, kind in (
        (topics.get_publications(), Registration.PUB),
        (topics.get_subscriptions(), Registration.SUB),
        (services.get_services(), Registration.SRV),
    ):
        for name, type_or_uri in entries:
            listeners.notify_added(name, type_or_uri, kind)
