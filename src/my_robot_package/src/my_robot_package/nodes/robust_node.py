"""Node whose components may fail at startup."""

import sys
import time
from typing import Callable

import rospy

from nodekit import FloatParameter, IntParameter, Node, ParameterSet, read_once, run


class RobustNodeParameters(ParameterSet):
    """Parameters of robust_node."""

    failures = read_once(
        IntParameter(1, minimum=0, help="number of failures of the sensors at startup")
    )
    attempts = read_once(
        IntParameter(3, minimum=1, maximum=100, help="number of attempts to start")
    )
    recovery_time = read_once(
        FloatParameter(
            0.5,
            minimum=0.0,
            maximum=3600.0,
            unit="s",
            help="duration of the recovery procedure",
        )
    )


class SetupFailed(Exception):
    """Set-up that failed at each attempt; the text gives the cause."""


def set_up(attempt: Callable[[], None], recover: Callable[[Exception], None], attempts: int) -> int:
    """Repeat an attempt until it succeeds, with a recovery after each failure but the last.

    :param attempt: may raise an exception
    :param recover: called with the exception, before the next attempt
    :param attempts: most attempts; at least 1
    :returns: number of attempts
    :raises SetupFailed: if all attempts failed
    """
    for number in range(1, attempts + 1):
        try:
            attempt()
            return number
        except Exception as error:  # hardware fails in many ways
            if number == attempts:
                raise SetupFailed(f"failed {attempts} times, the last time: {error}") from error
            recover(error)
    raise ValueError(f"attempts: refused {attempts}: must be a whole number of at least 1")


class RobustNode:
    """Starts its sensors and actuators; after a failure it recovers and tries again.

    After ``~attempts`` failures it logs the cause and exits with status 1. At shutdown it stops the
    actuators first.

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
        """Start all components."""
        self.initialize_sensors()
        self.initialize_actuators()

    def initialize_sensors(self) -> None:
        """Start the sensors, which fail ``~failures`` times.

        :raises OSError: if they fail
        """
        if self._failures_left:
            self._failures_left -= 1
            raise OSError("no answer from the sensors")

    def initialize_actuators(self) -> None:
        """Start the actuators."""

    def recovery_procedure(self, error: Exception) -> None:
        """Bring all components back to a state from which they can be started."""
        rospy.logerr("Component initialization failed: %s", error)
        rospy.logwarn("Attempting recovery procedure...")
        time.sleep(self._settings.recovery_time)

    def shut_down(self) -> None:
        """Stop the actuators."""
        rospy.loginfo("Shutting down gracefully...")


def main() -> None:
    """Run the node until it is shut down."""
    run("robust_node", RobustNode)
