"""Odometry: the pose estimated from the wheels' rotation, and its uncertainty.

A wheel slips a little, so its measured path has an error. The errors of successive pieces of the
path are independent: their variances add up, k^2 for each m, however the path is divided. The
propagation to the pose follows Siegwart and Nourbakhsh, Autonomous Mobile Robots, section 5.2.4.
"""

import math
import random
from typing import Tuple

from diff_drive_sim.simulation.kinematics import Pose, Wheels, chord

#: Upper triangle of a covariance: xx, xy, xt, yy, yt, tt, in m^2, m rad, rad^2.
Covariance = Tuple[float, float, float, float, float, float]
EXACT: Covariance = (0.0,) * 6

#: Half the width of a uniform distribution, in standard deviations.
_WIDTH = math.sqrt(3.0)


class Odometry:
    """Integrator of the measured paths of both wheels.

    :param pose: initial pose
    :param seed: of the noise: the same seed gives the same errors

    :ivar pose: estimated pose
    :ivar covariance: of that pose
    :ivar angles: measured rotation of the wheels since the start [rad]
    """

    def __init__(self, pose: Pose, seed: int = 0) -> None:
        self.pose = pose
        self.covariance = EXACT
        self.angles = Wheels()
        self._random = random.Random(seed)

    def roll(
        self, distance: float, turn: float, separation: float, radius: float, k: float
    ) -> None:
        """Measure an arc of at most a few cm, because the errors are linearised.

        :param distance: its true length [m]; below 0 backwards
        :param turn: true change of the heading [rad]
        :param separation: distance between the wheels [m]
        :param radius: of the wheels [m]
        :param k: standard deviation of the error of a wheel's path after 1 m [m]
        """
        if k > 0.0:
            left, right = wheel_paths(distance, turn, separation)
            self._spread(distance, turn, separation, k)
            left_error, right_error = self._error(left, k), self._error(right, k)
            distance += 0.5 * (left_error + right_error)
            turn += (right_error - left_error) / separation
        self.pose = self.pose.moved(distance, turn)
        left, right = wheel_paths(distance, turn, separation)
        self.angles = Wheels(self.angles.left + left / radius, self.angles.right + right / radius)

    def _error(self, path: float, k: float) -> float:
        """Return an error of a path, at most 1.73 standard deviations [m]."""
        return k * math.sqrt(abs(path)) * _WIDTH * self._random.uniform(-1.0, 1.0)

    def _spread(self, distance: float, turn: float, separation: float, k: float) -> None:
        """Add the errors of an arc to the covariance: F C F' + G Q G'."""
        left, right = wheel_paths(distance, turn, separation)
        direction, length = self.pose.theta + 0.5 * turn, chord(distance, turn)
        cosine, sine = math.cos(direction), math.sin(direction)
        xx, xy, xt, yy, yt, tt = self.covariance
        by_x, by_y = -length * sine, length * cosine
        xx, xy, yy = (
            xx + 2.0 * by_x * xt + by_x * by_x * tt,
            xy + by_x * yt + by_y * xt + by_x * by_y * tt,
            yy + 2.0 * by_y * yt + by_y * by_y * tt,
        )
        xt, yt = xt + by_x * tt, yt + by_y * tt
        lever = length / separation
        for path, side in ((left, -1.0), (right, 1.0)):
            variance = k * k * abs(path)
            gx = 0.5 * (cosine - side * lever * sine)
            gy = 0.5 * (sine + side * lever * cosine)
            gt = side / separation
            xx += variance * gx * gx
            xy += variance * gx * gy
            xt += variance * gx * gt
            yy += variance * gy * gy
            yt += variance * gy * gt
            tt += variance * gt * gt
        self.covariance = (xx, xy, xt, yy, yt, tt)


def wheel_paths(distance: float, turn: float, separation: float) -> Wheels:
    """Return the paths of the wheels on an arc [m].

    :param distance: its length [m]; below 0 backwards
    :param turn: change of the heading [rad]
    :param separation: distance between the wheels [m]
    """
    return Wheels(distance - 0.5 * separation * turn, distance + 0.5 * separation * turn)
