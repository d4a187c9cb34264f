"""Responses to pages before the scope is ready."""

import asyncio
import errno
import gc
from typing import Any, Dict, List
from unittest import mock

import pytest
from tornado.websocket import WebSocketClosedError

from topic_scope.protocol.options import parse
from topic_scope.web import handlers
from topic_scope.web.http_server import HttpServer, PlaceholderScope

URI = "http://localhost:11311"
SENTENCE = f"There is no ROS master at {URI} yet: the scope waits for it."


class FakeConnection:
    """Connection that stores its messages about the master."""

    def __init__(self) -> None:
        self.texts: List[str] = []

    def send(self, messages: List[Dict[str, Any]]) -> None:
        self.texts += [message["text"] for message in messages if message["type"] == "master"]


def test_missing_master_is_reported_only_once_known() -> None:
    waiting = PlaceholderScope(URI, 10.0)
    early, late, gone = FakeConnection(), FakeConnection(), FakeConnection()
    waiting.open(early)
    waiting.open(gone)
    waiting.close(gone)
    assert early.texts == [""]
    waiting.miss()
    waiting.open(late)
    assert early.texts == ["", SENTENCE]
    assert late.texts == [SENTENCE]
    assert gone.texts == [""]


def test_failed_start_is_reported_instead_of_waited_for(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(handlers, "serve", mock.Mock(side_effect=OSError("no sockets")))
    with pytest.raises(OSError, match="no sockets"):
        HttpServer(parse([]), [])


def test_message_to_a_page_that_is_closed_meanwhile_is_no_error() -> None:
    problems: List[Any] = []

    async def send() -> None:
        loop = asyncio.get_event_loop()
        loop.set_exception_handler(lambda _, problem: problems.append(problem))
        written = loop.create_future()
        page = mock.Mock(**{"write_message.return_value": written})
        handlers.PageSocket.send(page, [{"type": "alive"}])
        written.set_exception(WebSocketClosedError())
        await asyncio.sleep(0)

    asyncio.run(send())
    gc.collect()  # a future reports an exception that was never retrieved when it is freed
    assert problems == []


def test_next_port_is_tried_only_if_one_is_taken(monkeypatch: "pytest.MonkeyPatch") -> None:
    taken, refused = OSError(errno.EADDRINUSE, "in use"), OSError(errno.EACCES, "not allowed")
    bind = mock.Mock(side_effect=[taken, ["socket"], refused])
    monkeypatch.setattr("tornado.netutil.bind_sockets", bind)
    options = parse(["--port", "8090", "--next-port"])
    assert handlers.bind(options) == ["socket"]
    assert [call[0][0] for call in bind.call_args_list] == [8090, 8091]
    with pytest.raises(OSError, match="not allowed"):
        handlers.bind(options)
