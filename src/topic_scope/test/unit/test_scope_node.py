"""Start of the scope's node; ports, server and browser are fakes."""

import errno
import queue
from typing import List
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


@pytest.mark.parametrize(
    "arguments, text",
    [
        (["--port", "65535"], "port 65535 is taken, perhaps by another scope: close that, or use "),
        (["--port", "65530", "--next-port"], "ports 65530 to 65535 are taken: use --port 8080"),
        (["--port", "8090", "--next-port"], "ports 8090 to 8189 are taken: use --port 8190"),
    ],
)
def test_taken_port_names_one_to_try(
    monkeypatch: "pytest.MonkeyPatch", arguments: List[str], text: str
) -> None:
    monkeypatch.setattr("sys.argv", ["scope.py", *arguments])
    error = OSError(errno.EADDRINUSE, "in use")
    monkeypatch.setattr(scope.handlers, "bind", mock.Mock(side_effect=error))
    with pytest.raises(SystemExit) as caught:
        scope.main()
    assert str(caught.value).startswith(f"scope.py: {text}")
    assert "--port 8080" in str(caught.value) or "8190" in text
