"""A node whose parts may fail when it starts."""

import sys
import time
from typing import Callable

import rospy

from nodekit import FloatParameter, IntParameter, Node, ParameterSet, read_once, run


class RobustNodeParameters(ParameterSet):
    """Parameters of robust_node."""

    failures = read_once(IntParameter(1, minimum=0, help="how often the sensors fail to start"))
    attempts = read_once(IntParameter(3, minimum=1, maximum=100, help="how often to try to start"))
    recovery_time = read_once(
        FloatParameter(
            0.5,
            minimum=0.0,
            maximum=3600.0,
            unit="s",
            help="time that the recovery procedure takes",
        )
    )


class SetupFailed(Exception):
    """A set-up that failed at each attempt; the text says why."""


def set_up(attempt: Callable[[], None], recover: Callable[[Exception], None], attempts: int) -> int:
    """Try until it succeeds, and recover after each failure but the last.

    :param attempt: what may fail
    :param recover: called with what it raised, before it is tried again
    :param attempts: how often to try at most; at least 1
    :returns: how often it was tried
    :raises SetupFailed: if it failed each time
    """
    for number in range(1, attempts + 1):
        try:
            attempt()
            return number
        except Exception as error:  # of any kind: hardware fails in many ways
            if number == attempts:
                raise SetupFailed(f"failed {attempts} times, the last time: {error}") from error
            recover(error)
    raise ValueError(f"attempts: refused {attempts}: must be a whole number of at least 1")


class RobustNode:
    """Starts its sensors and actuators, recovers where that fails, and tries again.

    After ``~attempts`` failures it gives up: it says why, and its exit status is 1. When it is
    ended, it stops the actuators first.

    :ROS Parameters:
        - private: see :class:`RobustNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(RobustNodeParameters).values
        self._failures_left = self._settings.failures
        try:
            tries = set_up(self.setup_components, self.recovery_procedure, self._settings.attempts)
        except SetupFailed as error:
            rospy.logfatal("Failed to initialize components: %s", error)
            sys.exit(1)
        rospy.loginfo("Components initialized at attempt %d", tries)
        node.on_shutdown(self.shut_down)

    def setup_components(self) -> None:
        """Start everything."""
        self.initialize_sensors()
        self.initialize_actuators()

    def initialize_sensors(self) -> None:
        """Start the sensors, which fail as often as ``~failures`` says.

        :raises OSError: if they fail
        """
        if self._failures_left:
            self._failures_left -= 1
            raise OSError("no answer from the sensors")

    def initialize_actuators(self) -> None:
        """Start the actuators."""

    def recovery_procedure(self, error: Exception) -> None:
        """Bring all parts back to a state from which they can be started."""
        rospy.logerr("Component initialization failed: %s", error)
        rospy.logwarn("Attempting recovery procedure...")
        time.sleep(self._settings.recovery_time)

    def shut_down(self) -> None:
        """Stop the actuators."""
        rospy.loginfo("Shutting down gracefully...")


def main() -> None:
    """Run the node until it is shut down."""
    run("robust_node", RobustNode)
