"""Texts and numbers with named values, as states over time."""

import asyncio
import csv
import io
import json
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy
import pytest
from actionlib_msgs.msg import GoalStatus
from bags import serialized, write_bag
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import BatteryState, NavSatStatus
from std_msgs.msg import Float64, String
from test_plot_bag import call, failure
from test_recorder import FakeSource, FakeSubscription, header
from visualization_msgs.msg import Marker

from topic_scope.analysis.state_spans import SEVERAL, StateSpan, state_spans
from topic_scope.bag.opening import open_bag
from topic_scope.bag.overlay import BagOverlay
from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.plot import draw
from topic_scope.formulas.names import is_state
from topic_scope.messages.constants import value_names
from topic_scope.messages.message_layout import layout_of
from topic_scope.messages.fields import FieldError, to_path
from topic_scope.messages.layout_cache import Layouts
from topic_scope.messages.states import CHARACTERS, TEXTS, StateDecoder, StateTable
from topic_scope.page.csv_export import parts
from topic_scope.page.open_page import Page
from topic_scope.page.state_feed import StateFeed
from topic_scope.page.statistics_table import statistics_of
from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.view import LiveView
from topic_scope.protocol.checks import RequestError, field_in
from topic_scope.protocol.requests import Measure, View
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder

NAN = float("nan")


def names(message_class: Any, field: str) -> Dict[int, str]:
    """Return the names of the values of a field."""
    return dict(layout_of(message_class).value_names.get(field, {}))


def test_constants_before_a_field_name_its_values() -> None:
    assert names(DiagnosticStatus, "level") == {0: "OK", 1: "WARN", 2: "ERROR", 3: "STALE"}
    assert names(NavSatStatus, "status")[-1] == "STATUS_NO_FIX"
    assert names(NavSatStatus, "service")[4] == "SERVICE_COMPASS"


def test_constants_behind_a_field_name_its_values() -> None:
    assert names(GoalStatus, "status")[3] == "SUCCEEDED"


@pytest.mark.parametrize("message_class", [BatteryState, Marker])
def test_constants_away_from_their_fields_name_nothing(message_class: Any) -> None:
    assert layout_of(message_class).value_names == {}


@pytest.mark.parametrize(
    "text, expected",
    [
        ("uint8 a\nuint8 A=1\nuint8 b", {}),
        ("uint8 a\nuint8 A=1\nint8 b", {"a": {1: "A"}}),
        ("uint8 A=1 # one\n\n# text\nuint8 b", {"b": {1: "A"}}),
        ("uint8 A=1\nuint8 B=1\nuint8 b", {"b": {1: "A or B"}}),
        ("uint8 A=0x10\nuint8 b", {"b": {16: "A"}}),
        ("uint8 A=1\nuint8[] b", {}),
        ("float32 A=1\nfloat32 b", {}),
        ("string A=1\nstring b", {}),
        ("bool A=1\nbool b", {}),
    ],
)
def test_constants_are_of_the_only_field_beside_them(text: str, expected: Any) -> None:
    assert value_names("a/B", text) == expected


def read(message: Any, path: str) -> List[Optional[str]]:
    table = StateTable()
    decoder = StateDecoder(layout_of(type(message)), to_path(path), table)
    data = serialized(message)
    codes = decoder.decode([data, data[:-1]] if path == "data" else [data])
    return [table.text(code) for code in codes.tolist()]


def test_decoder_reads_texts_and_names_but_no_cut_off_text() -> None:
    assert read(String("säule"), "data") == ["säule", None]
    assert read(NavSatStatus(status=2), "status") == ["STATUS_GBAS_FIX"]
    assert read(NavSatStatus(service=3), "service") == ["3"]  # several flags: no name
    statuses = [DiagnosticStatus(name=one, message=f"{one} is hot") for one in ("a", "b c")]
    message = DiagnosticArray(status=statuses)
    assert read(message, "status[name=b c]/message") == ["b c is hot"]
    assert read(message, "status[name=d]/message") == [None]


def test_number_of_a_state_is_not_rounded() -> None:
    decoder = StateDecoder(layout_of(String), ("data",), StateTable())
    assert decoder.rounding(decoder.decode([serialized(String("on"))])) == 1


def test_decoder_rejects_a_number_without_names() -> None:
    with pytest.raises(FieldError, match="neither a text nor a number with named values"):
        StateDecoder(layout_of(Float64), ("data",), StateTable())


