"""Single messages of a recording, found by the times at which the player outputs them."""

from pathlib import Path
from typing import Dict, List
from unittest import mock

import genpy
import pytest
import rosbag
from bags import BEGIN
from std_msgs.msg import Int32

from topic_scope.bag import message_at
from topic_scope.bag.message_at import MessageFinder
from topic_scope.bag.player import BagPlayer
from topic_scope.bag.recording import BagError
from topic_scope.bag.ros1_recording import Ros1Recording

#: Time of recording of each message [ms]: of a simulation, whose clock stands still between steps.
RECORDED = [0, 10, 10, 10, 10, 20, 30, 30, 500, 500, 500, 500, 500]


@pytest.fixture(scope="module")
def path(tmp_path_factory: "pytest.TempPathFactory") -> str:
    made = str(tmp_path_factory.mktemp("bags") / "x.bag")
    with rosbag.Bag(made, "w", chunk_threshold=60) as file:
        for number, time in enumerate(RECORDED):
            for topic in ("/a", "/b"):
                message = Int32(number + (100 if topic == "/b" else 0))
                file.write(topic, message, genpy.Time(0, BEGIN + time * 10**6))
    return made


def played(path: str, topic: str) -> Dict[int, bytes]:
    """Return all messages of a topic, by the times at which the player outputs them."""
    found: Dict[int, bytes] = {}
    with Ros1Recording(path) as bag:
        player = BagPlayer(bag, 10.0, lambda: 0.0)
        player.want([topic])
        player.seek(player.end)
        while player.is_loading or not found:
            player.now()
            for batch in player.subscriptions()[topic].drain():
                found.update(zip(batch.times, batch.messages))
    return found


@pytest.mark.parametrize("topic", ["/a", "/b"])
def test_message_is_that_of_the_player(path: str, topic: str) -> None:
    finder, expected = MessageFinder(path), played(path, topic)
    assert len(expected) == len(RECORDED)
    with mock.patch.object(message_at, "open_bag", side_effect=message_at.open_bag) as opened:
        found: List[object] = [finder.find(topic, time) for time in expected]
    assert found == list(expected.values()) and opened.call_count == 1


def test_time_or_topic_without_a_message_has_none(path: str) -> None:
    finder = MessageFinder(path)
    assert finder.find("/a", BEGIN - 1) is None
    assert finder.find("/a", BEGIN + 10**9) is None
    assert finder.find("/c", BEGIN) is None


def test_missing_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(BagError):
        MessageFinder(str(tmp_path / "none.bag")).find("/a", BEGIN)
