"""Start of the scope's node; ports, server and browser are fakes."""

import queue
from unittest import mock

import pytest

from topic_scope.nodes import scope


def test_browser_opens_the_page_at_the_port_in_use(monkeypatch: "pytest.MonkeyPatch") -> None:
    opened: "queue.Queue[str]" = queue.Queue()
    bound, run = mock.Mock(), mock.Mock()
    bound.getsockname.return_value = ("127.0.0.1", 8123)
    monkeypatch.setattr("sys.argv", ["scope.py", "--open-browser", "--next-port"])
    monkeypatch.setattr(scope.handlers, "bind", lambda _options: [bound])
    monkeypatch.setattr(scope.handlers, "open_browser", opened.put)
    monkeypatch.setattr(scope, "HttpServer", mock.Mock())
    monkeypatch.setattr(scope, "run", run)
    scope.main()
    assert opened.get(timeout=10.0) == "http://localhost:8123"
    assert run.call_args[0][0] == "scope_8123"
