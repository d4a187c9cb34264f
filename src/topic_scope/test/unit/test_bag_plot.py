"""Plots of a bag."""

import math
from array import array
from pathlib import Path
from typing import List

import genpy
import pytest
from bags import BagMessage, reading, slices
from geometry_msgs.msg import PointStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_hex
from matplotlib.image import imread
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray, Header

from basic_comms.msg import signal_msg
from topic_scope.bag.columns import Column
from topic_scope.bag.plot import draw, save
from topic_scope.bag.series import Series, collect, computed, crossing
from topic_scope.formulas.names import formula_of
from topic_scope.messages.fields import FieldError, to_path


def collected(columns: List[Column], sent: List[BagMessage]) -> List[Series]:
    """Return the series of messages."""
    return collect(reading(columns, sent), slices(sent))


SINE = Series("/x/data", array("d", [0.0, 0.1, 0.2]), array("d", [0.0, 1.0, 0.0]))


def test_each_field_gets_the_values_of_its_topic() -> None:
    columns = [Column("/x", ("data",)), Column("/y", ("data", 1))]
    samples = [
        (0, "/x", Float64(1.0)),
        (10**8, "/y", Float64MultiArray(data=[2.0, 3.0])),
        (2 * 10**8, "/z", Float64(9.0)),
        (3 * 10**8, "/x", Float64(4.0)),
    ]
    assert collected(columns, samples) == [
        Series("/x/data", array("d", [0.0, 0.3]), array("d", [1.0, 4.0])),
        Series("/y/data[1]", array("d", [0.1]), array("d", [3.0])),
    ]


def test_silent_topic_has_an_empty_line() -> None:
    readers = reading([Column("/x", ("data",))], [(0, "/x", Float64(1.0))])
    (series,) = collect(readers, slices([(0, "/y", Float64(2.0))]))
    assert (list(series.times), list(series.values)) == ([], [])
    readers[0].check()


def test_unplottable_value_leaves_a_gap() -> None:
    values = [math.nan, math.inf, -math.inf, 1.7e308, 2.0]
    samples = [(0, "/x", Float64MultiArray(data=[value])) for value in values]
    samples.append((0, "/x", Float64MultiArray(data=[])))
    (series,) = collected([Column("/x", ("data", 0))], samples)
    assert [value for value in series.values if not math.isnan(value)] == [2.0]
    assert len(series.values) == len(series.times) == 6
    assert series.correction is None


def test_stamped_messages_are_plotted_over_stamps_and_a_clock_set_back_ends_the_line() -> None:
    times = [5.0, 5.1, 5.2, 0.0, 0.1]
    delays = [0.01, 0.03, 0.01, 0.02, 0.02]
    samples = [
        (round((0.1 * index + delay) * 1e9), "/s", signal_msg(2.0, 1.0, time, index))
        for index, (time, delay) in enumerate(zip(times, delays))
    ]
    columns = [Column("/s", ("signal_y",), base) for base in ("", "received")]
    own, received = collected(columns, samples)
    assert (own.name, received.name) == ("/s/signal_y", "/s/signal_y@received")
    assert list(own.times) == pytest.approx([0.01, 0.11, 0.21, 0.21, 0.32, 0.42])
    assert repr(list(own.values)) == "[0.0, 1.0, 2.0, nan, 3.0, 4.0]"
    assert list(received.times) == [time / 1e9 for time, _, _ in samples]


def test_joint_has_a_whole_line_among_other_publishers() -> None:
    messages = [
        JointState(name=["arm"], position=[math.nan if index == 4 else float(index)])
        if index % 2 == 0
        else JointState(name=["leg"], position=[-1.0])
        for index in range(8)
    ]
    samples = [(index * 10**7, "/j", message) for index, message in enumerate(messages)]
    (series,) = collected([Column("/j", to_path("position[arm]"))], samples)
    assert repr(list(series.values)) == "[0.0, 2.0, nan, 6.0]"
    assert list(series.times) == [0.0, 0.02, 0.04, 0.06]


def test_a_line_ends_where_several_samples_are_missing() -> None:
    times = [0.0, 0.1, 0.2, 0.3, 0.4, 2.0, 2.1]
    samples = [(round(time * 1e9), "/x", Float64(1.0)) for time in times]
    (series,) = collected([Column("/x", ("data",))], samples)
    assert repr(list(series.values)) == repr([1.0] * 5 + [math.nan] + [1.0] * 2)
    assert list(series.times) == [0.0, 0.1, 0.2, 0.3, 0.4, 0.4, 2.0, 2.1]


def test_unset_stamp_does_not_end_the_line() -> None:
    times = [0.0, 0.01, 0.02, 0.03, 0.04, 0.2, 0.21]  # received with a delay: less than 0.25 s
    samples = [(round(time * 1e9), "/x", PointStamped()) for time in times]
    (series,) = collected([Column("/x", ("point", "x"))], samples)
    assert list(series.times) == times and list(series.values) == [0.0] * 7


def test_line_over_stamps_ends_at_a_shorter_gap() -> None:
    """A delay does not affect stamps: a gap of several steps is one of messages."""
    times = [0.0, 0.01, 0.02, 0.03, 0.04, 0.2, 0.21]
    samples = [
        (
            round(time * 1e9),
            "/x",
            PointStamped(header=Header(stamp=genpy.Time.from_sec(5.0 + time))),
        )
        for time in times
    ]
    (series,) = collected([Column("/x", ("point", "x"))], samples)
    assert repr(list(series.values)) == repr([0.0] * 5 + [math.nan] + [0.0] * 2)


