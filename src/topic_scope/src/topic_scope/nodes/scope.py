"""Node of the oscilloscope: serves a page that shows numeric fields of any topics."""

import errno
import logging
import sys
import threading
from typing import Sequence

import rospy

from nodekit import NodeScope, run
from topic_scope.bag.recording import BagError
from topic_scope.bag.overlay import BagOverlay
from topic_scope.protocol import options
from topic_scope.protocol.options import Options
from topic_scope.web import bag_scope, handlers
from topic_scope.web.live_graph import LiveGraph
from topic_scope.web.overlay_loader import open_overlays
from topic_scope.web.scope_session import ScopeSession
from topic_scope.web.http_server import HttpServer


class Scope:
    """Oscilloscope: serves the page until the node is shut down.

    :ROS Subscribers:
        - the topics of the shown fields, of any type, and of the shown images

    :ROS Services called:
        - ``describe`` and ``change`` of each node that offers them; SetBool and Trigger services
          of such nodes, when a page calls them

    :param node: the node
    :param chosen: the options, with the port in use
    :param site: HTTP server of the page
    :param over: the bags to overlay
    """

    def __init__(
        self, node: NodeScope, chosen: Options, site: HttpServer, over: Sequence[BagOverlay]
    ) -> None:
        self._node, self._options, self._over = node, chosen, over
        site.show(self._server)
        rospy.loginfo("the scope is at %s", chosen.url)
        if not chosen.is_local:
            rospy.logwarn("it is open to the network: others can watch, but cannot set anything")

    def _server(self) -> ScopeSession:
        source = LiveGraph(self._node, not self._options.is_local)
        return ScopeSession(self._options, source, self._over)


def main() -> None:
    """Run the node until it is shut down."""
    wanted = options.parse(sys.argv[1:])
    try:
        over = open_overlays(wanted)
        sockets = handlers.bind(wanted)
    except BagError as error:
        sys.exit(f"scope.py: {error}")
    except OSError as error:
        sys.exit("scope.py: " + _why_not(error, wanted))
    chosen = wanted._replace(port=sockets[0].getsockname()[1])
    logging.getLogger("tornado").setLevel(logging.ERROR)
    if chosen.bag is not None:
        bag_scope.run(chosen, sockets, over)
    # The port makes the names of several scopes unique.
    name = "scope" if chosen.port == options.DEFAULT_PORT else f"scope_{chosen.port}"

    site = HttpServer(
        chosen, sockets
    )  # before the master is up: the page reports that it is missing
    if chosen.open_browser:
        threading.Thread(target=handlers.open_browser, args=(chosen.url,), daemon=True).start()

    def start(node: NodeScope) -> Scope:
        if chosen.port != wanted.port:
            rospy.loginfo("port %d is taken: the next free one is %d", wanted.port, chosen.port)
        return Scope(node, chosen, site, over)

    run(name, start)


def _why_not(error: OSError, chosen: Options) -> str:
    if error.errno == errno.EADDRINUSE:
        last = chosen.ports[-1]
        free = last + 1 if last < 65535 else options.DEFAULT_PORT
        if chosen.next_port:
            return f"ports {chosen.port} to {last} are taken: use --port {free}"
        return (
            f"port {chosen.port} is taken, perhaps by another scope: close that, or use "
            f"--port {free} (in a launch file port:={free})"
        )
    if error.errno == errno.EACCES:
        return f"port {chosen.port} needs root: use --port {options.DEFAULT_PORT}"
    return f"cannot listen on {chosen.address}, port {chosen.port}: {error.strerror}"
