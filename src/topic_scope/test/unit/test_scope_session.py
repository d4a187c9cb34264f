"""Messages that a scope session sends to its pages; data source and sockets are fakes."""

import asyncio
import json
from pathlib import Path
from typing import Any, Dict, Iterator, List
from unittest import mock

import pytest
from bags import write_bag
from std_msgs.msg import Float64

from topic_scope.bag.overlay import BagOverlay
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.open_page import Page
from topic_scope.protocol import options, requests
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.recorder import Recorder
from topic_scope.web.field_selection import FieldSelection
from topic_scope.web.scope_session import ScopeSession
from topic_scope.web.http_server import master_message

SILENT = master_message("The master does not answer.")


class DataSource:
    """Data source of a graph without topics."""

    def __init__(self) -> None:
        values = {"clock.now.return_value": 1.7e9, "subscriptions.return_value": {}}
        self.source = mock.Mock(**values)
        self.layouts = Layouts()
        self.begin = 1.7e9
        self.start, self.refresh, self.leave = mock.Mock(), mock.Mock(), mock.Mock()
        self.read_again = None

    def hello(self) -> Dict[str, Any]:
        return {"readonly": False}

    def handlers(self) -> Dict[str, Handler]:
        return {}

    def messages(self) -> List[Dict[str, Any]]:
        return [{"type": "panels", "panels": []}, SILENT]


class PageSocket:
    """The connection of a page."""

    is_ready = True

    def __init__(self, session: ScopeSession) -> None:
        self.sent: List[Dict[str, Any]] = []
        self.page = session.open(self)  # type: ignore[arg-type]

    def send(self, messages: List[Dict[str, Any]]) -> None:
        self.sent += messages

    async def has_sent(self, message: Dict[str, Any], count: int) -> None:
        """Wait until it has sent a message several times."""
        while self.sent.count(message) < count:
            await asyncio.sleep(0.001)


@pytest.fixture
def source() -> DataSource:
    return DataSource()


@pytest.fixture(autouse=True)
def loop() -> Iterator[None]:
    made = asyncio.new_event_loop()
    asyncio.set_event_loop(made)
    yield
    asyncio.set_event_loop(None)
    made.close()


def session_of(source: DataSource, *arguments: str, bags: Any = ()) -> ScopeSession:
    return ScopeSession(options.parse(arguments), source, bags)  # type: ignore[arg-type]


@pytest.fixture
def session(source: DataSource) -> ScopeSession:
    return session_of(source)


def sent_to(session: ScopeSession, socket: PageSocket) -> Dict[str, Any]:
    """Return the latest messages to a page, by type, and forget them."""
    session.frames.send()
    sent, socket.sent[:] = list(socket.sent), []
    return {message["type"]: message for message in sent}


def test_page_before_first_topics_gets_master_state_only(session: ScopeSession) -> None:
    socket = PageSocket(session)
    session.frames.send()
    assert socket.sent == [SILENT]
    session.on_topics({})
    session.frames.send()
    types = [message["type"] for message in socket.sent[1:]]
    assert types[:4] == ["hello", "fields", "panels", "master"] and types[-1] == "frame"


def test_name_of_a_topic_is_replaced_by_its_fields_each_time(session: ScopeSession) -> None:
    session.on_topics({"/a": "geometry_msgs/Vector3"})
    socket = PageSocket(session)
    for _ in range(2):  # the second time, they are shown already
        session.handle(socket.page, json.dumps({"type": "select", "fields": ["/a"]}))
        session.frames.send()
        selected = [one["fields"] for one in socket.sent if one["type"] == "selected"]
        assert selected == [["/a/x", "/a/y", "/a/z"]]
        socket.sent.clear()


def test_idle_session_sends_alive_to_ready_pages_only(session: ScopeSession) -> None:
    session.on_topics({})
    reading, busy = PageSocket(session), PageSocket(session)
    session.halt()  # as during loading of a bag
    busy.is_ready = False
    session.frames.send_alive()
    assert (reading.sent, busy.sent) == ([{"type": "alive"}], [])


