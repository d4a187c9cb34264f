"""Commands of another type are ignored, with one warning per publisher."""

import io
from typing import Any, List

import pytest
import rospy
from geometry_msgs.msg import Twist, TwistStamped

from diff_drive_sim.messages.command_topic import any_type_as, decoder


def received(message: Any, sender: str) -> Any:
    """Return a message as a subscription of any type gets it."""
    raw, buffer = any_type_as(Twist)(), io.BytesIO()
    message.serialize(buffer)
    raw.deserialize(buffer.getvalue())
    raw._connection_header = {"topic": "/cmd_vel", "type": message._type, "callerid": sender}
    return raw


def test_publisher_of_wrong_type_causes_one_warning(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: lines.append(text % values))
    decode = decoder(Twist, "change it")
    twist = Twist()
    twist.linear.x = 0.5
    for sender in ("/one", "/one", "/other", "/one"):
        assert decode(received(TwistStamped(), sender)) is None
    assert decode(received(twist, "/one")) == twist
    assert lines == [
        f"/cmd_vel: ignoring the messages of {sender}: they are geometry_msgs/TwistStamped, "
        "not geometry_msgs/Twist; change it"
        for sender in ("/one", "/other")
    ]
