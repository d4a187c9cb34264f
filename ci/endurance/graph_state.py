"""What the master knows of a node."""

from typing import Any, List, NamedTuple, Optional, Tuple

from ..benchmark.tcpros import Node


class Registrations(NamedTuple):
    """The names that a node is registered for."""

    published: Tuple[str, ...]
    subscribed: Tuple[str, ...]
    services: Tuple[str, ...]


NOTHING = Registrations((), (), ())


def registrations(system_state: List[Any], name: str) -> Registrations:
    """Return what a node is registered for; a name that stands there twice is there twice.

    :param system_state: what the master's getSystemState returns
    :param name: of the node
    """
    return Registrations(
        *(
            tuple(sorted(topic for topic, nodes in part for node in nodes if node == name))
            for part in system_state
        )
    )


def of_node(observer: Node, name: str) -> Registrations:
    """Ask the master what a node is registered for."""
    return registrations(observer.master("getSystemState"), name)


def address(observer: Node, name: str) -> Optional[str]:
    """Ask the master where a node is.

    :returns: its URI; None if it is not registered
    """
    try:
        return str(observer.master("lookupNode", name))
    except RuntimeError:
        return None
