"""The web server, in a thread of its own: it is there before the graph is, and stays."""

import asyncio
import socket
import threading
from typing import Callable, List, Optional

import rosgraph
import rospy
import tornado.ioloop

from nodekit.master import MasterClient, MasterUnreachable
from topic_scope.protocol.options import Options
from topic_scope.web import web
from topic_scope.web.server import Server
from topic_scope.web.serving import serve
from topic_scope.web.waiting import Waiting


class Site:
    """Serves pages; they wait until there is something to show.

    :param options: the command line, with the port that is served at
    :param sockets: where to serve
    """

    def __init__(self, options: Options, sockets: List[socket.socket]) -> None:
        self._options, self._sockets = options, sockets
        self._waiting = Waiting(rosgraph.get_master_uri(), options.window)
        self._front = web.Front(self._waiting)
        self._running = threading.Event()
        self._error: Optional[Exception] = None
        threading.Thread(target=self._serve, name="web", daemon=True).start()
        self._running.wait()
        if self._error is not None:
            raise self._error
        threading.Thread(target=self._look_for_master, daemon=True).start()

    def show(self, make: Callable[[], Server]) -> None:
        """Show something from now on.

        :param make: makes it, in the thread of the web
        :raises Exception: what that raises
        """
        made = threading.Event()

        def begin() -> None:
            try:
                self._front.scope = make()
                while self._waiting.sockets:
                    self._waiting.sockets.pop(0).enter()
            except Exception as error:
                self._error = error
            made.set()

        self._loop.add_callback(begin)
        made.wait()
        if self._error is not None:
            raise self._error

    def _serve(self) -> None:
        try:
            asyncio.set_event_loop(asyncio.new_event_loop())
            self._loop = tornado.ioloop.IOLoop.current()
            serve(self._options, self._sockets, self._front)
        except Exception as error:
            self._error = error
            self._running.set()
            return
        self._loop.add_callback(self._running.set)
        self._loop.start()

    def _look_for_master(self) -> None:
        """Say where the page is, and what it waits for, if that will not be said soon."""
        try:
            with MasterClient("/scope", timeout=1.0) as master:
                master.read([])
        except MasterUnreachable:
            rospy.logwarn("the scope is at %s already", self._options.url)
            self._loop.add_callback(self._waiting.miss)