def test_first_seconds_of_a_bag_determine_the_offset_of_a_clock() -> None:
    """The messages from 5 s on are recorded 0.3 s late."""
    samples = [
        (
            index * 10**8 + (3 * 10**8 if index >= 50 else 0),
            "/x",
            PointStamped(header=Header(stamp=genpy.Time(1000 + index // 10, index % 10 * 10**8))),
        )
        for index in range(100)
    ]
    (series,) = collected([Column("/x", ("point", "x"))], samples)
    assert list(series.times) == pytest.approx([0.1 * index for index in range(100)])


def test_a_difference_is_taken_between_two_points_and_not_across_a_gap() -> None:
    first = Series("/x/data", array("d", [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), array("d", [5.0] * 6))
    times = array("d", [0.5, 1.5, 2.5, 2.5, 3.5, 4.5])
    second = Series("/y/data", times, array("d", [0.0, 1.0, 2.0, math.nan, 3.0, -1e301]))
    formula = formula_of("/x/data-/y/data")
    assert formula is not None
    found = computed("apart", formula, [first, second])
    assert found.name == "apart" and found.times == first.times
    nothing = math.nan
    assert repr(list(found.values)) == repr([nothing, 4.5, 3.5, nothing, nothing, nothing])


def test_level_is_reached_from_below() -> None:
    times = array("d", [0.0, 1.0, 2.0])
    assert crossing(Series("/x", times, array("d", [0.0, 0.5, 0.0])), 0.5) == 1.0
    assert crossing(Series("/x", times, array("d", [1.0, 0.0, 1.0])), 0.25) == 1.25
    with pytest.raises(FieldError, match="/x does not rise through 0.5"):
        crossing(Series("/x", times, array("d", [0.5, 1.0, 0.75])), 0.5)


def test_lines_legend_and_titles() -> None:
    other = SINE._replace(name="/y/data")
    (axes,) = draw([SINE, other]).axes
    assert [list(line.get_xdata()) for line in axes.lines] == [[0.0, 0.1, 0.2]] * 2
    assert list(axes.lines[0].get_ydata()) == [0.0, 1.0, 0.0]
    names = ["/x/data", "/y/data"]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == names
    assert axes.get_xlabel() == "time [s]"
    assert axes.get_ylabel() == "/x/data, /y/data"


def test_forty_lines_differ_and_the_title_stays_short() -> None:
    (axes,) = draw([SINE._replace(name=f"/topic{index}/data") for index in range(40)]).axes
    assert len({(line.get_color(), line.get_linestyle()) for line in axes.lines}) == 40
    assert len(axes.get_ylabel().splitlines()) == 2


def test_single_point_can_be_seen_and_many_points_are_not_marked() -> None:
    values = array("d", [math.nan] * 50 + [1.0] + [math.nan] * 50)
    point = Series("/x/data", array("d", range(101)), values)
    many = Series("/y/data", array("d", range(1000)), array("d", range(1000)))
    (axes,) = draw([point, many]).axes
    assert [line.get_marker() for line in axes.lines] == [".", ""]


def test_bands_of_states_are_below_the_lines_over_one_time_axis() -> None:
    mode = Series(
        "/m/data.state",
        array("d", [-0.5, 1.0, 1.5]),
        array("d", [0.0, 1.0, 2.0]),
        "a note",
        ("cost $5$", "a\x07b", "idle"),
    )
    sine = SINE._replace(times=array("d", [0.0, 1.0, 4.0]), correction="shifted")
    upper, lower = draw([mode, sine]).axes
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["/x/data (shifted)"]
    assert lower.get_title(loc="left") == "/m/data.state (a note)"
    assert upper.get_xlim() == lower.get_xlim() == pytest.approx((-0.545, 4.045))
    bands = [patch.get_xy()[:, 0] for patch in lower.patches]
    ends = [(min(places), max(places)) for places in bands]
    assert ends == [(-0.5, 1.0), (1.0, 1.5), (1.5, 4.0)]
    texts = [(text.get_text(), text.get_parse_math()) for text in lower.texts]
    assert texts == [("cost $5$", False), ("idle", False)]  # the other cannot be printed
    # The same in each picture, and in each process.
    assert to_hex(lower.patches[2].get_facecolor()) == "#d62728"


def test_pdf_is_the_same_each_time(tmp_path: Path) -> None:
    save(draw([SINE]), str(tmp_path / "x"), "pdf")
    assert b"CreationDate" not in (tmp_path / "x").read_bytes()


@pytest.mark.extended
@settings(max_examples=5)
@given(st.lists(st.floats(), min_size=1, max_size=5))
@pytest.mark.filterwarnings("error")
def test_any_values_can_be_plotted(
    tmp_path_factory: "pytest.TempPathFactory", values: List[float]
) -> None:
    path = tmp_path_factory.mktemp("plots") / "x.png"
    samples = [(index, "/x", Float64(value)) for index, value in enumerate(values)]
    save(draw(collected([Column("/x", ("data",))], samples)), str(path), "png")
    assert imread(str(path)).shape[:2] == (675, 1350)


@pytest.mark.extended
def test_huge_values_of_both_signs_can_be_plotted(tmp_path: Path) -> None:
    samples = [(index, "/x", Float64((-1) ** index * 1e300)) for index in range(5)]
    save(draw(collected([Column("/x", ("data",))], samples)), str(tmp_path / "x"), "png")
    assert imread(str(tmp_path / "x")).min() < 0.5


def test_svg_is_the_same_each_time_and_holds_the_names(tmp_path: Path) -> None:
    for name in ("one", "two"):
        save(draw([SINE]), str(tmp_path / name), "svg")
    text = (tmp_path / "one").read_text()
    assert text == (tmp_path / "two").read_text()
    assert "<svg" in text and "time [s]" in text
