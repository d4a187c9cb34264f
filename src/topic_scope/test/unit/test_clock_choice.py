"""Choice of a topic's clock where the scope estimates several."""

import itertools
import math
from typing import Callable, Dict, List, Tuple

import numpy
import pytest
from geometry_msgs.msg import PointStamped
from rospy import Duration
from test_one_clock import MS, NOW, TOPICS, received, stamped

from topic_scope.analysis.ring import Samples
from topic_scope.messages.fields import FieldError
from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.statistics_table import statistics_of
from topic_scope.page.view import LiveView
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.clock_request import ClockRequest, clock_request_of
from topic_scope.protocol.requests import Measure, View
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS

A, B = "/a/point/x", "/b/point/x"
Sent = Dict[str, List[Tuple[int, PointStamped]]]


def machine(count: int = 100, set_at: int = 10**6, back: float = 50.0) -> Sent:
    """Return messages of a machine whose clock is 2 s behind; those of /b arrive 0.8 s late.

    :param count: number of messages of each topic, 20 a second
    :param set_at: number of the first message whose clock was set back
    :param back: by how much [s]
    """
    sent: Sent = {"/a": [], "/b": []}
    for index in range(count):
        when = NOW + 50 * MS * index
        stamp = when - 2 * NS - (round(back * NS) if index >= set_at else 0)
        sent["/a"].append((when + MS, stamped(stamp, float(index))))
        sent["/b"].append((when + 800 * MS, stamped(stamp, float(index))))
    return sent


def at(number: int, action: Callable[[Recorder], object]) -> Callable[[Recorder], None]:
    """Return a function that calls another one at its n-th call, of 40 a second."""
    calls = itertools.count(1)

    def watch(made: Recorder) -> None:
        if next(calls) == number:
            action(made)

    return watch


def samples(made: Recorder, name: str) -> Samples:
    """Return all samples, without the ends of lines."""
    times, values = made.samples(name, -math.inf, math.inf)
    there = numpy.isfinite(values)
    return times[there], values[there]


def apart(made: Recorder, count: int = 100) -> List[float]:
    """Return the delays from samples of /a to those of /b with the same values [s]."""
    (first, one), (second, other) = (samples(made, name) for name in (A, B))
    assert one.tolist() == other.tolist() == list(range(count))
    return [round(float(time), 4) for time in second - first]


def choose(made: Recorder, topic: str, leader: str) -> None:
    made.streams.choose_clock(topic, leader)


def test_chosen_clock_places_topics_of_one_machine_together() -> None:
    made = received(machine(), A, B)
    assert made.streams.clock_topics() == ["/a", "/b"]
    assert apart(made) == [0.799] * 100
    choose(made, "/b", "/a")  # earlier samples, too
    assert apart(made) == [0.0] * 100
    assert made.streams.clock_topics() == ["/a"]
    trace = made.trace(B)
    assert trace is not None
    assert trace.correction == "by the clock of /a, shifted by 2.001 s"
    view = LiveView(View(20.0, 100, None))
    view.select([A, B])
    table = statistics_of(made, made.samples, view, Measure(), FrequencyBackoff(), made.updated)
    assert [table["traces"][name]["clock"] for name in (A, B)] == [None, "/a"]
    choose(made, "/b", "")
    assert apart(made) == [0.799] * 100
    assert trace.correction == "stamps 2.80 s behind: shown at reception"


def test_contradicted_stamps_are_named_beside_the_chosen_clock() -> None:
    sent = machine()
    sent["/b"][60][1].header.stamp -= Duration(5)
    made = received(sent, A, B)
    choose(made, "/b", "/a")
    trace = made.trace(B)
    assert trace is not None
    assert trace.correction == "by the clock of /a, shifted by 2.001 s; 1 stamp up to 5.00 s late"


def test_choice_moves_the_samples_of_a_paused_view() -> None:
    made = received(machine(), A, B)
    span = NOW / NS, NOW / NS + 10.0
    for leader, shift in (("/a", 0.0), ("", 0.799)):
        made.pin({A: span, B: span})
        choose(made, "/b", leader)
        made.pin({A: span, B: span})
        (first, _), (second, _) = (made.samples(name, *span) for name in (A, B))
        assert second - first == pytest.approx(numpy.full(100, shift), abs=1e-4)


@pytest.mark.parametrize("number", [40, 60, 120])
def test_choice_holds_for_later_messages(number: int) -> None:
    made = received(machine(), A, B, watch=at(number, lambda made: choose(made, "/b", "/a")))
    assert apart(made) == [0.0] * 100


def test_end_of_a_choice_holds_for_later_messages() -> None:
    def choose_twice(made: Recorder) -> None:
        choose(made, "/b", "/a")
        choose(made, "/b", "")

    made = received(machine(), A, B, watch=at(60, choose_twice))
    assert apart(made) == [0.799] * 100
    made.forget()
    assert all(stream.leader is None for stream in made.streams)


@pytest.mark.parametrize("set_at", [10**6, 30])
def test_late_topic_does_not_move_the_clock_that_it_follows(set_at: int) -> None:
    sent = machine(100, set_at)
    sent["/a"] = sent["/a"][:50]  # silent from then on
    made = received(sent, A, B, watch=at(50, lambda made: choose(made, "/b", "/a")))
    (times, _), (others, values) = (samples(made, name) for name in (A, B))
    assert len(values) == 100
    assert numpy.abs(others[:50] - times).max() < 0.01


