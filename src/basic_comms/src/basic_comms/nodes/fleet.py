"""Fleet node: many pairs of signal generator and process in one process of the machine."""

import sys

import rospy

from basic_comms.nodes.process import Process
from basic_comms.nodes.signal_generator import SignalGenerator
from nodekit import (
    LEGAL_NAME,
    IntParameter,
    Node,
    ParameterSet,
    StringParameter,
    host_all,
    is_legal_name,
    read_once,
    rule,
    run,
)

#: Thread switch interval of the interpreter [s]. With Python's 5 ms, each step of a connecting
#: subscriber would wait that long while the members compute their signals.
_SWITCH_INTERVAL_S = 0.0005


class FleetParameters(ParameterSet):
    """Private parameters of the fleet."""

    count = read_once(IntParameter(2, minimum=0, maximum=5000, help="number of groups"))
    prefix = read_once(
        StringParameter("Group", help="prefix of the groups' names, before 1, 2, ...")
    )

    @rule("prefix")
    def _gives_legal_names(self) -> None:
        start = self.prefix[1:] if self.prefix.startswith(("/", "~")) else self.prefix
        if not is_legal_name(f"/{start}1"):
            raise ValueError(LEGAL_NAME)


class Fleet:
    """Host of groups that look like pairs of separate nodes.

    Each group ``<prefix>1`` ... ``<prefix>N`` has the topics, parameters and services of the nodes
    ``signal_generator`` and ``process`` in that namespace. A member with invalid parameters does
    not run; the others do.

    :ROS Parameters:
        - private: see :class:`FleetParameters`
        - of each member, in ``<group>/signal_generator`` and ``<group>/process``
    """

    def __init__(self, node: Node) -> None:
        sys.setswitchinterval(_SWITCH_INTERVAL_S)
        settings = node.declare_parameters(FleetParameters).values
        groups = [f"{settings.prefix}{number}" for number in range(1, settings.count + 1)]
        # The process first, so that it receives the generator's first sample.
        members = host_all(
            node,
            [
                (name, group, member)
                for group in groups
                for name, member in (("process", Process), ("signal_generator", SignalGenerator))
            ],
        )
        rospy.loginfo("%d members in %d groups are running", len(members), len(groups))


def main() -> None:
    """Run the node until it is shut down."""
    run("fleet", Fleet)