def test_table_is_bounded_and_reports_it() -> None:
    table = StateTable()
    numbers = [table.number(str(one)) for one in range(TEXTS)]
    assert numbers == list(range(TEXTS)) and table.note is None
    other = table.number("one more")
    assert other == table.number("and one more") and table.text(other) == "(another text)"
    assert "more than 1000 different texts" in str(table.note)
    assert table.number("7") == 7 and len(table.texts) == TEXTS + 1
    long = StateTable()
    assert long.text(long.number("x" * 999)) == "x" * CHARACTERS + "…"
    assert "cut" in str(long.note)


def spans(codes: List[float], start: int = 0, most: int = 100) -> List[StateSpan]:
    times = numpy.arange(len(codes)) * 10
    return state_spans(times, numpy.array(codes), start, 40, most)


def test_span_lasts_until_another_state_or_a_gap() -> None:
    found = spans([1, 1, 2, NAN, NAN, 2, 2])
    expected = [(0, 20, 1, 1), (20, 30, 2, 1), (50, None, 2, 1)]
    assert found == [StateSpan(*one) for one in expected]
    assert spans([]) == []


def test_span_at_the_start_keeps_its_own_start() -> None:
    assert spans([1, 1, 2, 2, 3], start=35) == [StateSpan(20, 40, 2), StateSpan(40, None, 3)]
    assert spans([1, 1, 2], start=20) == [StateSpan(20, None, 2)]


def test_spans_are_merged_only_if_they_are_too_many_and_several() -> None:
    assert len(spans([1, 2, 3], most=3)) == 3
    alone = [StateSpan(0, 10, 1), StateSpan(10, 50, 2), StateSpan(50, None, 3)]
    assert spans([1, 2, 2, 2, 2, 3], most=1) == alone


def test_many_short_spans_are_merged() -> None:
    found = spans([1, 2, 3, 4, 5, 5, 5, 5], most=3)
    assert found == [
        StateSpan(0, 30, SEVERAL, 3),
        StateSpan(30, 40, 4),
        StateSpan(40, None, 5),
    ]


