"""Registrations of a node at the master."""

import contextlib
from typing import Any, List, Optional, Tuple

import rosgraph

#: The names of topics published, topics subscribed and services.
Registrations = Tuple[Tuple[str, ...], ...]

NOTHING: Registrations = ((), (), ())


def registrations(system_state: List[Any], name: str) -> Registrations:
    """Return what a node is registered for; a name that is registered twice appears twice.

    :param system_state: the answer to the master's getSystemState
    :param name: of the node
    """
    return tuple(
        tuple(sorted(topic for topic, nodes in part for node in nodes if node == name))
        for part in system_state
    )


def of_node(master: rosgraph.Master, name: str) -> Registrations:
    """Return what a node is registered for now."""
    return registrations(master.getSystemState(), name)


def address(master: rosgraph.Master, name: str) -> Optional[str]:
    """Return a node's URI; None if it is not registered."""
    with contextlib.suppress(rosgraph.MasterError):
        return str(master.lookupNode(name))
    return None
