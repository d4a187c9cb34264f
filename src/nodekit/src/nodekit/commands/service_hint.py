"""Hint for a command whose node does not offer the command's service."""

import difflib

from nodekit.master import MasterClient


def service_hint(master: MasterClient, service: str, node: str) -> str:
    """Return a clause that names nodes that offer a service: the nearest name, or all.

    :param master: client of the master
    :param service: base name of the service
    :param node: global name of the node that does not offer it
    """
    names = master.namespaces_offering(service)
    near = difflib.get_close_matches(node.rstrip("/"), names, n=1) or names
    return f"there is {', '.join(near)}" if near else "no such node is running"
