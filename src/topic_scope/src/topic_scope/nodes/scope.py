"""The oscilloscope: serves a page that shows numeric fields of any topics."""

import asyncio
import errno
import logging
import socket
import sys
import threading
import traceback
from typing import List

import rospy
import tornado.ioloop

from nodekit import run
from topic_scope import bag_scope, options, web
from topic_scope.live_graph import LiveGraph
from topic_scope.options import Options
from topic_scope.serving import open_browser, serve


class Scope:
    """Serves the page, and runs until the node is shut down.

    :ROS Subscribers:
        - the topics of the fields that are looked at, of any type

    :ROS Services called:
        - ``describe`` and ``change`` of each node that has them; SetBool and Trigger services
          beside them, when a page calls them

    :param chosen: the options, with the port that is served at
    :param sockets: where to serve
    """

    def __init__(self, chosen: Options, sockets: List[socket.socket]) -> None:
        self._options = chosen
        self._sockets = sockets
        self._running = threading.Event()
        threading.Thread(target=self._serve, name="web", daemon=True).start()
        self._running.wait()
        rospy.loginfo("the scope is at %s", chosen.url)
        if not chosen.is_local:
            rospy.logwarn("it is open to the network: others can watch, nobody can set anything")
        if chosen.open_browser:
            threading.Thread(target=open_browser, args=(chosen.url,), daemon=True).start()

    def _serve(self) -> None:
        try:
            asyncio.set_event_loop(asyncio.new_event_loop())
            loop = tornado.ioloop.IOLoop.current()
            serve(self._options, self._sockets, LiveGraph(not self._options.is_local))
            loop.add_callback(self._running.set)
            loop.start()
        except Exception:
            rospy.logfatal("the scope has ended:\n%s", traceback.format_exc())
            rospy.signal_shutdown("the scope has ended")
            self._running.set()


def main() -> None:
    """Run the node until it is shut down."""
    wanted = options.parse(sys.argv[1:])
    try:
        sockets = web.bind(wanted)
    except OSError as error:
        sys.exit("scope.py: " + _why_not(error, wanted))
    chosen = wanted._replace(port=sockets[0].getsockname()[1])
    logging.getLogger("tornado").setLevel(logging.ERROR)
    if chosen.bag is not None:
        bag_scope.run(chosen, sockets)
    # Two scopes are two nodes: their ports differ, so their names do.
    name = "scope" if chosen.port == options.DEFAULT_PORT else f"scope_{chosen.port}"

    def start(_node: object) -> Scope:
        if chosen.port != wanted.port:
            rospy.loginfo("port %d is taken: the next free one is %d", wanted.port, chosen.port)
        return Scope(chosen, sockets)

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
        return f"port {chosen.port} is not for users: use --port {options.DEFAULT_PORT}"
    return f"cannot serve at {chosen.address}, port {chosen.port}: {error.strerror}"
