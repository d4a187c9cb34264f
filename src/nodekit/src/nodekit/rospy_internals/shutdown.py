"""Shutdown hooks called in phases, and patches of rospy: spurious errors, requests to others."""

import enum
import re
import traceback
from functools import partial
from typing import Any, Callable, Dict, List, Optional

import rospy
import rospy.core
from rospy.impl import masterslave, tcpros_service
from rospy.impl.tcpros_base import TCPServer

from nodekit.process_context import PROCESS

#: Start of rospy's message about a client that disconnects before its request is read.
_HUNG_UP = "incoming connection failed"
#: Start of the master's message to a node that another one of its name replaces.
_REPLACED = re.compile(r"\[(/.*?)\] Reason: ")


def patch_shutdown() -> None:
    """Prevent tracebacks and errors at shutdown.

    A server listens on a closed socket if its first client connects during shutdown. A client that
    disconnects before its request is read, for example when it is interrupted, is not an error of
    this node: the client reports it.
    """
    serve, log_error = TCPServer.run, getattr(tcpros_service, "logerr", rospy.logerr)

    def serve_until_shutdown(server: TCPServer) -> None:
        try:
            serve(server)
        except OSError:
            if not rospy.core.is_shutdown_requested():
                raise

    TCPServer.run = serve_until_shutdown
    tcpros_service.logerr = partial(log_service_error, log_error)
    if _ROSPY_HOOKS is None:
        rospy.logwarn(
            "unsupported rospy version: nodes end after the functions of rospy.on_shutdown"
        )


def ignore_requests_to_others() -> None:
    """Patch rospy to ignore the master's request to shut down a node that is not this one.

    A killed node stays registered. If Linux gives its port to a node that starts later, and the
    killed one is started again, then the master asks the wrong node to shut down.
    """
    shut_down: Callable[..., Any] = masterslave.ROSHandler.shutdown

    def shut_down_if_meant(handler: Any, caller_id: str, reason: str = "") -> Any:
        meant = _REPLACED.match(reason)
        if meant is None or meant.group(1) == rospy.get_name():
            return shut_down(handler, caller_id, reason)
        rospy.logwarn(
            f"ignoring the master's request to end {meant.group(1)}: its former port is now that of"
            f" {rospy.get_name()}"
        )
        return 1, "another node", 0

    masterslave.ROSHandler.shutdown = shut_down_if_meant


def log_service_error(log_error: Callable[..., None], text: str, *args: object) -> None:
    """Log an error of rospy's services, at debug level if a client has disconnected.

    :param log_error: logs an error
    :param text: rospy's message
    :param args: its arguments
    """
    (rospy.logdebug if text.startswith(_HUNG_UP) else log_error)(text, *args)


class ShutdownPhase(enum.IntEnum):
    """Phases of the shutdown, in this order."""

    #: Shutdown hooks of nodes' classes; publishers and clients still work.
    NODES = 0
    #: Managed nodes go through shutdown; publishers and clients still work.
    TRANSITIONS = 1
    #: Service calls are cancelled, executors and timers stop, parameters are released.
    TOOLKIT = 2
    #: Publishers send the messages that they hold; nothing of nodekit publishes any longer.
    PUBLISHERS = 3


class _Hooks(Dict[ShutdownPhase, List[Callable[[], object]]]):
    """Functions by phase, the latest first.

    Lists are changed and copied atomically, because a signal handler may interrupt.
    """

    def __init__(self) -> None:
        super().__init__((phase, []) for phase in ShutdownPhase)


def at_end(phase: ShutdownPhase, function: Callable[[], object]) -> Callable[[], None]:
    """Call a function at shutdown.

    During a shutdown, a function of the phase TOOLKIT is called immediately, and maybe again.

    :param phase: the phase of the shutdown
    :param function: the function, called before those added earlier for the phase
    :returns: a function that removes it
    """
    functions = PROCESS.get(_Hooks)[phase]
    functions.insert(0, function)
    if phase is ShutdownPhase.TOOLKIT and rospy.core.is_shutdown_requested():
        function()
    return partial(functions.remove, function)


def _call_all() -> None:
    for functions in PROCESS.get(_Hooks).values():
        for function in list(functions):
            try:
                function()
            except Exception:  # as in rospy: the others are still called
                traceback.print_exc()


# First, even before functions that were passed to rospy.on_shutdown() before this import.
_ROSPY_HOOKS: Optional[List[Any]] = getattr(rospy.core, "_client_shutdown_hooks", None)
if _ROSPY_HOOKS is not None:
    _ROSPY_HOOKS.insert(0, _call_all)
else:
    rospy.on_shutdown(_call_all)
