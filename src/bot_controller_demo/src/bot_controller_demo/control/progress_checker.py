"""Progress of a robot towards its goal."""

import math

from bot_controller_demo.control.geometry import Errors
from bot_controller_demo.control.goal_controller import TURNING

#: The phase of a goal that is given up. Progress has no constant for it: one more would make it
#: another message, which the nodes of before do not know.
GIVEN_UP = "given_up"

#: An error that falls to this part of its least counts as progress: a slow robot makes it too, and
#: what odometry's noise makes of a robot at rest does not for long. Of a distance this many metres
#: are enough: 1 % of a long way takes long.
_CLOSER, _CLOSER_BY = 0.99, 0.05
#: Below this an angle is not followed any further, rad.
_LEAST_ANGLE = 0.01


class ProgressChecker:
    """Time without progress towards a goal.

    Progress is a distance below all before, or a turn towards where the robot is to drive or to
    look.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Restart for a new goal, or for a robot that was stopped for another reason."""
        self._phase = ""
        self._distance = self._angle = math.inf
        self._since = math.inf

    def lasted(self, phase: str, seen: Errors, now: float) -> float:
        """Return the time without progress [s].

        :param phase: of the goal controller
        :param seen: between the robot and its goal
        :param now: s
        """
        angle = abs(seen.heading if phase == TURNING else seen.direction)
        is_closer = seen.distance < max(_CLOSER * self._distance, self._distance - _CLOSER_BY)
        if phase != self._phase or is_closer:
            self._distance, self._angle = seen.distance, angle
        elif max(angle, _LEAST_ANGLE) < _CLOSER * self._angle:
            self._angle = max(angle, _LEAST_ANGLE)
        elif now >= self._since:
            return now - self._since
        self._phase, self._since = phase, now
        return 0.0
