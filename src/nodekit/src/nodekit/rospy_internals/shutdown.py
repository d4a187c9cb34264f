"""How rospy ends."""

import threading
import traceback
from functools import partial
from typing import Callable, List

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


#: What is called first of all. Lists are changed and copied in one step, also amid a signal.
_first: List[Callable[[], None]] = []


def before_shutdown(function: Callable[[], None]) -> Callable[[], None]:
    """Have a function called first of all when the node ends, while all of it still works.

    :param function: what to call, before those that were given earlier
    :returns: a function that ends this
    """
    _first.insert(0, function)
    return partial(_first.remove, function)


def _call_first() -> None:
    for function in list(_first):
        try:
            function()
        except Exception:  # as rospy does it: the others are called all the same
            traceback.print_exc()


rospy.core._client_shutdown_hooks.insert(0, _call_first)