def test_alive_messages_are_repeated_without_frames(
    session: ScopeSession, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr("topic_scope.web.frame_sender.ALIVE_S", 0.001)
    socket, loop = PageSocket(session), asyncio.get_event_loop()
    session.frames.start()
    loop.run_until_complete(asyncio.wait_for(socket.has_sent({"type": "alive"}, 2), 30.0))


def test_message_replaces_only_an_unread_one_about_its_subject(session: ScopeSession) -> None:
    session.on_topics({})
    socket = PageSocket(session)
    sent_to(session, socket)
    for node, value in (("/a", 1), ("/b", 2), ("/a", 3)):
        session.send_to_pages({"type": "parameter", "value": value}, node)
    session.frames.send()
    values = [one["value"] for one in socket.sent if one["type"] == "parameter"]
    assert values == [2, 3]


def test_hello_message_has_protocol_version(session: ScopeSession) -> None:
    session.on_topics({})
    socket = PageSocket(session)
    session.frames.send()
    hello = socket.sent[0]
    assert (hello["type"], hello["protocol"]) == ("hello", requests.VERSION)
    assert (hello["history"], hello["defaults"]) == (60.0, {"window": 10.0})


def test_changes_of_topics_are_sent_to_the_pages_that_they_concern(source: DataSource) -> None:
    session = session_of(source, "/a")
    session.on_topics({})
    default, chosen = PageSocket(session), PageSocket(session)
    session.handle(chosen.page, json.dumps({"type": "select", "fields": ["/b/x"]}))
    session.handle(chosen.page, json.dumps({"type": "images", "topic": "/camera"}))
    for socket in (default, chosen):
        assert {"hello", "fields"} <= set(sent_to(session, socket))
    types = {"/a": "geometry_msgs/Vector3", "/camera": "sensor_msgs/Image"}
    session.on_topics(types)
    seen = sent_to(session, default)
    assert seen["hello"]["fields"] == list(seen["frame"]["traces"]) == ["/a/x", "/a/y", "/a/z"]
    assert seen["fields"]["types"] == types
    seen = sent_to(session, chosen)
    assert "fields" in seen and not {"hello", "selected"} & set(seen)
    assert sorted(source.source.want.call_args[0][0]) == ["/a", "/camera"]
    session.on_topics(types)
    assert not {"hello", "fields", "selected"} & set(sent_to(session, default))


def test_traces_beyond_those_of_a_page_are_left_out_and_reported(source: DataSource) -> None:
    names = [f"/a{number}" for number in range(20)]
    session = session_of(source, *names)
    session.on_topics(dict.fromkeys(names, "geometry_msgs/Vector3"))
    socket = PageSocket(session)
    text = "a page shows at most 32 traces: the rest of 60 are left out"
    seen = sent_to(session, socket)
    assert seen["error"]["text"] == text and len(seen["hello"]["fields"]) == 32
    session.handle(socket.page, json.dumps({"type": "select", "fields": names}))
    seen = sent_to(session, socket)
    assert seen["error"]["text"] == text and len(seen["selected"]["fields"]) == 32


def test_unknown_field_is_selected_with_its_problem(session: ScopeSession) -> None:
    session.on_topics({"/a": "geometry_msgs/Vector3"})
    socket = PageSocket(session)
    session.handle(socket.page, json.dumps({"type": "select", "fields": ["/a/w", "/a"]}))
    seen = sent_to(session, socket)
    assert seen["selected"]["fields"] == ["/a/w", "/a/x", "/a/y", "/a/z"]
    assert seen["error"]["text"] == "/a/w: there is no w in geometry_msgs/Vector3"


def test_no_frames_are_sent_while_the_clock_jumps(session: ScopeSession) -> None:
    session.on_topics({})
    socket = PageSocket(session)
    with mock.patch.object(Recorder, "forget") as forget:
        session.halt()
    forget.assert_called_once_with()
    session.on_topics({})
    assert "frame" not in sent_to(session, socket)
    with mock.patch.object(Recorder, "pin") as pin:
        session.resume()
        pin.assert_called_once_with({})
    assert sent_to(session, socket)["frame"]["reset"]


def test_moved_bag_is_sent_to_all_pages(source: DataSource, tmp_path: Path) -> None:
    bag = BagOverlay(write_bag(tmp_path / "old.bag", [("/a", Float64(1.0), 0)]), "old")
    session = session_of(source, bags=[bag])
    session.on_topics({})
    moving, other = PageSocket(session), PageSocket(session)
    sent_to(session, other)
    session.handle(moving.page, json.dumps({"type": "overlay", "name": "old", "offset": 2.0}))
    seen = sent_to(session, other)
    assert seen["overlays"]["bags"][0]["offset"] == 2.0 and seen["frame"]["reset"]


def test_request_for_fields_is_passed_on_at_once(source: DataSource, session: ScopeSession) -> None:
    session.on_topics({"/a": "geometry_msgs/Vector3", "/b": "geometry_msgs/Vector3"})
    page = PageSocket(session).page
    mask = {"type": "mask", "field": "/a/x", "reference": "/b/x", "value": 1.0, "time": 0.0}
    for request, topics in (({"type": "select", "fields": ["/a/x"]}, {"/a"}), (mask, {"/a", "/b"})):
        source.refresh.reset_mock()
        session.handle(page, json.dumps(request))
        source.refresh.assert_called_once_with()
        assert set(source.source.want.call_args[0][0]) == topics


def test_typed_formula_is_answered_with_its_problem(session: ScopeSession) -> None:
    session.on_topics({})
    socket = PageSocket(session)
    request = {"type": "formula", "text": "=a+1", "traces": ["/later/x"]}
    session.handle(socket.page, json.dumps(request))
    reply = sent_to(session, socket)["formula"]
    assert (reply["text"], reply["name"]) == ("=a+1", "=/later/x + 1")
    assert reply["problem"] == "/later/x: the topic does not exist yet"


def test_chosen_clock_moves_what_a_paused_page_keeps() -> None:
    recorder, page = mock.Mock(), Page(5.0)
    page.view.select(["/b/x"])
    page.view.show(requests.View(5.0, 100, 1e9))
    selection = FieldSelection([], recorder, mock.Mock(), lambda: [page])
    selection.choose_clock("/b", "/a")
    recorder.streams.choose_clock.assert_called_once_with("/b", "/a")
    recorder.pin.assert_called_once_with({"/b/x": (1e9 - 5.0, 1e9 + 1.0)})


def test_request_is_handled_or_rejected_with_a_reason(session: ScopeSession) -> None:
    page = PageSocket(session).page
    session.handle(page, '{"type": "view", "window": 3, "width": 100}')
    session.handle(page, '{"type": "chart", "kind": "xy", "x": "/a/x"}')
    session.handle(page, '{"type": "measure", "shapes": true}')
    assert page.view.window == 3.0 and page.chart.request.x == "/a/x" and page.measure.shapes
    page.pop_messages()
    for text in ("{", '{"type": "chart"}', '{"type": "nothing"}'):
        session.handle(page, text)
    assert [message["type"] for message in page.pop_messages()] == ["error"] * 3


def test_images_are_requested_until_their_last_page_closes(
    source: DataSource, session: ScopeSession
) -> None:
    session.on_topics({"/camera": "sensor_msgs/Image"})
    socket = PageSocket(session)
    session.handle(socket.page, '{"type": "images", "topic": "/camera"}')
    assert source.source.want.call_args == mock.call(["/camera"], True)
    session.close(socket)  # type: ignore[arg-type]
    assert source.source.want.call_args == mock.call([], False)
    source.leave.assert_called_once_with(socket.page)


def test_samples_of_a_paused_page_are_kept_until_it_closes(session: ScopeSession) -> None:
    session.on_topics({"/a": "std_msgs/Float64"})
    socket = PageSocket(session)
    session.handle(socket.page, '{"type": "select", "fields": ["/a/data"]}')
    with mock.patch.object(Recorder, "pin") as pin:
        session.handle(socket.page, '{"type": "view", "window": 5, "width": 100, "end": 1e9}')
        assert list(pin.call_args[0][0]) == ["/a/data"]
        session.close(socket)  # type: ignore[arg-type]
        assert pin.call_args == mock.call({})


def test_missing_field_of_command_line_is_logged(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("topic_scope.web.scope_session.WARN_AFTER_S", 0.0)
    session_of(DataSource(), "/later/x").on_topics({})
    with mock.patch("rospy.logwarn") as log:
        asyncio.get_event_loop().run_until_complete(asyncio.sleep(0.01))
    log.assert_called_once_with("/later/x: the topic does not exist yet")


def test_frame_error_of_one_page_does_not_stop_the_others(session: ScopeSession) -> None:
    session.on_topics({})
    broken, whole = PageSocket(session), PageSocket(session)
    broken.page.frame = mock.Mock(side_effect=ArithmeticError)  # type: ignore[method-assign]
    with mock.patch("rospy.logerr") as log:
        session.frames.send()
    assert "ArithmeticError" in log.call_args[0][1]
    assert not broken.sent and whole.sent[-1]["type"] == "frame"


def test_statistics_period_is_longer_than_frame_period(
    session: ScopeSession, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    session.on_topics({})
    page = PageSocket(session).page
    page.frame = mock.Mock(return_value=[])  # type: ignore[method-assign]
    page.watch = mock.Mock()  # type: ignore[method-assign]
    page.took = mock.Mock()  # type: ignore[method-assign]
    clock = mock.Mock(**{"thread_time.return_value": 0.0})
    monkeypatch.setattr("topic_scope.web.frame_sender.time", clock)
    for moment in (100.0, 100.1, 100.4, 100.5, 100.6):
        clock.monotonic.return_value = moment
        session.frames.send()
    assert [call[0][2] for call in page.frame.call_args_list] == [True, False, False, True, False]
    assert page.watch.call_count == 5 and page.took.call_args == mock.call(100.6, 100.6)


@pytest.mark.parametrize("why", ["busy", "resting"])
def test_skipped_frame_defers_statistics_to_the_next(
    session: ScopeSession, monkeypatch: "pytest.MonkeyPatch", why: str
) -> None:
    session.on_topics({})
    socket = PageSocket(session)
    socket.page.frame = mock.Mock(return_value=[])  # type: ignore[method-assign]
    clock = mock.Mock(**{"thread_time.return_value": 0.0})
    monkeypatch.setattr("topic_scope.web.frame_sender.time", clock)
    if why == "busy":
        socket.is_ready = False
    else:
        socket.page.took(100.0, 100.01)  # it rests for four times as long
        socket.page.took(100.0, 100.05)
    for moment in (100.0, 100.2, 100.25):
        clock.monotonic.return_value = moment
        session.frames.send()
        socket.is_ready = True
    assert [call[0][2] for call in socket.page.frame.call_args_list] == [True, False]
