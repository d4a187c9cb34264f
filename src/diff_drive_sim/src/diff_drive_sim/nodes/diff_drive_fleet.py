"""Fleet node: many robots in one process of the machine."""

import copy
import math
from functools import partial
from typing import Any, Dict

import rospy

from diff_drive_sim.nodes.diff_drive import DiffDrive
from diff_drive_sim.robot_parameters import RobotParameters
from nodekit import (
    FloatParameter,
    IntParameter,
    Names,
    Node,
    StringParameter,
    host_all,
    read_once,
    rule,
    run,
)


class FleetParameters(RobotParameters):
    """Number of robots, and their initial settings."""

    count = IntParameter(2, minimum=0, maximum=1000, help="number of robots")
    prefix = StringParameter("robot", help="prefix of the robots' names, before 1, 2, ...")
    spacing = FloatParameter(
        1.0,
        minimum=0.0,
        maximum=1000.0,
        unit="m",
        help="distance of their initial positions, in a square",
    )

    @property
    def side(self) -> int:
        """Number of robots in a row."""
        return math.ceil(math.sqrt(self.count))

    def defaults(self, number: int) -> Dict[str, Any]:
        """Return the default parameters of a robot, by name.

        :param number: of the robot, from 0
        """
        shared = {name: getattr(self, name) for name in RobotParameters.declared}
        return {
            **shared,
            "frame_prefix": f"{self.frame_prefix}{self.prefix}{number + 1}/",
            "initial_x": self.initial_x + self.spacing * (number % self.side),
            "initial_y": self.initial_y + self.spacing * (number // self.side),
            "seed": self.seed + number,
        }

    @rule("prefix")
    def _gives_legal_names(self) -> None:
        Names.hosted(f"{self.prefix}1", "diff_drive")

    @rule("count", "spacing", "initial_x", "initial_y", "seed")
    def _suits_each_robot(self) -> None:
        if self.count:
            for number in (self.side - 1, self.count - 1):  # furthest ahead, and to the left
                RobotParameters(**self.defaults(number))


# Parameters that a single robot can change at run time are read once here: they are only the
# defaults of each robot's own parameters.
for _name, _parameter in FleetParameters.declared.items():
    FleetParameters.declared[_name] = read_once(copy.copy(_parameter))


class DiffDriveFleet:
    """Host of robots that look like separate nodes.

    Robot ``<prefix>1`` and so on has the topics, services and parameters of the node ``diff_drive``
    in a namespace of that name, which is also the prefix of its frames. The robots do not see each
    other.

    :ROS Parameters:
        - private: see :class:`FleetParameters`
        - of each robot, in ``<robot>/diff_drive``; the fleet's parameters are the defaults
    """

    def __init__(self, node: Node) -> None:
        fleet = node.declare_parameters(FleetParameters).values
        members = []
        for number in range(fleet.count):
            own = RobotParameters.with_defaults(**fleet.defaults(number))
            robot = partial(DiffDrive, declaration=own)
            members.append(("diff_drive", f"{fleet.prefix}{number + 1}", robot))
        rospy.loginfo("%d robots are up", len(host_all(node, members)))


def main() -> None:
    """Run the node until it is shut down."""
    run("diff_drive_fleet", DiffDriveFleet)
