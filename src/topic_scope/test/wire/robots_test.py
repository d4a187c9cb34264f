"""Base of the tests of robots that pages show and drive."""

import time
from typing import Any, List

from geometry_msgs.msg import Twist
from wire.client import Client
from wire.robot import Command, Robot
from wire.signals_test import SignalsTest

from nodekit.testing.waiting import wait_until


class RobotsTest(SignalsTest):
    """Test with robots."""

    def robot(self, space: str, kind: Any = Twist) -> Robot:
        """Return a robot in a namespace."""
        robot = Robot(space, kind)
        self.addCleanup(robot.close)
        return robot

    def driver(self, topic: str) -> Client:
        """Open a page that drives a robot."""
        page = self.page()
        page.send("robots", on=True)
        page.wait_for("targets", lambda reply: topic in reply["commands"])
        page.send("steer", topic=topic)
        page.wait_for("steering", lambda reply: reply["topic"] == topic)
        return page

    def drive(self, *pages: Client) -> None:
        """Send commands like a page while a key is held."""
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            for page in pages:
                page.send("drive", speed=0.2, turn=0.5, sent=time.monotonic())
            time.sleep(0.05)

    def stopped(self, robot: Robot) -> List[Command]:
        """Wait until a robot was commanded to stop, and return its commands."""
        wait_until(
            lambda: robot.commands and robot.commands[-1].speed == 0.0,
            lambda: f"the last commands were {robot.commands[-3:]}",
        )
        return list(robot.commands)
