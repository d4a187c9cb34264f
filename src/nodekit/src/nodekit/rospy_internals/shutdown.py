"""How rospy ends."""

import threading
from typing import Callable

import rospy
import rospy.core
from rospy.impl.tcpros_base import TCPServer


def mend_shutdown() -> None:
    """Let nodes end without a traceback.

    rospy 1.15.9 calls a method of threads that Python 3.9 no longer has. And a
    server whose first client comes while the node ends listens on a socket that
    is closed already.
    """
    if "isAlive" in rospy.core.signal_shutdown.__code__.co_names:
        setattr(threading.Thread, "isAlive", threading.Thread.is_alive)
    serve = TCPServer.run

    def serve_until_shutdown(server: TCPServer) -> None:
        try:
            serve(server)
        except OSError:
            if not rospy.core.is_shutdown_requested():
                raise

    TCPServer.run = serve_until_shutdown


def at_shutdown(function: Callable[[], None]) -> None:
    """Have a function called when the node ends: at once, and maybe twice, where that has begun.

    rospy calls only what it was given before, and drops what it is given meanwhile.

    :param function: what to call
    """
    rospy.on_shutdown(function)
    if rospy.core.is_shutdown_requested():
        function()


def before_shutdown(function: Callable[[], None]) -> None:
    """Have a function called first of all when the node ends, while all of it still works.

    :param function: what to call
    """
    rospy.core._client_shutdown_hooks.insert(0, function)
