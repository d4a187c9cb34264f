"""Mask around a reference, and the command that checks a bag."""

import argparse
import csv
import itertools
import math
from pathlib import Path
from typing import Any, List, Tuple
from unittest import mock

import pytest
from bags import BEGIN, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from geometry_msgs.msg import Vector3
from std_msgs.msg import Float64
from test_differences import TimedSource, recording
from test_one_clock import MS, NOW, received, stamped
from test_partial_bags import write_with_a_broken_chunk

from topic_scope.commands import mask as mask_command
from topic_scope.masks.mask_check import Mask, MaskCheck, MaskResult
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS

MASK = Mask("/a/data", "/b/data", 0.5, 0.1)
STEP_S = 0.01


def wave(index: int) -> float:
    return math.sin(2 * math.pi * 0.5 * index * STEP_S)


def test_the_limits_are_formulas() -> None:
    assert MASK.upper == "=highest(/b/data, 0.1) + 0.5"
    assert MASK.lower == "=lowest(/b/data, 0.1) - 0.5"
    assert MASK._replace(reference="/c-/d", time=1e-05).upper == "=highest((/c - /d), 1e-05) + 0.5"


def test_each_sample_is_checked_once_when_its_reference_is_known() -> None:
    source = TimedSource()
    made = recording(source, *MASK.names)
    check = MaskCheck(MASK, 1000.5)
    assert check.update(made) == MaskResult()
    times = [1000.0 + STEP_S * index for index in range(400)]
    # 0.08 s late, which is within 0.1 s; and higher by 2 in five samples.
    values = [wave(index - 8) + (2.0 if 200 <= index < 205 else 0.0) for index in range(400)]
    for begin in range(0, 400, 50):
        part = slice(begin, begin + 50)
        source.time = times[part][-1]
        source.receive("/a", times[part], values[part])
        source.receive("/b", times[part], [wave(index) for index in range(400)[part]])
        made.update()
        result = check.update(made)
    # Up to 0.1 s before the end the reference is known, and 0.51 s are before the start.
    assert result.inside + result.outside == 400 - 51 - 10 and result.unchecked == 0
    assert result.outside == 5 and result.first == pytest.approx(1002.0)
    # The wave rises there: the highest value is 0.1 s later.
    worst = max(wave(index - 8) + 2.0 - wave(index + 10) - 0.5 for index in range(200, 205))
    assert result.worst == pytest.approx(worst)
    assert result.text == "334 samples inside, 5 outside"


def test_worst_excess_is_that_of_all_samples_so_far() -> None:
    source, mask = TimedSource(), Mask("/a/data", "/b/data", 1.0, 0.0)
    made = recording(source, *mask.names)
    check = MaskCheck(mask, 1000.0)
    for begin, peak in ((1001.0, 5.0), (1002.0, 3.0)):
        times = [begin + STEP_S * index for index in range(100)]
        source.time = times[-1]
        source.receive("/a", times, [peak] + 99 * [0.0])
        source.receive("/b", times, 100 * [0.0])
        made.update()
        result = check.update(made)
    assert (result.outside, result.worst) == (2, 4.0)


def test_sample_on_a_limit_is_inside() -> None:
    source, mask = TimedSource(), Mask("/a/data", "/b/data", 1.0, 0.0)
    made = recording(source, *mask.names)
    check = MaskCheck(mask, 1000.0)
    times = [1001.0, 1001.1, 1001.2]
    source.receive("/a", times, [1.0, -1.0, 1.5])
    source.receive("/b", times, [0.0] * 3)
    source.time = 1001.5
    made.update()
    assert check.update(made)[:3] == (2, 1, 0)


def test_sample_without_a_value_is_not_checked() -> None:
    source, mask = TimedSource(), Mask("/a/data", "/b/data", 1.0, 0.0)
    made = recording(source, *mask.names)
    check = MaskCheck(mask, 1000.0)
    times = [1001.0, 1001.1, 1001.2]
    source.receive("/a", times, [0.0, math.nan, 0.0])
    source.receive("/b", times, [0.0] * 3)
    source.time = 1001.5
    made.update()
    assert check.update(made)[:3] == (2, 0, 1)


