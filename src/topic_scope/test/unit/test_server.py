"""What pages are sent, by a server whose origin and sockets are a test's own."""

import asyncio
from typing import Any, Dict, Iterator, List
from unittest import mock

import pytest

from topic_scope.messages.layouts import Layouts
from topic_scope.protocol import options, requests
from topic_scope.protocol.requests import Handler
from topic_scope.web.server import Server
from topic_scope.web.site import master_message

SILENT = master_message("The master does not answer.")


class Origin:
    """A graph without topics, of which nothing is known at first."""

    def __init__(self) -> None:
        self.source = mock.Mock(**{"clock.now.return_value": 1.7e9, "outlets.return_value": {}})
        self.layouts = Layouts()
        self.begin = 1.7e9
        self.start = self.ring = self.leave = mock.Mock()

    def hello(self) -> Dict[str, Any]:
        return {"readonly": False}

    def handlers(self) -> Dict[str, Handler]:
        return {}

    def messages(self) -> List[Dict[str, Any]]:
        return [{"type": "panels", "panels": []}, SILENT]


class Socket:
    """The connection of a page."""

    is_ready = True

    def __init__(self, server: Server) -> None:
        self.sent: List[Dict[str, Any]] = []
        self.page = server.open(self)  # type: ignore[arg-type]

    def send(self, messages: List[Dict[str, Any]]) -> None:
        self.sent += messages


@pytest.fixture
def server() -> Iterator[Server]:
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    yield Server(options.parse([]), Origin())  # type: ignore[arg-type]
    asyncio.set_event_loop(None)
    loop.close()


def test_a_page_hears_of_the_master_before_it_has_answered(server: Server) -> None:
    socket = Socket(server)
    server._send_frames()
    assert socket.sent == [SILENT]
    server.on_topics({})
    server._send_frames()
    types = [message["type"] for message in socket.sent[1:]]
    assert types[:4] == ["hello", "fields", "panels", "master"] and types[-1] == "frame"


def test_a_page_hears_that_the_scope_is_there_while_there_is_nothing_else(server: Server) -> None:
    server.on_topics({})
    reading, busy = Socket(server), Socket(server)
    server.halt()  # as while a bag is loaded
    busy.is_ready = False
    server._send_alive()
    assert (reading.sent, busy.sent) == ([{"type": "alive"}], [])


def test_the_greeting_tells_the_version_of_the_protocol(server: Server) -> None:
    server.on_topics({})
    socket = Socket(server)
    server._send_frames()
    assert (socket.sent[0]["type"], socket.sent[0]["protocol"]) == ("hello", requests.VERSION)


def test_a_request_is_obeyed_or_refused_in_words(server: Server) -> None:
    page = Socket(server).page
    server.handle(page, '{"type": "view", "window": 3, "width": 100}')
    server.handle(page, '{"type": "chart", "kind": "xy", "x": "/a/x"}')
    server.handle(page, '{"type": "measure", "shapes": true}')
    assert page.view.window == 3.0 and page.chart.request.x == "/a/x" and page.measure.shapes
    page.pop_messages()
    for text in ("{", '{"type": "chart"}', '{"type": "nothing"}'):
        server.handle(page, text)
    assert [message["type"] for message in page.pop_messages()] == ["error"] * 3


def test_fields_of_the_command_line_that_are_not_there_are_named_on_the_terminal(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("topic_scope.web.server.WARN_AFTER_S", 0.0)
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    try:
        server = Server(options.parse(["/later/x"]), Origin())  # type: ignore[arg-type]
        server.on_topics({})
        with mock.patch("rospy.logwarn") as log:
            loop.run_until_complete(asyncio.sleep(0.01))
    finally:
        asyncio.set_event_loop(None)
        loop.close()
    log.assert_called_once_with("/later/x: there is no such topic yet")


def test_what_goes_wrong_for_one_page_keeps_no_frame_from_the_others(server: Server) -> None:
    server.on_topics({})
    broken, whole = Socket(server), Socket(server)
    broken.page.frame = mock.Mock(side_effect=ArithmeticError)  # type: ignore[method-assign]
    with mock.patch("rospy.logerr_throttle") as log:
        server._send_frames()
    assert "ArithmeticError" in log.call_args[0][1]
    assert not broken.sent and whole.sent[-1]["type"] == "frame"


def test_traces_are_measured_now_and_then_not_for_each_frame(
    server: Server, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    server.on_topics({})
    page = Socket(server).page
    page.frame = mock.Mock(return_value=[])  # type: ignore[method-assign]
    clock = mock.Mock(**{"thread_time.return_value": 0.0})
    monkeypatch.setattr("topic_scope.web.server.time", clock)
    for moment in (100.0, 100.1, 100.3, 100.4, 100.5):
        clock.monotonic.return_value = moment
        server._send_frames()
    assert [call[0][2] for call in page.frame.call_args_list] == [True, False, False, True, False]


@pytest.mark.parametrize("why", ["busy", "resting"])
def test_a_page_that_gets_no_frame_when_traces_are_measured_has_figures_with_the_next(
    server: Server, monkeypatch: "pytest.MonkeyPatch", why: str
) -> None:
    server.on_topics({})
    socket = Socket(server)
    socket.page.frame = mock.Mock(return_value=[])  # type: ignore[method-assign]
    clock = mock.Mock(**{"thread_time.return_value": 0.0})
    monkeypatch.setattr("topic_scope.web.server.time", clock)
    if why == "busy":
        socket.is_ready = False
    else:
        socket.page.took(100.0, 100.01)  # it rests for four times as long
        socket.page.took(100.0, 100.05)
    for moment in (100.0, 100.2, 100.25):
        clock.monotonic.return_value = moment
        server._send_frames()
        socket.is_ready = True
    assert [call[0][2] for call in socket.page.frame.call_args_list] == [True, False]
