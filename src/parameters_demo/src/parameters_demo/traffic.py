# Pure: knows no ROS.
"""Traffic of the simulated radar: passing cars and a walking person.

The radar is at the origin and faces along x; y is to the left, z is up. Lengths are in m, angles in
rad, times in s.
"""

import math
from typing import Tuple

import numpy

#: Distances at which cars appear and disappear.
_NEAR, _FAR = 4.0, 100.0
#: Half the field of view, and the range of the radar.
VIEW, SIGHT = math.pi / 6, 80.0
#: Cars: y, z, speed along x in m/s, x at time 0, radar cross-section in dB over 1 m^2.
_CARS = numpy.array(
    [
        (-3.5, 0.2, 13.0, 10.0, 10.0),
        (-3.5, 0.4, 13.0, 55.0, 15.0),
        (-7.0, 0.2, 22.0, 30.0, 10.0),
        (-7.0, 1.1, 19.0, 85.0, 25.0),
        (3.5, 0.2, -12.0, 20.0, 10.0),
        (3.5, 0.3, -12.0, 64.0, 12.0),
        (7.0, 0.2, -25.0, 45.0, 10.0),
        (7.0, 1.2, -20.0, 95.0, 25.0),
        (10.5, 0.2, -17.0, 70.0, 8.0),
    ]
)
#: Walker: centre and radius of the circle, height, time per round, cross-section.
_CENTRE, _RADIUS, _HEIGHT, _ROUND_S, _WALKER_DB = 15.0, 5.0, -0.2, 20.0, -5.0
#: Amplitude of a cross-section of 1 m^2 at 10 m; it falls with the fourth power of the range.
_AT_10_M_DB = 60.0


def returns(time: float) -> numpy.ndarray:
    """Return the radar's targets.

    :param time: of the measurement
    :returns: 1 to 10 rows: range, azimuth, elevation, doppler velocity in m/s, which is the rate of
        change of the range, and amplitude in dB
    """
    places, speeds, sections = targets(time)
    ranges = numpy.linalg.norm(places, axis=1)
    azimuths = numpy.arctan2(places[:, 1], places[:, 0])
    elevations = numpy.arcsin(places[:, 2] / ranges)
    dopplers = (places * speeds).sum(axis=1) / ranges
    amplitudes = _AT_10_M_DB + sections - 40.0 * numpy.log10(ranges / 10.0)
    seen = numpy.stack([ranges, azimuths, elevations, dopplers, amplitudes], axis=1)
    return seen[(abs(azimuths) <= VIEW) & (ranges <= SIGHT)]


def targets(time: float) -> Tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Return position, velocity and cross-section of all moving objects; the walker comes first.

    :param time: of the measurement
    """
    angle, turning = math.tau * (time / _ROUND_S % 1.0), math.tau / _ROUND_S
    cos, sin = _RADIUS * math.cos(angle), _RADIUS * math.sin(angle)
    left, up, speed, start, sections = _CARS.T
    along = _NEAR + (start - _NEAR + speed * time) % (_FAR - _NEAR)
    still = numpy.zeros_like(speed)
    places = numpy.vstack([(_CENTRE + cos, sin, _HEIGHT), numpy.stack([along, left, up], axis=1)])
    walking = (-turning * sin, turning * cos, 0.0)
    speeds = numpy.vstack([walking, numpy.stack([speed, still, still], axis=1)])
    return places, speeds, numpy.append(_WALKER_DB, sections)