def test_first_sample_outside_is_the_earliest_even_if_it_is_late() -> None:
    stamps = [NOW + 10 * MS * index for index in range(700)]
    sent = [(when, stamped(when, 9.0 if when in stamps[20:31:10] else 0.0)) for when in stamps]
    reply = list(sent)
    sent[20] = (stamps[20] + 5 * NS + 1, sent[20][1])
    sent.sort(key=lambda one: one[0])
    mask = Mask("/a/point/x@stamp", "/b/point/x@stamp", 0.2, 0.0)
    check = MaskCheck(mask, -math.inf)
    others = [(when, stamped(when, 0.0)) for when, _ in reply]
    received({"/a": sent, "/b": others}, *mask.names, watch=check.update)
    assert (check.result.outside, check.result.first) == (2, stamps[20] / NS)


def test_topics_that_appear_later_do_not_restart_the_check() -> None:
    source = TimedSource()
    arguments = argparse.Namespace(
        field="/a", around="/b", value=1.0, time=0.0, all=False, save=None
    )
    checker = mask_command.TraceChecker(recording(source), arguments)
    checker.begin(source.time, 0.0)
    for topic, value in (("/a", 5.0), ("/b", 0.0)):
        source.receive(topic, [source.time, source.time + 0.1], [value] * 2)
    assert checker.update()
    checker.begin(source.time, 0.0)
    assert checker.finish() == mask_command.OUTSIDE


def test_live_check_starts_when_both_traces_are_received() -> None:
    source = TimedSource()
    arguments = argparse.Namespace(field="/a", around="/b", value=1.0, time=0.0)
    checker = mask_command.TraceChecker(recording(source), arguments)
    checker.begin(source.time, math.inf)
    has_started = []
    for topic in ("/a", "/b"):
        source.receive(topic, [source.time], [0.0])
        has_started.append(checker.start(source.time))
    assert has_started == [False, True]


@pytest.mark.parametrize("time", [pytest.param(35.0, marks=pytest.mark.extended), 80.0])
def test_samples_dropped_before_the_check_are_counted_and_reported(time: float) -> None:
    source = TimedSource()
    mask = MASK._replace(time=time)
    made = recording(source, *mask.names)  # keeps 60 s
    check = MaskCheck(mask, 1000.0)
    for second in range(200):
        times = [1000.0 + second + 0.1 * index for index in range(1, 11)]
        source.time = times[-1]
        for topic in ("/a", "/b"):
            source.receive(topic, times, [0.0] * 10)
        made.update()
        check.update(made)
    assert check.result.outside == 0 and check.result.inside < 300
    # All samples before the stored ones, and those that depend on them.
    counted = check.result.inside + check.result.unchecked
    assert counted == pytest.approx(10 * min(141 + time, 200), abs=15)
    says = f" not checked; it needs {time + 1:g} s before and {time:g} s after each, and samples"
    assert says in check.words(made)


def test_ended_reference_is_reported_while_the_trace_continues() -> None:
    source = TimedSource()
    made = recording(source, *MASK.names)
    check = MaskCheck(MASK, 1000.0)
    said = []
    for second in range(4):
        times = [1000.0 + second + STEP_S * index for index in range(1, 101)]
        source.time = times[-1]
        source.receive("/a", times, [0.0] * 100)
        if second < 2:
            source.receive("/b", times, [0.0] * 100)
        made.update()
        check.update(made)
        said.append(check.words(made))
    # Samples within 0.1 s of the start or end of the reference cannot be checked.
    assert said[1] == "180 samples inside, 0 outside, 10 not checked"
    assert said[3] == f"{said[1]}; /b/data silent for 2.0 s"


