"""The life of a node's process, the same for every node: start, spin, exit status."""

import sys
from typing import Callable

import rospy

from basic_comms.parameter_server import UNREACHABLE
from basic_comms.parameter_watch import get_watcher
from basic_comms.parameters import ParameterError

EXIT_OK, EXIT_REFUSED = 0, 1


def run(name: str, start: Callable[[], object]) -> None:
    """Run a node until it is shut down, then end the process.

    The exit status is 0 after SIGINT, SIGTERM or ``rosnode kill``, and 1 where
    the start was refused because of a parameter or an unreachable master.

    :param name: name of the node where none is given by ``__name``
    :param start: makes the node, after it was registered; what it returns is
        kept alive until the end
    """
    try:
        rospy.init_node(name)
        get_watcher()  # also registers the node again, should the master be restarted
        node = start()
        rospy.spin()
        del node
    except ParameterError as error:
        rospy.logfatal("%s", error)
        sys.exit(EXIT_REFUSED)
    except UNREACHABLE as error:
        if not rospy.is_shutdown():
            rospy.logfatal("the master stopped answering during the start: %s", error)
            sys.exit(EXIT_REFUSED)
    except (rospy.ROSInitException, rospy.ROSInterruptException):
        if not rospy.is_shutdown():
            raise
    except KeyboardInterrupt:
        pass  # Ctrl-C before rospy took over the signal
    sys.exit(EXIT_OK)
