"""The sensors: what each publishes, and how its messages are summarized."""

from typing import Any, Callable, Dict, NamedTuple

import numpy
from sensor_msgs.msg import Image, LaserScan

from parameters_demo_msgs.msg import RadarTracks


def of_image(image: Image) -> str:
    """Say how bright a picture is.

    :param image: of any encoding with a byte for each value
    """
    values = numpy.frombuffer(image.data, numpy.uint8)
    return f"brightness {values.mean():.1f}" if len(values) else "no pixels"


def of_scan(scan: LaserScan) -> str:
    """Say how far away the nearest thing in range is.

    :param scan: any
    """
    ranges = numpy.array(scan.ranges)
    ranges = ranges[(ranges >= scan.range_min) & (ranges <= scan.range_max)]
    return f"nearest {ranges.min():.2f} m" if len(ranges) else "nothing in range"


def of_tracks(tracks: RadarTracks) -> str:
    """Say how many returns there are, and when the first of them will be here.

    :param tracks: any
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