def test_nothing_is_checked_in_a_gap_of_the_reference() -> None:
    source = TimedSource()
    made = recording(source, *MASK.names)
    check = MaskCheck(MASK, -math.inf)
    times = [1000.0 + STEP_S * index for index in range(400)]
    known = [time for time in times if not 1001.0 < time < 1002.0]
    source.receive("/a", times, [0.0] * 400)
    source.receive("/b", known, [0.0] * len(known))
    source.time = 1004.0
    made.update()
    result = check.update(made)
    # From 0.1 s before the gap to 0.1 s after it, and 0.1 s at the start.
    assert result.outside == 0 and result.unchecked == pytest.approx(10 + 120, abs=2)
    assert result.text.endswith(" not checked")


@pytest.mark.parametrize(
    "late",
    [
        0.35,
        pytest.param(0.6, marks=pytest.mark.extended),
        pytest.param(5.0, marks=pytest.mark.extended),
    ],
)
def test_late_sample_is_checked_at_its_stamp(late: float) -> None:
    """For a punctual trace, and for a trace that is late as a whole."""
    stamps = [NOW + 10 * MS * index for index in range(1000)]
    reply = [(when, stamped(when, 0.0)) for when in stamps]
    one_late = list(reply)
    one_late[500] = (stamps[500] + round(late * NS) + 1, stamped(stamps[500], 9.0))
    all_late = [(when + round(late * NS), stamped(when, 0.0)) for when in stamps]
    all_late[500][1].point.x = 9.0
    for some in (sorted(one_late, key=lambda one: one[0]), all_late):
        mask = Mask("/a/point/x@stamp", "/b/point/x@stamp", 0.2, 0.05)
        check, calls = MaskCheck(mask, NOW / NS - 1.0), itertools.count()

        def update(recorder: Recorder) -> None:
            if next(calls) % 20 == 0:  # twice per second
                check.update(recorder)

        made = received({"/a": some, "/b": reply}, *mask.names, watch=update)
        check.update(made)
        check.finish(made)
        result = check.result
        assert result.outside == 1 and result.first == stamps[500] / NS
        assert result.inside + result.outside + result.unchecked == check.received == 1000
        assert result.unchecked <= 12


@pytest.mark.extended
@settings(max_examples=30, deadline=None)
@given(st.data())
def test_each_sample_is_counted_once(data: st.DataObject) -> None:
    count = 100
    delays = data.draw(
        st.lists(st.sampled_from([0, 0, 0, 5, 40, 400, 3000]), min_size=count, max_size=count)
    )
    field = data.draw(st.sampled_from(["/a/point/x", "/a/point/x@received", "=2 * /a/point/x"]))
    begin, end = sorted(data.draw(st.lists(st.integers(0, count), min_size=2, max_size=2)))
    reply = [
        (NOW + 10 * MS * index + delay * MS + index, stamped(NOW + 10 * MS * index, 0.0))
        for index, delay in enumerate(delays)
    ]
    reply.sort(key=lambda one: one[0])
    others = [(NOW + 10 * MS * n, stamped(NOW + 10 * MS * n, 0.0)) for n in range(begin, end + 1)]
    mask = Mask(field, "/b/point/x", 0.1, 0.02)
    check = MaskCheck(mask, -math.inf)
    made = received({"/a": reply, "/b": others}, *mask.names, watch=check.update)
    check.update(made)
    check.finish(made)
    result = check.result
    assert result.inside + result.outside + result.unchecked == check.received == count
    assert result.outside == 0


