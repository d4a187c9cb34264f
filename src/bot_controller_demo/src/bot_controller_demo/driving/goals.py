"""Conversion and validation of goals in messages."""

from typing import Optional

from geometry_msgs.msg import PoseStamped

from bot_controller_demo.control.geometry import Goal, heading_of

#: Largest coordinate [m] and heading [rad], as in the parameters. From 1e308 on, errors and
#: velocities overflow.
FARTHEST = 1e6


class GoalRefused(ValueError):
    """An invalid goal; the text gives the reason."""


def goal_of(message: PoseStamped, frame: Optional[str]) -> Goal:
    """Return the goal in a message.

    :param message: a pose; without a frame, it is in the odometry's frame
    :param frame: of the odometry, None before the first odometry
    :raises GoalRefused: if it is in another frame, not finite, or too far away
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
            "orientation is 0 in all parts: must be a quaternion, such as w = 1 for heading 0"
        )
    return allowed(Goal(position.x, position.y, heading_of(*parts)))


def allowed(goal: Goal) -> Goal:
    """Return a goal if it is valid.

    :param goal: the goal
    :raises GoalRefused: if it is not finite, or too far away
    """
    if not all(abs(part) <= FARTHEST for part in (goal.x, goal.y, goal.theta or 0.0)):
        raise GoalRefused(f"{goal}: each must be in [-1e6, 1e6]")
    return goal
