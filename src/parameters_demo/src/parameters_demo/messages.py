"""Messages of the simulated sensors."""

import math

import numpy
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import Header

from parameters_demo.picture import HEIGHT, WIDTH
from parameters_demo.room import Scanner
from parameters_demo_msgs.msg import RadarReturn, RadarTracks

#: Horizontal field of view of the camera [rad].
_VIEW = math.radians(60.0)


def image(header: Header, data: bytearray) -> Image:
    """Return a picture as a message.

    :param header: time and frame of the picture
    :param data: rgb8, as returned by :meth:`.Picture.draw`
    """
    return Image(header, HEIGHT, WIDTH, "rgb8", 0, 3 * WIDTH, data)


def camera_info(header: Header) -> CameraInfo:
    """Return the camera's calibration: no distortion, 60 degrees field of view.

    :param header: of the picture
    """
    focal_length = 0.5 * WIDTH / math.tan(0.5 * _VIEW)  # pixels
    x, y = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
    info = CameraInfo(header=header, width=WIDTH, height=HEIGHT, distortion_model="plumb_bob")
    info.D = [0.0] * 5
    info.K = [focal_length, 0.0, x, 0.0, focal_length, y, 0.0, 0.0, 1.0]
    info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.P = [focal_length, 0.0, x, 0.0, 0.0, focal_length, y, 0.0, 0.0, 0.0, 1.0, 0.0]
    return info


def laser_scan(header: Header, scanner: Scanner, ranges: numpy.ndarray, period: float) -> LaserScan:
    """Return a scan as a message; all rays have the same time.

    :param header: time and frame of the scan
    :param scanner: the lidar
    :param ranges: result of :func:`.room.scan` for it [m]
    :param period: time between scans [s]
    """
    return LaserScan(
        header=header,
        angle_min=scanner.angle_min,
        angle_max=scanner.angle_max,
        angle_increment=scanner.angle_increment,
        scan_time=period,
        range_min=scanner.range_min,
        range_max=scanner.range_max,
        ranges=ranges.tolist(),
    )


def radar_tracks(header: Header, returns: numpy.ndarray) -> RadarTracks:
    """Return the radar's targets as a message.

    :param header: time and frame of the measurement
    :param returns: result of :func:`.traffic.returns`
    """
    return RadarTracks(header, [RadarReturn(*seen) for seen in returns.tolist()])