@pytest.fixture
def bag(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> str:
    """Write a bag of 4 s into the command's folder: a late wave with a peak."""
    monkeypatch.chdir(tmp_path)
    messages: List[Any] = []
    for index in range(400):
        high = 2.0 if 300 <= index < 303 else 0.0
        messages.append(("/a", Float64(wave(index - 8) + high), index * 10**7))
        messages.append(("/b", Float64(wave(index)), index * 10**7))
    return write_bag(tmp_path / "x.bag", messages)


def status(monkeypatch: "pytest.MonkeyPatch", *arguments: str) -> object:
    """Return the exit status of the command."""
    monkeypatch.setattr("sys.argv", ["mask.py", *arguments])
    with pytest.raises(SystemExit) as caught:
        mask_command.main()
    return caught.value.code


def test_command_checks_a_trace_of_a_bag(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    around = ("/a", "--around", "/b", "--bag", bag, "--time", "0.1")
    assert status(monkeypatch, *around, "--value", "2.5") == 0
    assert capsys.readouterr().out == "mask: 380 samples inside, 0 outside, 20 not checked\n"
    assert status(monkeypatch, *around, "--value", "0.1", "--all") == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "mask: 377 samples inside, 3 outside, 20 not checked"
    assert "1700000003.123457 s since the epoch, at worst by 1.8" in said[1]
    assert status(monkeypatch, *around, "--value", "0.1") == 1
    # Samples that wait for their reference when the check ends are not reported.
    assert (
        capsys.readouterr().out.splitlines()[0]
        == "mask: 328 samples inside, 3 outside, 10 not checked"
    )


def test_name_of_several_fields_is_rejected(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    messages = [("/v", Vector3(), 10**7 * index) for index in range(10)]
    path = write_bag(Path("v.bag"), messages)
    assert status(monkeypatch, "/v", "--around", "/v/x", "--bag", path) == 2
    assert capsys.readouterr().err == "mask: /v denotes 3 fields; name one of them\n"


def test_a_failure_stops_it_and_is_saved(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    arguments = ("/a", "--around", "/b", "--bag", bag, "--value", "0.3", "--save", "out.csv")
    assert status(monkeypatch, *arguments) == 1
    with open("out.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    lower, upper = "=lowest(/b/data, 0.0) - 0.3", "=highest(/b/data, 0.0) + 0.3"
    assert list(rows[0]) == ["time", "received", "/a/data", "/b/data", lower, upper]
    limits = [row for row in rows if row["/b/data"]]
    assert len(limits) > 150
    for row in limits:
        assert float(row[upper]) - float(row[lower]) == pytest.approx(0.6)
    values = {row["time"]: float(row["/a/data"]) for row in rows if row["/a/data"]}
    assert max(values.values()) > 1.2 or len(values) < 100


@pytest.mark.parametrize("history, peak", [(0.9, 1), (60.0, 3)])
def test_failure_is_saved_before_its_samples_are_dropped(
    bag: str, monkeypatch: "pytest.MonkeyPatch", history: float, peak: int
) -> None:
    """Later samples are added at the end, if they are still in the history."""
    monkeypatch.setattr(mask_command, "_HISTORY_S", history)
    save = mock.Mock(wraps=mask_command.save_failure)
    monkeypatch.setattr(mask_command, "save_failure", save)
    arguments = ("/a", "--around", "/b", "--bag", bag, "--value", "0.3", "--save", "out.csv")
    assert status(monkeypatch, *arguments, "--all") == 1
    assert save.call_count == (2 if history > 4.0 else 1)
    with open("out.csv", newline="") as file:
        values = [float(row["/a/data"] or "nan") for row in csv.DictReader(file)]
    assert sum(value > 1.2 for value in values) == peak


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (
            ["/a", "--around", "/later"],
            "mask: no sample could be checked: the topic does not exist yet",
        ),
        (["/a", "--around", "=/b +"], "mask: unexpected end of the formula"),
        (["/a", "--around", "=delay(/b, 9)", "--time", "595"], "reach over 604 s: at most 600"),
        (["/a", "--around", f"=-/b{'+-/b' * 17}"], "mask: a formula has at most"),
        (["/a", "--around", "/b", "--value", "-1"], "'-1' is not a number from 0 to 1e+300"),
        (["/a", "--around", "/b", "--time", "nan"], "'nan' is not a number from 0 to 600"),
        (["/a", "--around", "/b", "--seconds", "1s"], "'1s' is not a number from 0.1 to 1e+06"),
        (["/a", "--around", "/b", "--seconds", "3"], "mask: --seconds is for a live trace; a bag"),
    ],
)
def test_samples_that_cannot_be_checked_do_not_pass(
    bag: str,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    arguments: List[str],
    sentence: str,
) -> None:
    assert status(monkeypatch, *arguments, "--bag", bag) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    "ends, expected, said",
    [
        (100, 2, "100 samples inside, 0 outside, 900 not checked"),
        (960, 0, "960 samples inside, 0 outside, 40 not checked"),  # some messages wait
    ],
)
def test_reference_that_ends_early_does_not_pass(
    tmp_path: Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    ends: int,
    expected: int,
    said: str,
) -> None:
    messages: List[Any] = [("/a", Float64(1.0), index * 10**7) for index in range(1000)]
    messages += [("/b", Float64(1.0), index * 10**7) for index in range(ends)]
    name = write_bag(tmp_path / "x.bag", sorted(messages, key=lambda one: one[2]))
    around = ("/a", "--around", "/b", "--bag", name, "--value", "0.1")
    assert status(monkeypatch, *around) == expected
    reply = capsys.readouterr()
    assert reply.out == f"mask: {said}\n"
    assert reply.err == ("mask: /b/data ended 9.00 s before the trace did\n" if expected else "")


def test_a_late_sample_outside_fails_a_bag(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    """A sample of 9 that was recorded 0.6 s late, around 0."""
    messages: List[Any] = []
    for index in range(2000):
        when = index * 10 * MS
        value, late = (9.0, 600 * MS) if index == 1000 else (0.0, 0)
        messages.append(("/a", stamped(BEGIN + when, value), when + late))
        messages.append(("/b", stamped(BEGIN + when, 0.0), when))
    name = write_bag(tmp_path / "x.bag", sorted(messages, key=lambda one: one[2]))
    around = ("/a/point/x", "--around", "/b/point/x", "--bag", name, "--value", "0.2")
    assert status(monkeypatch, *around, "--time", "0.05", "--all") == 1
    said = capsys.readouterr().out.splitlines()[0]
    assert said == "mask: 1989 samples inside, 1 outside, 10 not checked"


@pytest.mark.parametrize("allowed, expected", [((), 2), (("--unchecked", "20"), 0)])
def test_too_many_unchecked_samples_do_not_pass(
    tmp_path: Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    allowed: Tuple[str, ...],
    expected: int,
) -> None:
    """A reference with a hole in the middle of the trace."""
    messages: List[Any] = [("/a", Float64(1.0), index * 10**7) for index in range(1000)]
    messages += [("/b", Float64(1.0), n * 10**7) for n in range(1000) if not 400 < n < 551]
    name = write_bag(tmp_path / "x.bag", sorted(messages, key=lambda one: one[2]))
    around = ("/a", "--around", "/b", "--bag", name, "--value", "0.1")
    assert status(monkeypatch, *around, *allowed) == expected
    reply = capsys.readouterr()
    assert reply.out == "mask: 850 samples inside, 0 outside, 150 not checked\n"
    assert ("too many samples were not checked (15 %, at most 10 %)" in reply.err) == bool(expected)


def test_invalid_file_is_rejected(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    assert status(monkeypatch, "/a", "--around", "/b", "--bag", "no.bag") == 2
    assert capsys.readouterr().err == "mask: no.bag: No such file or directory\n"


def test_damaged_bag_does_not_pass(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    path = write_with_a_broken_chunk(tmp_path / "x.bag", 1)
    assert status(monkeypatch, "/x", "--around", "/x", "--value", "1", "--bag", path) == 2
    said = capsys.readouterr()
    assert ", 0 outside" in said.out and f"mask: {path} is damaged (" in said.err
