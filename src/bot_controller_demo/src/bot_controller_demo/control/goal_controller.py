"""Goal controller: drive to a goal, turn to its heading, stay."""

import math
from typing import NamedTuple

from bot_controller_demo.control.geometry import Errors, Goal, Pose, errors
from bot_controller_demo.control.steering import LAWS, Gains
from bot_controller_demo.control.velocities import STOP, Limits, Velocity, saturate

DRIVING, TURNING, ARRIVED = "driving", "turning", "arrived"
PHASES = (DRIVING, TURNING, ARRIVED)

#: A tolerance that was met counts as exceeded from this multiple on.
HYSTERESIS = 2.0
#: A turn keeps its direction while its error is larger than this [rad].
_KEEP_ABOVE = 0.75 * math.pi


class Tuning(NamedTuple):
    """Settings of the goal controller.

    :param law: one of :data:`.LAWS`
    :param gains: of the law
    :param limits: of the velocities
    :param linear_tolerance: distance at which the goal counts as reached [m]
    :param angular_tolerance: the same for the heading [rad]
    """

    law: str
    gains: Gains
    limits: Limits
    linear_tolerance: float
    angular_tolerance: float


class Guidance(NamedTuple):
    """Output of the goal controller.

    :param velocity: current command
    :param phase: one of :data:`PHASES`
    :param errors: between the robot and its goal
    """

    velocity: Velocity
    phase: str
    errors: Errors


class Turn:
    """Direction of a turn, kept while the error is near pi.

    There its sign would change from sample to sample, and the robot would not turn.
    """

    def __init__(self) -> None:
        self._side = 0.0

    def keep(self, error: float) -> float:
        """Return the error, or the equivalent angle in the other direction.

        :param error: between -pi and pi [rad]
        """
        if abs(error) > _KEEP_ABOVE and error * self._side < 0.0:
            return error + math.copysign(2.0 * math.pi, self._side)
        self._side = error
        return error


class GoalController:
    """Goal controller: drives to a goal, turns there, and stays.

    A robot that is pushed away from its goal drives or turns again.

    :param goal: target pose

    :ivar phase: one of :data:`PHASES`
    """

    def __init__(self, goal: Goal) -> None:
        self.goal = goal
        self.phase = DRIVING
        self._direction, self._heading = Turn(), Turn()

    def step(self, pose: Pose, tuning: Tuning) -> Guidance:
        """Return velocity, phase and errors for the current pose.

        :param pose: of the robot
        :param tuning: settings
        """
        seen = errors(pose, self.goal)
        self.phase = self._next_phase(seen, tuning)
        if self.phase == ARRIVED:
            return Guidance(STOP, self.phase, seen)
        if self.phase == TURNING:
            wanted = Velocity(0.0, tuning.gains.angular * self._heading.keep(seen.heading))
        else:
            kept = seen._replace(direction=self._direction.keep(seen.direction))
            wanted = LAWS[tuning.law](kept, tuning.gains)
        return Guidance(saturate(wanted, tuning.limits), self.phase, seen)

    def _next_phase(self, seen: Errors, tuning: Tuning) -> str:
        slack = 1.0 if self.phase == DRIVING else HYSTERESIS
        if seen.distance > slack * tuning.linear_tolerance:
            return DRIVING
        slack = HYSTERESIS if self.phase == ARRIVED else 1.0
        return TURNING if abs(seen.heading) > slack * tuning.angular_tolerance else ARRIVED
