"""Timestamp sources of traces."""

import numpy
import pytest
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg
from topic_scope.messages import timestamp_source
from topic_scope.messages.message_layout import layout_of
from topic_scope.messages.fields import FieldError
from topic_scope.timing.nanoseconds import NS

FIELD, STAMP = ("time_x",), ("header", "stamp")


def test_best_source_is_chosen() -> None:
    paths = [
        timestamp_source.path_of("", layout_of(one)) for one in (PoseStamped, signal_msg, Float32)
    ]
    assert paths == [STAMP, FIELD, None]
    assert [timestamp_source.name_of(path) for path in paths] == ["stamp", "time_x", "received"]


def test_selected_source_is_used_or_rejected() -> None:
    layout = layout_of(signal_msg)
    assert timestamp_source.path_of("received", layout) is None
    assert timestamp_source.path_of("time_x", layout) == FIELD
    for name in ("stamp", "time_y", "signal_y"):  # the last is too coarse for a time
        with pytest.raises(FieldError, match="there is no time .* in basic_comms/signal_msg"):
            timestamp_source.path_of(name, layout)


def test_several_missing_samples_end_a_line_and_a_delay_does_not() -> None:
    quick, slow = numpy.arange(100) * NS // 1000, numpy.arange(100) * 2 * NS
    assert timestamp_source.longest_step(FIELD, quick) == pytest.approx(0.005)
    assert timestamp_source.longest_step(None, quick) == 0.25
    assert (
        timestamp_source.longest_step(FIELD, slow)
        == timestamp_source.longest_step(None, slow)
        == 10.0
    )
    few = [timestamp_source.longest_step(FIELD, slow[:count]) for count in (3, 4)]
    assert few == [numpy.inf, 10.0]
