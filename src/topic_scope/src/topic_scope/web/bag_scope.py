"""Main loop of the scope that shows a bag, without a node or a master."""

import asyncio
import logging
import signal
import socket
import sys
import threading
from typing import List, NoReturn, Sequence

import rospy
import tornado.ioloop

from nodekit.entry_point import end
from topic_scope.bag.recording import BagError
from topic_scope.bag.overlay import BagOverlay
from topic_scope.protocol.options import Options
from topic_scope.web import handlers
from topic_scope.web.bag_source import BagSource
from topic_scope.web.scope_session import ScopeSession


def run(options: Options, sockets: List[socket.socket], over: Sequence[BagOverlay]) -> NoReturn:
    """Show a bag until SIGINT, SIGTERM or SIGHUP, then exit.

    The exit status is 0, or 1 if the bag cannot be read.

    :param options: the command line, which names a bag
    :param sockets: sockets to serve
    :param over: the bags to overlay
    """
    _log_to_terminal()
    try:
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        source = BagSource(str(options.bag), options.history, options.window)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, tornado.ioloop.IOLoop.current().stop)
        session = ScopeSession(options, source, over)
        handlers.serve(options, sockets, handlers.ScopeHolder(session))
        rospy.loginfo("the scope shows %s at %s", options.bag, options.url)
        if not options.is_local:
            rospy.logwarn("it is open to the network: others can watch, and play the bag")
        if options.open_browser:
            threading.Thread(target=handlers.open_browser, args=(options.url,), daemon=True).start()
        tornado.ioloop.IOLoop.current().start()
    except BagError as error:
        sys.exit(f"scope.py: {error}")
    except KeyboardInterrupt:
        pass  # Ctrl-C before the signal handlers were installed
    end(0)


def _log_to_terminal() -> None:
    """Log to the terminal in place of rosout."""
    rospy.rostime.set_rostime_initialized(True)  # throttled logging reads the time
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("[%(levelname)s] %(message)s"))
    logger = logging.getLogger("rosout")
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logger.propagate = False
