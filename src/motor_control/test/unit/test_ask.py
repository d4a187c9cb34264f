"""What is made of a motor's answer, and of none."""

from typing import Callable

import pytest
import rospy
from rospy.exceptions import TransportTerminated

from motor_control.motor_enabler import ask
from motor_control_msgs.srv import SetProcessBoolResponse


def failing(error: Exception) -> Callable[[bool], SetProcessBoolResponse]:
    """Return a service whose call raises an error."""

    def call(enable: bool) -> SetProcessBoolResponse:
        raise error

    return call


@pytest.mark.parametrize("success, message", [(True, "enabled"), (False, "shutting down")])
def test_answer_is_passed_on(success: bool, message: str) -> None:
    asked = []

    def call(enable: bool) -> SetProcessBoolResponse:
        asked.append(enable)
        return SetProcessBoolResponse(success, message)

    assert ask(call) == (success, message)
    assert asked == [True]


@pytest.mark.parametrize(
    "error",
    [
        rospy.ServiceException("no motor"),
        rospy.ROSInterruptException("no motor"),
        # What rospy raises when the motor dies between connection and request.
        TransportTerminated("no motor"),
        ConnectionResetError("no motor"),
    ],
)
def test_failure_of_any_kind_is_an_answer_too(error: Exception) -> None:
    assert ask(failing(error)) == (False, "no motor")


def test_failure_without_words_is_told_by_its_kind() -> None:
    assert ask(failing(TimeoutError())) == (False, "TimeoutError")
