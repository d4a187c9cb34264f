"""Simulated differential-drive robot, from commands to poses; without ROS and without a clock.

A test of a controller closes the loop like this::

    robot = Robot(RobotSettings(), pose=Pose(0.0, 0.0, 0.0))
    while ...:
        robot.command(*law(robot.odometry.pose))
        robot.step(0.05)
"""

import math
from typing import Iterator, Optional, Tuple

from diff_drive_sim.simulation.kinematics import Pose, Wheels, body_speeds, wheel_speeds
from diff_drive_sim.simulation.limits import RobotSettings, between, ramp_time, saturated
from diff_drive_sim.simulation.odometry import Odometry
from diff_drive_sim.simulation.world import World

#: Step of a change of speed [s], driven with its mean speeds: the heading is exact, the position
#: has an error of third order in this step.
_RAMP_PIECE_S = 0.01
#: Longest path of a wheel for which odometry errors are linearised [m].
_NOISE_PIECE_M = 0.02
#: Turn at a wall before the robot tries to drive again [rad].
_TURN_AT_WALL_RAD = 0.05
#: Longest time simulated in one step [s]: a clock jump of years would take days.
LONGEST_STEP_S = 3600.0


class Robot:
    """State of a robot, simulated in steps of any length without loss of accuracy.

    A command applies until the next one, or until its timeout; then the robot stops. A wall stops
    its forward motion on contact, but not its turn: it drives on as soon as its way is free. Not
    thread-safe.

    :param settings: of the robot
    :param world: walls and boxes
    :param pose: initial pose
    :param seed: of the odometry noise

    :ivar pose: true pose
    :ivar wheels: speeds of the wheels [rad/s]
    :ivar odometry: estimated pose, and rotation of the wheels
    :ivar touches: whether a wall stopped it in the last step
    """

    def __init__(
        self,
        settings: RobotSettings = RobotSettings(),
        world: Optional[World] = None,
        pose: Pose = Pose(),
        seed: int = 0,
    ) -> None:
        self.settings = settings
        self.world = world or World()
        self.reset(pose, seed)

    def reset(self, pose: Pose, seed: int = 0) -> None:
        """Move the robot to a pose, at rest and without a command; restart its odometry there.

        :param pose: the pose
        :param seed: of the odometry noise
        """
        self.pose = pose
        self.wheels = Wheels()
        self.odometry = Odometry(pose, seed)
        self.touches = False
        self._is_held = False
        self._wanted = (0.0, 0.0)
        self._acts_for = math.inf

    @property
    def speeds(self) -> Tuple[float, float]:
        """The speed forward [m/s] and the rate of turn [rad/s]."""
        return body_speeds(self.wheels, *self._geometry)

    def command(self, linear: float, angular: float) -> None:
        """Set the speed; beyond its limits, the robot drives the same curve, only slower.

        :param linear: speed forward [m/s]
        :param angular: rate of turn [rad/s]
        :raises ValueError: if a speed is not finite
        """
        if not (math.isfinite(linear) and math.isfinite(angular)):
            raise ValueError(f"a command of {linear} m/s and {angular} rad/s: must be finite")
        self._wanted = (linear, angular)
        self._acts_for = self.settings.command_timeout or math.inf

    def change(self, settings: RobotSettings) -> None:
        """Change the settings; the current command continues, from now at most for the new timeout.

        :param settings: new settings
        """
        self.settings = settings
        self._acts_for = min(self._acts_for, settings.command_timeout or math.inf)

    def step(self, dt: float) -> None:
        """Advance the time.

        :param dt: duration [s]; ignored if not positive, limited to LONGEST_STEP_S
        """
        if dt <= 0.0:
            return
        self.touches = False
        acts = min(dt, self._acts_for)
        self._drive(acts)
        self._acts_for -= acts
        if self._acts_for <= 0.0:
            self._wanted, self._acts_for = (0.0, 0.0), math.inf
            self._drive(dt - acts)

    @property
    def _geometry(self) -> Tuple[float, float]:
        return self.settings.wheel_separation, self.settings.wheel_radius

    def _drive(self, dt: float) -> None:
        """Accelerate to the commanded speeds, and continue at them."""
        dt = min(dt, LONGEST_STEP_S)
        target = wheel_speeds(*saturated(*self._wanted, self.settings), *self._geometry)
        start = self.wheels
        ramp = ramp_time(start, target, self.settings.max_wheel_acceleration)
        driven = min(ramp, dt)
        for start_s, end_s in _pieces(driven, _RAMP_PIECE_S):
            self._roll(between(start, target, 0.5 * (start_s + end_s) / ramp), end_s - start_s)
        self.wheels = between(start, target, driven / ramp) if driven < ramp else target
        self._roll(self.wheels, dt - driven)
        if self._is_held:
            # The wall stops the forward motion; the turn remains.
            self.wheels = wheel_speeds(0.0, self.speeds[1], *self._geometry)

    def _roll(self, wheels: Wheels, dt: float) -> None:
        """Roll at constant speeds for a time; if a wall is in the way, only turn."""
        if dt <= 0.0:
            return
        linear, angular = body_speeds(wheels, *self._geometry)
        distance, turn = linear * dt, angular * dt
        while True:
            free = self.world.free_part(self.pose, distance, turn, self.settings.robot_radius)
            self._move(free * distance, free * turn)
            self._is_held = free < 1.0
            if not self._is_held:
                return
            self.touches = True
            distance, turn = (1.0 - free) * distance, (1.0 - free) * turn
            turned = min(1.0, _TURN_AT_WALL_RAD / abs(turn)) if turn else 1.0
            self._move(0.0, turned * turn)
            if turned == 1.0:
                return
            distance, turn = (1.0 - turned) * distance, (1.0 - turned) * turn

    def _move(self, distance: float, turn: float) -> None:
        """Drive a free arc, with errors of the wheels' measured paths."""
        self.pose = self.pose.moved(distance, turn)
        separation, radius = self._geometry
        k = self.settings.odometry_noise
        longest = abs(distance) + 0.5 * separation * abs(turn)  # path of the outer wheel
        pieces = math.ceil(longest / _NOISE_PIECE_M) if k > 0.0 else 1
        for _ in range(pieces):
            self.odometry.roll(distance / pieces, turn / pieces, separation, radius, k)


def _pieces(whole: float, longest: float) -> Iterator[Tuple[float, float]]:
    """Yield start and end of equal pieces of a time [s]; none for 0."""
    count = math.ceil(whole / longest)
    for number in range(count):
        yield whole * number / count, whole * (number + 1) / count