@given(st.lists(st.integers(0, 3), min_size=1, max_size=60), st.integers(1, 20))
def test_spans_cover_all_samples_without_overlap(codes: List[int], most: int) -> None:
    found = spans([float(code) for code in codes], most=most)
    assert found[0].start == 0 and found[-1].end is None
    assert all(one.end == after.start for one, after in zip(found, found[1:]))
    changes = sum(one != after for one, after in zip(codes, codes[1:]))
    assert sum(one.states for one in found) == changes + 1
    for span in found:
        inside = codes[span.start // 10 : None if span.end is None else span.end // 10]
        assert span.number == SEVERAL or set(inside) == {span.number}


# --- Recorded live -------------------------------------------------------------------------------

MODE = "/mode/data.state"


def recorder(*wanted: str) -> Tuple[Recorder, FakeSource]:
    source = FakeSource()
    source.topics = {"/mode": FakeSubscription(), "/fix": FakeSubscription()}
    made = Recorder(source, Layouts(), 10.0)  # type: ignore[arg-type]
    made.set_topics({"/mode": "std_msgs/String", "/fix": "sensor_msgs/NavSatStatus"})
    made.want([name for one in wanted for name in made.expand(one)], source.time)
    return made, source


def send(source: FakeSource, made: Recorder, *messages: Any) -> None:
    """Send messages 1 s apart, and update the recorder."""
    for message in messages:
        topic = "/mode" if isinstance(message, String) else "/fix"
        batch = Batch(header(type(message)), [int(source.time * 1e9)], [serialized(message)])
        source.topics[topic].batches.append(batch)
        source.time += 1.0
    made.update()


def states(made: Recorder, name: str, now: float, window: float = 100.0) -> Dict[str, Any]:
    view = LiveView(View(window, 500, None))
    view.select([name])
    message = StateFeed().update(made, view, now)
    assert message is not None and message["until"] == now
    return dict(message["traces"][name])


def test_text_is_recorded_as_a_state() -> None:
    made, source = recorder("/mode/data")
    assert made.expand("/mode/data") == [MODE]
    send(source, made, *map(String, ["idle", "idle", "drive", "idle"]))
    assert states(made, MODE, source.time) == {
        "texts": ["idle", "drive"],
        "spans": [[1000.0, 1002.0, 0, 1], [1002.0, 1003.0, 1, 1], [1003.0, None, 0, 1]],
        "earlier": True,
    }
    later = states(made, MODE, source.time, 1.5)
    assert later["spans"][0][:2] == [1002.0, 1003.0] and not later["earlier"]
    send(source, made, String("park"))
    latest = states(made, MODE, source.time, 0.5)
    assert (latest["texts"], latest["spans"]) == (["park"], [[1004.0, None, 0, 1]])
    view = LiveView(View(10.0, 500, source.time + 5.0))  # it ends later than the samples
    view.select([MODE])
    message = StateFeed().update(made, view, source.time)
    assert message is not None and message["until"] == source.time


def test_number_is_a_state_only_on_request() -> None:
    made, source = recorder("/fix/status.state", "/fix/status")
    send(source, made, NavSatStatus(status=-1), NavSatStatus(status=0), NavSatStatus(status=9))
    found = states(made, "/fix/status.state", source.time)
    assert found["texts"] == ["STATUS_NO_FIX", "STATUS_FIX", "9"]
    assert made.samples("/fix/status", 0.0, 1e9)[1].tolist() == [-1.0, 0.0, 9.0]
    assert made.expand("/fix") == ["/fix/status", "/fix/service"]
    assert made.expand("/fix.state") == ["/fix/status.state", "/fix/service.state"]
    listed = {choice.field: choice.datatype for choice in made.choices()}
    assert listed["/fix/status.state"] == "int8" and listed[MODE] == "string"


def test_memory_of_an_ever_changing_text_is_bounded() -> None:
    made, source = recorder("/mode/data")
    send(source, made, *(String(str(one)) for one in range(TEXTS + 200)))
    trace = made.trace(MODE)
    assert trace is not None and trace.states is not None
    assert len(trace.states.texts) == TEXTS + 1 and "different texts" in str(trace.correction)


def test_csv_has_the_text_in_a_column() -> None:
    made, source = recorder("/mode/data")
    reply = ['a, "b"\nc', "", "nan"]
    send(source, made, *map(String, reply))

    async def text() -> str:
        return "".join([part async for part in parts(made, [MODE], 0.0, 2000.0)])

    rows = list(csv.reader(io.StringIO(asyncio.run(text()))))
    assert rows[0] == ["time", "received", MODE]
    assert [row[2] for row in rows[1:]] == reply


def test_table_has_the_latest_state_and_no_figures() -> None:
    made, source = recorder("/mode/data")
    send(source, made, String("idle"), String("drive"))
    view = LiveView(View(100.0, 500, None))
    view.select([MODE])
    assert view.shown == [] and view.states == [MODE]
    reply = statistics_of(made, made.samples, view, Measure(), FrequencyBackoff(), source.time)
    measured = reply["traces"][MODE]
    assert measured["state"] == "drive" and measured["problem"] is None
    assert "mean" not in measured and "frequency" not in measured


# --- Errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", [f"={MODE} + 1", f"{MODE}-/fix/status", "=/mode/data * 2", "/fix/status-/mode/data"]
)
def test_computed_trace_of_a_state_is_rejected(name: str) -> None:
    made, _ = recorder()
    with pytest.raises(FieldError, match=r"/mode/data\.state is a state: formulas and differences"):
        made.expand(name)


@pytest.mark.parametrize("name", ["/fix/status/x.state", "/mode/data.derivative"])
def test_field_without_states_is_rejected(name: str) -> None:
    made, _ = recorder()
    with pytest.raises(FieldError, match="there is no"):
        made.expand(name)


def test_request_for_a_number_rejects_a_state() -> None:
    with pytest.raises(RequestError, match=r"trigger: /mode/data\.state is a state"):
        field_in({"field": MODE}, "trigger")


def test_state_is_known_by_its_name() -> None:
    assert is_state(MODE) and is_state("/a/b[name=x.y]/c.state@stamp")
    assert not any(
        map(is_state, ["/a/state", "/a/b.yaw", f"={MODE}", "/a.state b", "/a[x=.state]"])
    )


# --- From a bag ----------------------------------------------------------------------------------


