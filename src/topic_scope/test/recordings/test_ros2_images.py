"""Images of ROS 2 recordings, by the times at which the player outputs them."""

from typing import Any, Dict

import numpy
import pytest
import written

from topic_scope.bag.message_at import MessageFinder
from topic_scope.bag.opening import open_bag
from topic_scope.bag.player import BagPlayer
from topic_scope.images.shown_image import ShownImage, shown_image
from topic_scope.messages.message_layout import parse

JPEG = b"\xff\xd8\xff and more"


@pytest.fixture(scope="module", params=["MCAP", "SQLITE3"])
def path(request: Any, tmp_path_factory: Any) -> str:
    """Write ten images and ten files, two at each time."""
    types = written.store().types
    image, file = types["sensor_msgs/msg/Image"], types["sensor_msgs/msg/CompressedImage"]
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    sent = []
    for index in range(10):
        head = header(stamp(5, index), "camera")
        data = numpy.full(6, index, numpy.uint8)
        raw = image(head, 1, 2, "rgb8", 0, 6, data)
        packed = file(head, "jpeg", numpy.frombuffer(JPEG + bytes([index]), numpy.uint8))
        time = index // 2 * 10**8
        sent.append(("/raw", "sensor_msgs/msg/Image", raw, time))
        sent.append(("/packed", "sensor_msgs/msg/CompressedImage", packed, time))
    return written.write(tmp_path_factory.mktemp("bags") / "run", sent, request.param)


@pytest.mark.parametrize("topic", ["/raw", "/packed"])
def test_images_of_a_recording_are_found_and_shown(path: str, topic: str) -> None:
    finder, found = MessageFinder(path), []
    played: Dict[int, bytes] = {}
    with open_bag(path) as bag:
        (header,) = [one.header for one in bag.connections.values() if one.topic == topic]
        layout = parse(header["type"], header["message_definition"])
        player = BagPlayer(bag, 10.0, lambda: 0.0)
        player.want([topic])
        player.seek(player.end)
        while player.is_loading or not played:
            player.now()
            for batch in player.subscriptions()[topic].drain():
                played.update(zip(batch.times, batch.messages))
    for time, message in played.items():
        assert finder.find(topic, time) == message
        found.append(shown_image(layout, message))
    if topic == "/packed":
        expected = [
            ShownImage("image/jpeg", JPEG + bytes([index]), "jpeg, 0.013 kB") for index in range(10)
        ]
        assert found == expected
    else:
        assert [one.text for one in found] == ["2 × 1, rgb8"] * 10
        assert len({one.data for one in found}) == 10
