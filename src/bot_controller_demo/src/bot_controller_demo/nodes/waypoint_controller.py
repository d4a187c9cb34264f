"""Waypoint controller node: drives a robot from point to point."""

from typing import List

import rospy

from bot_controller_demo.driving.driver import Driver
from bot_controller_demo.driving.goals import FARTHEST
from bot_controller_demo.driving.parameters import DrivingParameters
from bot_controller_demo.control.geometry import Goal
from bot_controller_demo.control.goal_controller import ARRIVED
from nodekit import BoolParameter, FloatParameter, ListParameter, Node, run


class WaypointControllerParameters(DrivingParameters):
    """Parameters of waypoint_controller: points and driving."""

    waypoints = ListParameter(
        [],
        element=ListParameter(
            [0.0, 0.0],
            element=FloatParameter(0.0, minimum=-FARTHEST, maximum=FARTHEST, help=""),
            min_length=2,
            max_length=3,
            help="",
        ),
        unit="m, m, rad",
        help="x and y of each point, optionally the heading; a change restarts the tour",
    )
    repeat = BoolParameter(False, help="whether to start again after the last point")

    @property
    def goals(self) -> List[Goal]:
        """Target poses, in order."""
        return [Goal(*waypoint) for waypoint in self.waypoints]


class WaypointController:
    """Drives through points; stays at the last one, or starts again.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`WaypointControllerParameters`

    For its topics see :class:`.Driver`.
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(WaypointControllerParameters, self._on_change)
        self._driver = Driver(node, self._parameters)
        self._ahead: List[Goal] = []
        self._has_driven = False
        node.create_timer(lambda: self._parameters.values.control_frequency, self._step)
        self._start()

    def _on_change(
        self, new: WaypointControllerParameters, old: WaypointControllerParameters
    ) -> None:
        if new.waypoints != old.waypoints:
            self._driver.stop()
            self._start()

    def _step(self, _elapsed: float) -> None:
        progress = self._driver.step()
        if progress is None:
            return
        if progress.phase != ARRIVED:
            self._has_driven = True
        elif self._ahead:
            self._driver.head_for(self._ahead.pop(0))
        elif self._parameters.values.repeat and self._has_driven:
            self._start()  # not if it was at all points without driving

    def _start(self) -> None:
        self._has_driven = False
        self._ahead = self._parameters.values.goals
        if self._ahead:
            self._driver.head_for(self._ahead.pop(0))
        else:
            rospy.logwarn("no waypoints: the robot stays where it is")


def main() -> None:
    """Run the node until it is shut down."""
    run("waypoint_controller", WaypointController)
