"""Messages of each sensor, and their summaries."""

import io
import math

import numpy
import pytest
import rospy
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Header

from parameters_demo.messages import camera_info, image, laser_scan, radar_tracks
from parameters_demo.picture import HEIGHT, WIDTH
from parameters_demo.room import MODELS, scan
from parameters_demo.sensors import SENSORS, of_image, of_scan, of_tracks
from parameters_demo_msgs.msg import RadarReturn, RadarTracks

HEADER = Header(stamp=rospy.Time(5), frame_id="somewhere")


def test_brightness_is_mean_of_bytes() -> None:
    assert of_image(Image(data=bytes([0, 100, 200]))) == "brightness 100.0"
    assert of_image(Image()) == "no pixels"


def test_the_nearest_thing_is_in_range() -> None:
    ranges = [0.05, -math.inf, math.nan, 1.234, 3.0, math.inf]
    assert of_scan(LaserScan(range_min=0.1, range_max=2.0, ranges=ranges)) == "nearest 1.23 m"
    assert of_scan(LaserScan(range_min=0.1, range_max=1.0, ranges=ranges)) == "nothing in range"
    assert of_scan(LaserScan()) == "nothing in range"


def test_first_arrival_may_not_be_nearest_target() -> None:
    far, near = RadarReturn(range=50.0, doppler_velocity=-25.0), RadarReturn(range=10.0)
    slow = RadarReturn(range=20.0, doppler_velocity=-1.0)
    assert of_tracks(RadarTracks(returns=[near, far, slow])) == "3 returns, first here in 2.0 s"
    assert of_tracks(RadarTracks(returns=[near])) == "1 returns"
    assert of_tracks(RadarTracks()) == "0 returns"


def test_each_sensor_has_a_summary() -> None:
    for sensor in SENSORS.values():
        assert sensor.summarize(sensor.message())


def test_an_image_can_be_sent_without_a_copy() -> None:
    data = bytearray(range(256)) * (3 * WIDTH * HEIGHT // 256)
    message = image(HEADER, data)
    assert message.data is data
    assert (message.width, message.height, message.step) == (WIDTH, HEIGHT, 3 * WIDTH)
    buffer = io.BytesIO()
    message.serialize(buffer)
    back = Image().deserialize(buffer.getvalue())
    assert back.data == bytes(data) and back.encoding == "rgb8" and back.header == HEADER


def test_the_camera_sees_60_degrees() -> None:
    info = camera_info(HEADER)
    focal_length, x, y = info.K[0], info.K[2], info.K[5]
    edges = [math.degrees(math.atan((edge - x) / focal_length)) for edge in (-0.5, WIDTH - 0.5)]
    assert edges == pytest.approx([-30.0, 30.0])
    # Square pixels, the centre between those in the middle, and a picture that is straight already.
    assert info.K[4] == focal_length and y == (HEIGHT - 1) / 2.0
    rows = [list(info.K[row : row + 3]) for row in (0, 3, 6)]
    assert [list(info.P[row : row + 4]) for row in (0, 4, 8)] == [row + [0.0] for row in rows]
    assert rows[0][1] == rows[1][0] == 0.0 and rows[2] == [0.0, 0.0, 1.0]
    assert info.header == HEADER


def test_a_scan_says_how_it_was_made() -> None:
    scanner = MODELS["OS1"]
    found = scan(scanner, 5.0)
    message = laser_scan(HEADER, scanner, found, 0.05)
    assert (message.scan_time, message.time_increment) == (0.05, 0.0)
    assert message.ranges == list(found)
    last = message.angle_min + (len(message.ranges) - 1) * message.angle_increment
    assert last == pytest.approx(message.angle_max)


def test_tracks_have_a_return_for_each_row() -> None:
    rows = numpy.array([[1.0, 2.0, 3.0, 4.0, 5.0], [6.0, 7.0, 8.0, 9.0, 10.0]])
    tracks = radar_tracks(HEADER, rows)
    assert tracks.returns[1] == RadarReturn(6.0, 7.0, 8.0, 9.0, 10.0)
    assert len(tracks.returns) == 2 and tracks.header == HEADER
