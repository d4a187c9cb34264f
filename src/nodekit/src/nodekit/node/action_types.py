"""Message classes of an action (goal, result, feedback), and the exceptions of goals."""

import io
from typing import Any, NamedTuple

import genpy
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from std_msgs.msg import Header

from nodekit.actions.goal_states import GoalState
from nodekit.argument_checks import check_action_class


class GoalError(rospy.ROSException):
    """Error of a goal; the text names the action and the reason."""


class GoalTimeout(GoalError):
    """Error of a goal that its server does not answer in time."""


class GoalLost(GoalError):
    """Error of a goal whose server has gone, or does not list it any longer."""


class GoalRejected(GoalError):
    """Error that a goal callback raises to reject a goal, with the reason for the client."""


class ActionMessages(NamedTuple):
    """Message classes of an action.

    :param action_goal: message of the topic ``goal``
    :param action_result: message of the topic ``result``
    :param action_feedback: message of the topic ``feedback``
    :param goal: the goal in it
    :param result: the result in it
    :param feedback: the feedback in it
    """

    action_goal: Any
    action_result: Any
    action_feedback: Any
    goal: Any
    result: Any
    feedback: Any


def messages_of(action_class: Any, name: str) -> ActionMessages:
    """Return the message classes of an action.

    :param action_class: action class, such as ``FibonacciAction``
    :param name: the action, for the error
    :raises TypeError: if it is not an action class
    """
    check_action_class(action_class, name)
    action = action_class()
    parts = (action.action_goal, action.action_result, action.action_feedback)
    inner = (parts[0].goal, parts[1].result, parts[2].feedback)
    return ActionMessages(*map(type, parts), *map(type, inner))


def check_message(message: Any, expected: Any, what: str) -> None:
    """Check a goal, a result or a feedback of a user, at the user's line.

    :param message: the message
    :param expected: its message class
    :param what: names it in the error
    :raises TypeError: if it is of another class, or the value of a field does not fit its type
    """
    if type(message) is not expected:
        raise TypeError(f"{what}: refused {message!r:.80}: must be a {expected.__name__}")
    try:
        message.serialize(io.BytesIO())
    except genpy.SerializationError as error:
        raise TypeError(f"{what}: refused: {error}") from None


def header_now() -> Header:
    """Return a header with the present ROS time."""
    return Header(stamp=rospy.Time.now())


def status_message(id: str, stamp: int, state: GoalState, text: str) -> GoalStatus:
    """Return the status of a goal as a message.

    :param id: its id
    :param stamp: ROS time at which it was sent [ns]
    :param state: its state
    :param text: the server's comment on the state
    """
    return GoalStatus(GoalID(rospy.Time(*divmod(stamp, 10**9)), id), int(state), text)