@pytest.fixture
def bag(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> str:
    """Write a bag of 9 s into the command's folder."""
    monkeypatch.chdir(tmp_path)
    reply = ["idle"] * 5 + ["drive, fast"] * 5
    messages: List[Any] = [("/mode", String(text), n * 10**9) for n, text in enumerate(reply)]
    messages += [("/fix", NavSatStatus(status=0), 0), ("/x", Float64(1.5), 9 * 10**9)]
    return write_bag(tmp_path / "x.bag", messages)


def test_csv_of_a_bag_has_texts(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    call(monkeypatch, bag, "/mode/data", "/x/data", "/fix/status.state", "-o", "out.csv")
    rows = list(csv.reader(Path("out.csv").open(newline="")))
    assert rows[0] == ["time", MODE, "/x/data", "/fix/status.state"]
    assert [row[1] for row in rows[1:] if row[1]] == ["idle"] * 5 + ["drive, fast"] * 5
    assert [row[2] for row in rows if row[2]] == ["/x/data", "1.5"]
    assert [row[3] for row in rows[1:] if row[3]] == ["STATUS_FIX"]


def test_csv_with_a_formula_has_texts_too(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    call(monkeypatch, bag, "/mode/data", "=2*/x/data", "-o", "out.csv")
    rows = list(csv.reader(Path("out.csv").open(newline="")))
    assert [row[1] for row in rows[1:] if row[1]] == ["idle"] * 5 + ["drive, fast"] * 5
    assert [row[2] for row in rows[1:] if row[2]] == ["3.0"]


def test_picture_has_a_band_with_texts(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    with open_bag(bag) as opened:
        lines, readers = chosen(opened, first_messages(opened), ["/mode/data", "/x/data"])
        series = series_of(opened, lines, readers, slices(opened, ["/mode", "/x"]))
    figure = draw(series)
    numbers, band = figure.axes
    assert [line.get_label() for line in numbers.lines] == ["/x/data"]
    assert [text.get_text() for text in band.texts] == ["idle", "drive, fast"]
    assert band.get_title("left") == MODE
    in_data = band.transData.inverted().transform_bbox
    starts = [in_data(patch.get_window_extent()).x0 for patch in band.patches]
    assert starts == pytest.approx([0.0, 5.0], abs=0.1)
    assert band.patches[0].get_facecolor() != band.patches[1].get_facecolor()
    call(monkeypatch, bag, "/mode/data", "-o", "out.png")
    assert Path("out.png").read_bytes().startswith(b"\x89PNG")


def test_only_short_spans_are_merged_in_a_picture(tmp_path: Path) -> None:
    """Each second of the first 1100 has another state, and the last state is long."""
    messages = [("/mode", String(f"{n % 7}"), n * 10**9) for n in range(1100)]
    messages += [("/mode", String("at rest"), n * 10**9) for n in range(1100, 2200)]
    with open_bag(write_bag(tmp_path / "x.bag", messages)) as opened:
        lines, readers = chosen(opened, first_messages(opened), ["/mode/data"])
        band = draw(series_of(opened, lines, readers, slices(opened, ["/mode"]))).axes[-1]
    assert [text.get_text() for text in band.texts] == ["at rest"]
    assert len(band.patches) > 400


def test_alignment_by_a_state_is_rejected(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    said = failure(monkeypatch, capsys, bag, "/x", "--align", "/mode/data", "1", "-o", "a.png")
    assert f"{MODE} is a state, which cannot rise through a level" in said


def test_state_of_an_overlaid_bag_has_its_texts(bag: str) -> None:
    overlay = BagOverlay(bag, "old")
    overlay.begin = 1000.0
    source = FakeSource()
    made = Recorder(source, Layouts(), 10.0, [overlay])  # type: ignore[arg-type]
    made.set_topics(overlay.types)
    (name,) = made.expand("/old/mode/data")
    made.want([name], source.time)
    ((own, trace),) = overlay.take_wanted()
    (series,) = overlay.read([own])
    trace.fill(series.times, series.values, series.correction, series.states)
    assert made.problem(name) is None
    found = states(made, name, 1020.0)
    assert found["texts"] == ["idle", "drive, fast"]
    assert found["spans"] == [[1000.0, 1005.0, 0, 1], [1005.0, None, 1, 1]]


def test_page_gets_states_beside_its_numbers() -> None:
    made, source = recorder("/mode/data", "/fix/status")
    send(source, made, String("idle"), NavSatStatus(status=1))
    page = Page(100.0)
    page.view.select([MODE, "/fix/status"])
    reply = {one["type"]: one for one in page.frame(made, source.time, True)}
    assert list(reply["frame"]["traces"]) == ["/fix/status"]
    assert list(reply["states"]["traces"]) == [MODE]
    assert set(reply["stats"]["traces"]) == {MODE, "/fix/status"}
    json.dumps(reply)
    for change in (page.show_again, lambda: page.restart(source.time)):  # at once
        change()
        reply = {one["type"]: one for one in page.frame(made, source.time, False)}
        assert list(reply["states"]["traces"]) == [MODE]
