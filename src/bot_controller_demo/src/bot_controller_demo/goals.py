"""Goals as messages give them."""

import math
from typing import Optional

from geometry_msgs.msg import PoseStamped

from bot_controller_demo.geometry import Goal, heading_of


class GoalRefused(ValueError):
    """A goal that makes no sense; the text says why."""


def goal_of(message: PoseStamped, frame: Optional[str]) -> Goal:
    """Return the goal that a message means.

    :param message: a pose; without a frame, it is in that of the odometry
    :param frame: of the odometry, None where there was none yet
    :raises GoalRefused: if it is in another frame, or not finite
    """
    named = message.header.frame_id.lstrip("/")
    if named and frame is None:
        raise GoalRefused(f"frame_id '{named}': must be empty while there is no odometry")
    if named and frame is not None and named != frame.lstrip("/"):
        raise GoalRefused(f"frame_id '{named}': must be '{frame}', that of the odometry, or empty")
    position, turn = message.pose.position, message.pose.orientation
    parts = (turn.x, turn.y, turn.z, turn.w)
    if not any(parts):
        raise GoalRefused(
            "orientation is 0 in all parts: must be a quaternion, w = 1 to look ahead"
        )
    return finite(Goal(position.x, position.y, heading_of(*parts)))


def finite(goal: Goal) -> Goal:
    """Return a goal.

    :param goal: to be judged
    :raises GoalRefused: if it is not finite
    """
    if not all(map(math.isfinite, (goal.x, goal.y, goal.theta or 0.0))):
        raise GoalRefused(f"{goal}: must be finite")
    return goal
