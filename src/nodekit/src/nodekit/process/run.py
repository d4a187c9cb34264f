"""The life of a node's process, the same for every node: start, spin, exit status."""

import sys
import threading
import time
from typing import Callable, List

import rosgraph
import rospy

from nodekit.live.parameter_server import UNREACHABLE, ParameterServer
from nodekit.live.watcher import get_watcher
from nodekit.parameters.declaration import ParameterError
from nodekit.process import timer_slack
from nodekit.rospy_internals import signals
from nodekit.rospy_internals.start import looking_often

EXIT_OK, EXIT_REFUSED = 0, 1

#: Longest wait for a start that is under way when the node is told to end, s.
_PATIENCE_S = 1.0


def run(name: str, start: Callable[[], object]) -> None:
    """Run a node until it is shut down, then end the process.

    The exit status is 0 after SIGINT, SIGTERM, SIGHUP or ``rosnode kill``, and 1
    where the start was refused because of a parameter or an unreachable master.

    :param name: name of the node where none is given by ``__name``
    :param start: makes the node, after it was registered; what it returns is
        kept alive until the end
    """
    try:
        signals.register()
        timer_slack.tighten()
        _wait_for_master(name)
        node = _start_beside(name, start)
        if not rospy.is_shutdown():
            rospy.spin()
        del node
    except ParameterError as error:
        rospy.logfatal("%s", error)
        sys.exit(EXIT_REFUSED)
    except UNREACHABLE as error:
        rospy.logfatal("the master stopped answering during the start: %s", error)
        sys.exit(EXIT_REFUSED)
    except KeyboardInterrupt:
        pass  # Ctrl-C before rospy took over the signal
    sys.exit(EXIT_OK)


def _wait_for_master(name: str) -> None:
    """Wait until the master answers or the node is told to end.

    ``rospy.init_node`` waits too, but holds a lock that the answer to a signal needs.
    """
    uri = rosgraph.get_master_uri()
    master = ParameterServer(uri, "/" + name, "", timeout=1.0)
    told = False
    while not rospy.is_shutdown():
        try:
            master.read([])
            return
        except UNREACHABLE as error:
            if not told:
                rospy.logwarn("waiting for the master at %s: %s", uri, error)
                told = True
            time.sleep(0.1)


def _start_beside(name: str, start: Callable[[], object]) -> List[object]:
    """Start a node in a thread of its own, while this one stays free for signals.

    rospy answers a signal by talking to the master, over a connection with a
    lock. In the very thread that was registering a topic over it, it would wait
    for itself for ever.

    :returns: the node, in a list that is empty where a signal came first
    :raises Exception: what the start raised, unless the node is shutting down
    """
    node: List[object] = []
    errors: List[BaseException] = []

    def work() -> None:
        try:
            with looking_often():
                rospy.init_node(name, disable_signals=True)
            get_watcher()  # also registers the node again, should the master be restarted
            node.append(start())
        except BaseException as error:
            errors.append(error)

    worker = threading.Thread(target=work, name="start", daemon=True)
    worker.start()
    while worker.is_alive() and not rospy.is_shutdown():
        worker.join(0.1)
    worker.join(_PATIENCE_S)
    if errors and not rospy.is_shutdown():
        raise errors[0]
    return node
