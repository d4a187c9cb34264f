"""Tests of asking the nodes of a student for the types of their topics."""

import contextlib
import socket
import threading
import xmlrpc.server
from typing import Any, Iterator
from unittest import mock

import pytest

from pid_control.programs import node_queries
from pid_control.runner import test_bench


@contextlib.contextmanager
def node_that_replies(reply: Any) -> Iterator[str]:
    """Serve a node that has this reply to any question; give its URI."""
    server = xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
    for method in ("getPublications", "getSubscriptions", "getBusInfo"):
        server.register_function(lambda _caller: reply, method)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def test_ask_links_returns_connected_inputs() -> None:
    links = [
        [1, "/a", "i", "TCPROS", "/heard", True],
        [2, "/a", "o", "TCPROS", "/said", True],
        [3, "/a", "i", "TCPROS", "/lost", False],
        [4, "/a", "i", "TCPROS", "/old"],
    ]
    with node_that_replies([1, "", links]) as uri:
        assert node_queries.ask_links("/judge", uri) == {"/heard", "/old"}


def test_ask_types_returns_the_types_that_nodes_have() -> None:
    server = mock.MagicMock()
    proxy = server.return_value.__enter__.return_value
    proxy.getPublications.return_value = [1, "", [["/u", "a/U"]]]
    proxy.getSubscriptions.return_value = [1, "", [["/y", "a/Y"]]]
    with mock.patch("xmlrpc.client.ServerProxy", server):
        assert test_bench.ask_types({"/anna": "x"}) == ({"/u": "a/U", "/y": "a/Y"}, [])


def test_ask_types_reads_the_answers_of_a_node() -> None:
    with node_that_replies([1, "", [["/set_point", "anna/set_point"]]]) as uri:
        assert test_bench.ask_types({"/anna": uri}) == ({"/set_point": "anna/set_point"}, [])


@pytest.mark.parametrize("reply", [0, [1, ""], [1, "", 5], [1, "", [["/set_point"]]]])
def test_ask_types_reply_of_no_node_is_named(reply: Any) -> None:
    with node_that_replies(reply) as uri:
        assert test_bench.ask_types({"/anna": uri}) == ({}, ["/anna"])


def test_node_that_never_answers_is_named(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(node_queries, "_NODE_S", 0.1)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(5)
        uri = "http://127.0.0.1:{}/".format(listening.getsockname()[1])
        assert test_bench.ask_types({"/anna": uri}) == ({}, ["/anna"])
        with pytest.raises(socket.timeout):
            node_queries.ask_links("/judge", uri)


def test_ask_types_node_that_has_ended_is_left_out() -> None:
    with socket.socket() as bound:  # it does not listen
        bound.bind(("127.0.0.1", 0))
        uri = "http://127.0.0.1:{}/".format(bound.getsockname()[1])
        assert test_bench.ask_types({"/anna": uri}) == ({}, [])
