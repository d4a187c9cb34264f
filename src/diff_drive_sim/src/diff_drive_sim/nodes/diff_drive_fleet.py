"""Many robots in one process of the machine."""

import copy
import math
from functools import partial

import rospy

from diff_drive_sim.nodes.diff_drive import DiffDrive
from diff_drive_sim.robot_parameters import RobotParameters
from nodekit import FloatParameter, IntParameter, Node, StringParameter, host_all, read_once, run


class FleetParameters(RobotParameters):
    """How many robots there are, and what each of them starts from."""

    count = IntParameter(2, minimum=0, maximum=1000, help="number of robots")
    prefix = StringParameter("robot", help="prefix of the robots' names, before 1, 2, ...")
    spacing = FloatParameter(
        1.0, minimum=0.0, maximum=1000.0, unit="m", help="how far apart they start, in a square"
    )


# Here also what a robot follows live is read once: each robot has its own, of which these are the
# defaults.
for _name, _parameter in FleetParameters.declared.items():
    FleetParameters.declared[_name] = read_once(copy.copy(_parameter))


class DiffDriveFleet:
    """Hosts robots that look like as many separate nodes.

    Robot ``<prefix>1`` and so on has all that the node ``diff_drive`` would have in a namespace of
    that name, which is also the prefix of its frames. The robots do not see each other.

    :ROS Parameters:
        - those of :class:`FleetParameters`, private
        - of each robot, in ``<robot>/diff_drive``, where those of the fleet are the defaults
    """

    def __init__(self, node: Node) -> None:
        fleet = node.parameters(FleetParameters).values
        shared = {name: getattr(fleet, name) for name in RobotParameters.declared}
        side = math.ceil(math.sqrt(fleet.count))
        members = []
        for number in range(fleet.count):
            name = f"{fleet.prefix}{number + 1}"
            own = RobotParameters.with_defaults(
                **{
                    **shared,
                    "frame_prefix": f"{fleet.frame_prefix}{name}/",
                    "initial_x": fleet.initial_x + fleet.spacing * (number % side),
                    "initial_y": fleet.initial_y + fleet.spacing * (number // side),
                    "seed": fleet.seed + number,
                }
            )
            members.append(("diff_drive", name, partial(DiffDrive, declaration=own)))
        rospy.loginfo("%d robots are up", len(host_all(node, members)))


def main() -> None:
    """Run the node until it is shut down."""
    run("diff_drive_fleet", DiffDriveFleet)
