"""How rospy ends, and who is called then, in which order: nobody else asks rospy for it."""

import enum
import traceback
from functools import partial
from typing import Any, Callable, Dict, List, Optional

import rospy
import rospy.core
from rospy.impl import tcpros_service
from rospy.impl.tcpros_base import TCPServer

#: How rospy begins to tell that a client has hung up before its request was read.
_HUNG_UP = "incoming connection failed"


def patch_shutdown() -> None:
    """Let nodes end without a traceback.

    A server whose first client comes while the node ends listens on a socket that is closed
    already. And that a client hangs up, as one of the node itself whose call is cancelled, is no
    error then.
    """
    serve, log_error = TCPServer.run, getattr(tcpros_service, "logerr", rospy.logerr)

    def serve_until_shutdown(server: TCPServer) -> None:
        try:
            serve(server)
        except OSError:
            if not rospy.core.is_shutdown_requested():
                raise

    def log_unless_at_the_end(text: str, *args: object) -> None:
        if not (text.startswith(_HUNG_UP) and rospy.core.is_shutdown_requested()):
            log_error(text, *args)

    TCPServer.run = serve_until_shutdown
    tcpros_service.logerr = log_unless_at_the_end
    if _hooks is None:
        rospy.logwarn("unsupported rospy version: nodes end after what rospy.on_shutdown was given")


class ShutdownPhase(enum.IntEnum):
    """The order in which all ends: what is given for the first is called before all the rest."""

    #: What nodes' classes have asked for; publishers and clients still work.
    NODES = 0
    #: Managed nodes go through shutdown; publishers and clients still work.
    TRANSITIONS = 1
    #: Calls of services are cancelled, executors and timers stop, parameters are left.
    TOOLKIT = 2


#: What is to be called, each the latest first. Lists are changed and copied in one step, also amid
#: a signal.
_functions: Dict[ShutdownPhase, List[Callable[[], object]]] = {phase: [] for phase in ShutdownPhase}


def at_end(phase: ShutdownPhase, function: Callable[[], object]) -> Callable[[], None]:
    """Have a function called when the process is told to end.

    Where that has begun, one of the toolkit is called at once, and maybe twice: rospy drops what it
    is given meanwhile.

    :param phase: when
    :param function: what to call, before those that were given earlier for the same
    :returns: a function that ends this
    """
    _functions[phase].insert(0, function)
    if phase is ShutdownPhase.TOOLKIT and rospy.core.is_shutdown_requested():
        function()
    return partial(_functions[phase].remove, function)


def _call_all() -> None:
    for functions in _functions.values():
        for function in list(functions):
            try:
                function()
            except Exception:  # as rospy does it: the others are called all the same
                traceback.print_exc()


# Before all that rospy.on_shutdown is given, also before this is imported.
_hooks: Optional[List[Any]] = getattr(rospy.core, "_client_shutdown_hooks", None)
if _hooks is not None:
    _hooks.insert(0, _call_all)
else:
    rospy.on_shutdown(_call_all)