def test_topic_no_longer_moves_the_clock_that_it_has_left(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setitem(TOPICS, "/c", "geometry_msgs/PointStamped")
    sent = machine()
    sent["/c"] = [(when + 100 * MS, message) for when, message in sent["/b"]]
    names = A, B, "/c/point/x"
    before, after = (
        received(sent, *names, watch=at(number, lambda made: choose(made, "/b", "/a")))
        for number in (10**6, 60)
    )
    moved = samples(after, names[2])[0] - samples(before, names[2])[0]
    assert moved == pytest.approx(numpy.full(100, 0.1), abs=1e-4)


@pytest.mark.parametrize("back", [50.0, 1.0])
def test_topics_stay_together_when_their_clock_is_set(back: float) -> None:
    watch = at(60, lambda made: choose(made, "/b", "/a"))
    made = received(machine(200, 100, back), A, B, watch=watch)
    assert apart(made, 200) == pytest.approx([0.0] * 200, abs=0.01)


def test_topic_follows_a_clock_that_is_set_later_than_its_own_stamps() -> None:
    watch = at(60, lambda made: choose(made, "/a", "/b"))
    made = received(machine(200, 100), A, B, watch=watch)
    assert made.streams.clock_topics() == ["/b"]
    (first, one), (second, other) = (samples(made, name) for name in (A, B))
    assert one[-70:].tolist() == other[-70:].tolist() == list(range(130, 200))
    assert second[-70:] - first[-70:] == pytest.approx(numpy.zeros(70), abs=0.01)
    # Until then they were shown at reception.
    between = [time for time, value in zip(first, one) if 100 <= value < 115]
    expected = NOW / NS + 0.001 + 0.05 * numpy.arange(100, 115)
    assert between == pytest.approx(expected, abs=0.01)


def test_choice_survives_a_jump_of_the_clock() -> None:
    def jump(made: Recorder) -> None:
        choose(made, "/b", "/a")
        made.forget()
        with pytest.raises(FieldError, match="/b has no timestamps whose clock can be chosen"):
            choose(made, "/b", "")  # no message has arrived since

    made = received(machine(), A, B, watch=at(60, jump))
    (first, one), (second, other) = (samples(made, name) for name in (A, B))
    assert one[-30:].tolist() == other[-30:].tolist()
    assert second[-30:] - first[-30:] == pytest.approx(numpy.zeros(30), abs=0.01)


def test_topic_whose_clock_was_chosen_is_still_received() -> None:
    made = received(machine(), A, B)
    choose(made, "/b", "/a")
    named = f"{B}@stamp"
    made.want([A, B, named], NOW / NS)
    trace = made.trace(named)
    assert trace is not None and trace.stream.leader is None  # its stamps were chosen instead
    made.want([B], NOW / NS + 1000.0)  # the trace of /a is no longer recorded
    assert "/a" in made.streams.topics
    made.want([A, B], NOW / NS + 1001.0)
    assert samples(made, A)[1].tolist() == [99.0]  # the latest message, once
    made.want([A], NOW / NS + 2002.0)
    assert made.streams.topics == ["/a"]


def test_impossible_choice_is_rejected_with_the_possible_ones() -> None:
    made = received(machine(), A, B, f"{A}@received")
    with pytest.raises(FieldError, match="/c has no timestamps"):
        choose(made, "/c", "/a")
    text = "/c has no separate clock; topics with one: /a"
    with pytest.raises(FieldError, match=text):
        choose(made, "/b", "/c")
    choose(made, "/b", "/a")
    text = "/b has no separate clock; topics with one: none"
    with pytest.raises(FieldError, match=text):  # they would follow each other
        choose(made, "/a", "/b")
    assert apart(made) == [0.0] * 100


def test_topic_with_a_follower_cannot_follow(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setitem(TOPICS, "/c", "geometry_msgs/PointStamped")
    sent = machine()
    sent["/c"] = [(when + 800 * MS, message) for when, message in sent["/b"]]
    made = received(sent, A, B, "/c/point/x")
    assert made.streams.clock_topics() == ["/a", "/b", "/c"]
    choose(made, "/b", "/c")
    with pytest.raises(FieldError, match="/c cannot follow another topic: /b follows it"):
        choose(made, "/c", "/a")
    choose(made, "/c", "")  # it does not follow any
    choose(made, "/b", "")
    choose(made, "/c", "/a")


def test_scopes_own_clock_is_not_offered() -> None:
    sent = machine()
    sent["/a"] = [(when, stamped(when, one.point.x)) for when, one in sent["/a"]]
    difference, slope = f"={A} - {B}", f"=derivative({A}) + {A}@received"
    operand = f"=2 * {A}.derivative@received"
    made = received(sent, A, B, difference, slope, operand)
    assert made.streams.clock_topics() == ["/b"]
    # A formula explains what is wrong with any of its operands.
    traces = [made.trace(name) for name in (A, difference, slope, operand)]
    words = [trace.correction for trace in traces if trace is not None]
    assert words == [None, "stamps 2.80 s behind: shown at reception", None, None]
    assert [bool(trace and trace.jumps) for trace in traces] == [False, False, True, True]


def test_request_names_two_topics_or_one() -> None:
    request = {"topic": "/b", "leader": "/a"}
    assert clock_request_of(request) == ClockRequest("/b", "/a")
    assert clock_request_of({**request, "leader": ""}) == ClockRequest("/b", "")
    for invalid in ({"topic": "/b"}, {"leader": "/a"}, {"topic": 1, "leader": ""}):
        with pytest.raises(RequestError, match="must be a name"):
            clock_request_of(invalid)
