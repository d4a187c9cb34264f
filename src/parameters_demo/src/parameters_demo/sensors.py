"""Sensors: their message types and summaries of their messages."""

from typing import Any, Callable, Dict, NamedTuple

import numpy
from sensor_msgs.msg import Image, LaserScan

from parameters_demo_msgs.msg import RadarTracks


def of_image(image: Image) -> str:
    """Return the brightness of an image, as text.

    :param image: of any encoding with a byte per value
    """
    values = numpy.frombuffer(image.data, numpy.uint8)
    return f"brightness {values.mean():.1f}" if len(values) else "no pixels"


def of_scan(scan: LaserScan) -> str:
    """Return the nearest distance in range, as text.

    :param scan: any scan
    """
    ranges = numpy.array(scan.ranges)
    ranges = ranges[(ranges >= scan.range_min) & (ranges <= scan.range_max)]
    return f"nearest {ranges.min():.2f} m" if len(ranges) else "nothing in range"


def of_tracks(tracks: RadarTracks) -> str:
    """Return the number of targets, and when the first will arrive, as text.

    :param tracks: any tracks
    """
    nearing = [one for one in tracks.returns if one.doppler_velocity < 0.0]
    times = [one.range / -one.doppler_velocity for one in nearing]
    first = f", first here in {min(times):.1f} s" if times else ""
    return f"{len(tracks.returns)} returns{first}"


class Sensor(NamedTuple):
    """Message of a sensor, and a function that summarizes it."""

    topic: str
    message: type
    summarize: Callable[[Any], str]


SENSORS: Dict[str, Sensor] = {
    "radar": Sensor("radar/tracks", RadarTracks, of_tracks),
    "camera": Sensor("camera/image_color", Image, of_image),
    "lidar": Sensor("lidar/points", LaserScan, of_scan),
}
