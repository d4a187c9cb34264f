"""The fleet: many pairs of signal generator and process in one process of the machine."""

import resource
import sys
from typing import Callable, List

import rospy

from basic_comms.nodes.process import Process
from basic_comms.nodes.signal_generator import SignalGenerator
from nodekit.life.names import NodeScope
from nodekit.live.live_parameters import LiveParameters
from nodekit.live.watcher import get_watcher
from nodekit.parameters.declaration import (
    IntParameter,
    ParameterError,
    ParameterSet,
    StringParameter,
)
from nodekit.process.run import run
from nodekit.rospy_internals import parameters
from nodekit.rospy_internals.registration import registering_together
from nodekit.timing.scheduler import get_scheduler

#: How long one thread keeps the interpreter from the others, s. With Python's 5 ms, a subscriber
#: that connects would wait as long at each of its steps while the members' signals are made.
_SWITCH_INTERVAL_S = 0.0005


class FleetParameters(ParameterSet):
    """Private parameters of the fleet; read at the start."""

    count = IntParameter(2, minimum=0, maximum=5000, help="how many groups there are")
    prefix = StringParameter("Group", help="what the groups' names start with, before 1, 2, ...")


class Fleet:
    """Hosts groups that look like as many pairs of separate nodes.

    Each group ``<prefix>1`` ... ``<prefix>N`` holds what the nodes
    ``signal_generator`` and ``process`` would hold there: topics, parameters,
    services. A member whose parameters are refused stays down alone.

    :ROS Parameters:
        - those of :class:`FleetParameters`, private
        - of each member, in ``<group>/signal_generator`` and ``<group>/process``
    """

    def __init__(self) -> None:
        _allow_many_connections()
        sys.setswitchinterval(_SWITCH_INTERVAL_S)
        # Or rospy sends the names of all topics with each line of the log.
        parameters.cache(parameters.ROSOUT_PARAMETER, True)
        self._parameters = LiveParameters(FleetParameters)
        values = self._parameters.values
        groups = [
            rospy.resolve_name("%s%d" % (values.prefix, number))
            for number in range(1, values.count + 1)
        ]
        self._members: List[object] = []
        # The process first, so that it hears the generator's first sample.
        scopes = [
            (member, NodeScope.hosted(group, name))
            for group in groups
            for member, name in ((Process, "process"), (SignalGenerator, "signal_generator"))
        ]
        keys = [scope.parameters for _, scope in scopes]
        with get_scheduler().starting_together(), registering_together():
            with get_watcher().starting_together(keys):
                for member, scope in scopes:
                    self._start(member, scope)
        rospy.loginfo("%d members of %d groups run", len(self._members), len(groups))
        self._parameters.start()

    def _start(self, member: Callable[[NodeScope], object], scope: NodeScope) -> None:
        try:
            self._members.append(member(scope))
        except ParameterError as error:
            rospy.logerr("%s; %s stays down", error, scope.parameters)


def _allow_many_connections() -> None:
    """Raise the limit of open files as far as this user may: a group takes about ten."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def main() -> None:
    """Run the node until it is shut down."""
    run("fleet", Fleet)
