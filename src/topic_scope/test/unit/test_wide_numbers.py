"""Integers that a float cannot represent are reported as rounded."""

import struct
from pathlib import Path
from typing import List

import genpy
import pytest
import rosbag
from bags import BEGIN, nanoseconds, write_bag
from std_msgs.msg import Int32, Int64, UInt64
from test_recorder import FakeSource, header, recording

from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.ros1_recording import Ros1Recording
from topic_scope.sampling.message_source import Batch

CASES = pytest.mark.parametrize(
    "message_class, values, step",
    [
        (Int64, [2**53 - 1, 2**53 - 3], 1),
        (Int64, [-(2**62), 5], 1024),
        (Int64, [2**53 + 1, 5], 2),
        (UInt64, [2**64 - 2, 2**64 - 1], 4096),
        (Int32, [2**31 - 1, 0], 1),
    ],
)


def text(step: int) -> object:
    """Return the text about the rounding."""
    return None if step == 1 else f"whole numbers beyond 2**53: rounded to multiples of {step}"


@CASES
def test_rounded_whole_numbers_are_named_on_the_page(
    message_class: type, values: List[int], step: int
) -> None:
    source = FakeSource()
    made = recording(source, "/a/data", "=2 * /a/data")
    code = {Int64: "<q", UInt64: "<Q", Int32: "<i"}[message_class]
    times = nanoseconds(source.time + 0.01 * index for index in range(len(values)))
    data = [struct.pack(code, value) for value in values]
    source.topics["/a"].batches.append(Batch(header(message_class), times, data))
    made.update()
    smaller = Batch(header(message_class), nanoseconds([source.time + 1.0]), [struct.pack(code, 5)])
    source.topics["/a"].batches.append(smaller)
    made.update()
    for name in ("/a/data", "=2 * /a/data"):
        trace = made.trace(name)
        assert trace is not None and trace.correction == text(step)


@CASES
def test_rounded_whole_numbers_are_named_by_plot_bag(
    tmp_path: Path, message_class: type, values: List[int], step: int
) -> None:
    messages = [("/a", message_class(value), n * 10**7) for n, value in enumerate(values)]
    with Ros1Recording(write_bag(tmp_path / "x.bag", messages)) as bag:
        lines, readers = chosen(bag, first_messages(bag), ["/a/data"])
        (series,) = series_of(bag, lines, readers, slices(bag, ["/a"]))
    assert series.correction == text(step)


def test_numbers_after_a_rounded_one_do_not_end_its_report(tmp_path: Path) -> None:
    path = str(tmp_path / "x.bag")
    with rosbag.Bag(path, "w", chunk_threshold=1) as file:  # a chunk for each message
        for number, value in enumerate([2**62, 5]):
            file.write("/a", Int64(value), genpy.Time(0, BEGIN + number))
    with Ros1Recording(path) as bag:
        lines, readers = chosen(bag, first_messages(bag), ["/a/data"])
        (series,) = series_of(bag, lines, readers, slices(bag, ["/a"]))
    assert series.correction == text(1024)
