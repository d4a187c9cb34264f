"""Error hint of commands for a missing service: similar nodes that offer it, or none running.

It suggests nodes with a similar name, and tells a running node from a missing one.
"""

import difflib

from nodekit.master import MasterClient
from nodekit.parameter_server.parameter_services import DESCRIBE


def service_hint(master: MasterClient, service: str, node: str) -> str:
    """Return a clause that names nodes that offer a service: the nearest name, or all.

    :param master: client of the master
    :param service: base name of the service
    :param node: global name of the node that does not offer it
    """
    names = master.namespaces_offering(service)
    near = difflib.get_close_matches(node.rstrip("/"), names, n=1) or names
    if near:
        return f"there is {', '.join(near)}"
    if is_running(master, node):
        return f"{node.rstrip('/')} is running, but without the service {service}"
    return "no such node is running"


def is_running(master: MasterClient, node: str) -> bool:
    """Return whether a node is on the graph, as a process or hosted in one.

    :param master: client of the master
    :param node: global name of the node
    """
    # The master does not list hosted nodes, only their services.
    name = node.rstrip("/")
    return bool(master.lookup_node(name) or master.lookup_service(f"{name}/{DESCRIBE}"))
