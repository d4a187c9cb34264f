"""Progress of a robot towards its goal."""

import math

from bot_controller_demo.control.geometry import Errors
from bot_controller_demo.control.goal_controller import TURNING

#: Phase of a goal that is given up. Progress.msg has no constant for it: a new one would change its
#: md5sum, and older nodes could not connect.
GIVEN_UP = "given_up"

#: An error that falls to this fraction of its minimum counts as progress: a slow robot achieves it,
#: and odometry noise of a robot at rest does not for long. For a distance, this many metres also
#: count, because 1 % of a long way takes long.
_CLOSER, _CLOSER_BY = 0.99, 0.05
#: Angles below this are not tracked further [rad].
_LEAST_ANGLE = 0.01


class ProgressChecker:
    """Time without progress towards a goal.

    Progress is a new minimum of the distance, or a turn towards the goal or its heading.
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
        :param seen: errors between the robot and its goal
        :param now: time [s]
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
