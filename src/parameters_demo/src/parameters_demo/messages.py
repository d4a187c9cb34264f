"""The messages of the sensors, made of what they see."""

import math

import numpy
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import Header

from parameters_demo.picture import HEIGHT, WIDTH
from parameters_demo.room import Scanner
from parameters_demo_msgs.msg import RadarReturn, RadarTracks

#: What the camera sees from side to side, rad.
_VIEW = math.radians(60.0)


def image(header: Header, data: bytearray) -> Image:
    """Return a picture as a message.

    :param header: when and by whom it was taken
    :param data: rgb8, as :meth:`.Picture.draw` returns it
    """
    return Image(header, HEIGHT, WIDTH, "rgb8", 0, 3 * WIDTH, data)


def camera_info(header: Header) -> CameraInfo:
    """Return what camera took a picture: one without distortion, that sees 60 degrees.

    :param header: that of the picture
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
    """Return a scan as a message; all rays of it are of one moment.

    :param header: that moment, and the lidar's frame
    :param scanner: how the lidar looks
    :param ranges: what :func:`.room.scan` returns for it, m
    :param period: time between scans, s
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
    """Return what a radar sees as a message.

    :param header: when, and the radar's frame
    :param returns: what :func:`.traffic.returns` returns
    """
    return RadarTracks(header, [RadarReturn(*seen) for seen in returns.tolist()])
