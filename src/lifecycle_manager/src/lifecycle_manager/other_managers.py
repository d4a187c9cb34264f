"""Detection of another manager of the same nodes."""

from typing import Optional, Sequence

import rospy
from std_srvs.srv import Trigger, TriggerRequest

from nodekit import CallError, CallTimeout, Node
from nodekit.master import MasterClient

#: Service that identifies a manager, besides its subscription to a heartbeat.
SERVICE = "/manage_nodes"
#: Timeout for an answer of the master, and of another manager [s].
TIMEOUT_S = 1.0


def find_other_manager(node: Node, names: Sequence[str]) -> Optional[str]:
    """Return a message that names a node with another manager, or None.

    A manager subscribes to a node's heartbeat and offers ``~manage_nodes``. It searches for others
    after its own subscription, so of two that start together the later one sees the other.

    :param node: the searching manager
    :param names: of the nodes
    :raises nodekit.MasterUnreachable: if the master does not answer
    """
    with MasterClient(node.name, timeout=TIMEOUT_S) as master:
        state = master.system_state()
    managers = {
        owner: service[: -len(SERVICE)]
        for service, owners in state.services
        if service.endswith(SERVICE)
        for owner in owners
    }
    subscribers = dict(state.subscribers)
    for name in names:
        for other in subscribers.get(f"{name}/heartbeat", ()):
            is_manager = other in managers and other != rospy.get_name()
            if is_manager and _is_there(node, managers[other]):
                return f"{name} is managed by {managers[other]}"
    return None


def _is_there(node: Node, manager: str) -> bool:
    """Return whether a manager still runs, even if suspended."""
    client = node.create_client(f"{manager}/is_active", Trigger)
    try:
        client.call(TriggerRequest(), TIMEOUT_S)
    except CallTimeout:
        return True
    except CallError:
        return False
    return True
