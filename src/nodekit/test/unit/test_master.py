"""Tests of the client of the master, with real and fake masters."""

import contextlib
import http.server
import signal
import socket
import threading
import time
from typing import Any, Iterator, List
from xmlrpc.client import Fault
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from nodekit import master as client_of_master
from nodekit.master import MasterClient, MasterUnreachable, SystemState
from nodekit.parameter_server.live_parameters import write_missing
from nodekit.parameters.declaration import FloatParameter, ParameterSet, StringParameter
from nodekit.parameters.parameter_types import MISSING, UNREADABLE
from nodekit.testing import processes
from nodekit.testing.processes import free_port

PAGE = b"<!DOCTYPE html><html><body><p>Please log in<br></body></html>"


@contextlib.contextmanager
def served(server: Any) -> Iterator[str]:
    """Run a server; return its URI."""
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    try:
        yield f"http://localhost:{server.server_address[1]}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@contextlib.contextmanager
def answering(body: bytes) -> Iterator[MasterClient]:
    """Answer each request by a server that is not a master."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: Any) -> None:
            pass

    with served(http.server.HTTPServer(("localhost", 0), Handler)) as uri:
        yield MasterClient("/n", "http://localhost:1/", master_uri=uri)


class Master:
    """As much of a master as the client needs; keeps count of the calls in each request."""

    def __init__(self) -> None:
        self.held = {"/n": {"level": 1.0}, "/n/level": 1.0}
        self.big = False
        self.requests: List[int] = []

    def _dispatch(self, method: str, arguments: Any) -> Any:
        if method == "system.multicall":
            (calls,) = arguments
            self.requests.append(len(calls))
            return [[self._dispatch(call["methodName"], call["params"])] for call in calls]
        assert arguments[0] == "/n"
        if method == "getParam" and arguments[1] not in [*self.held, "/n/big"]:
            return [-1, "not set", 0]
        return [1, "", getattr(self, method)(*arguments[1:])]

    def getPid(self) -> int:
        return 7

    def lookupNode(self, name: str) -> str:
        return "http://localhost:1/"

    def getParam(self, key: str) -> Any:
        if key in ("/n/big", "/n") and self.big:
            raise Fault(1, "int exceeds XML-RPC limits")
        return self.held[key]

    def getParamNames(self) -> List[str]:
        return ["/n/level", "/n/big", "/nn/other"]

    def setParam(self, key: str, value: Any) -> int:
        self.held[key] = value
        return 0

    def getSystemState(self) -> Any:
        return [[["/t", ["/n"]]], [], [["/n/describe", ["/n"]]]]

    def getTopicTypes(self) -> Any:
        return [["/t", "std_msgs/String"]]


@contextlib.contextmanager
def master() -> Iterator[Any]:
    """Run a master; return it and a client."""
    instance = Master()
    server = SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    server.register_instance(instance)
    with served(server) as uri:
        client = MasterClient("/n", "http://localhost:1/", master_uri=uri)
        with contextlib.closing(client):
            yield instance, client


def test_any_number_of_calls_is_divided_among_a_few_requests() -> None:
    with master() as (instance, client):
        client.write({f"/n/{number}": number for number in range(1201)})
        assert instance.requests == [500, 500, 201]
        assert client.read(["/n/3", "/n/1200"]).values == {"/n/3": 3, "/n/1200": 1200}
        client.request([])
        assert instance.requests[3:] == [4]


def test_system_state_and_topic_types() -> None:
    with master() as (_, client):
        state = client.system_state()
        assert state.publishers == [("/t", ["/n"])]
        assert state.services == [("/n/describe", ["/n"])]
        assert client.topic_types() == {"/t": "std_msgs/String"}


@pytest.mark.parametrize(
    "below, found",
    [
        ("/", ["/robot1/arm", "/robot1/base", "/robot10/base"]),
        ("/robot1", ["/robot1/arm", "/robot1/base"]),
        ("/robot10/base", ["/robot10/base"]),
    ],
)
def test_namespaces_of_a_service_are_at_or_below_a_name(
    monkeypatch: "pytest.MonkeyPatch", below: str, found: List[str]
) -> None:
    names = ["/robot10/base/change", "/robot1/base/change", "/robot1/arm/change", "/robot1/stop"]
    state = SystemState([], [], [(name, ["/n"]) for name in names])
    monkeypatch.setattr(MasterClient, "system_state", lambda _client: state)
    client = MasterClient("/n", master_uri="http://localhost:1/")
    assert client.namespaces_offering("change", below) == found


def test_value_that_cannot_be_sent_hides_no_other() -> None:
    with master() as (instance, client):
        instance.big = True
        assert client.read(["/n"]).values == {"/n": {"level": 1.0, "big": UNREADABLE}}


def test_two_alternating_responses_are_parsed_once_each(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    parsed: List[bytes] = []
    parse = client_of_master._parse
    monkeypatch.setattr(client_of_master, "_parse", lambda text: parsed.append(text) or parse(text))
    with master() as (instance, client):
        for _ in range(3):
            assert client.read(["/n/level"]).values == {"/n/level": 1.0}
            assert client.topic_types() == {"/t": "std_msgs/String"}
        assert len(parsed) == 2
        instance.setParam("/n/level", 2.0)
        assert client.read(["/n/level"]).values == {"/n/level": 2.0}


class Levels(ParameterSet):
    level = FloatParameter(2.0, help="how high")
    name = StringParameter("x", help="what it is called")


def test_only_missing_values_of_many_namespaces_are_written() -> None:
    with master() as (instance, client):
        spaces = [f"/g{number}" for number in range(45)]
        instance.held.update(dict.fromkeys(spaces[2:-1], {"level": 2.0, "name": "x"}))
        instance.held.update({"/g0": {"level": 7.0, "more": 1}, "/g1": "no namespace"})
        write_missing(client, {"/n": Levels(), **dict.fromkeys(spaces, Levels(level=3.0))})
        written = {key: value for key, value in instance.held.items() if key.count("/") == 2}
        assert written == {
            "/n/level": 1.0,
            "/n/name": "x",
            "/g0/name": "x",
            "/g44/level": 3.0,
            "/g44/name": "x",
        }


def test_reading_detects_a_restart() -> None:
    with master() as (instance, client):
        reading = client.read(["/n"])
        assert (reading.knows_node, reading.master_pid) == (True, 7)


@pytest.mark.parametrize(
    "body",
    [
        PAGE,
        b"",
        b"\xff\xfe",
        b"<html></html>",
        b"<methodResponse></methodResponse>",
        b"<methodResponse><params><param><value><int>x</int></value></param></params>"
        b"</methodResponse>",
        b"<methodResponse><params><param><value><int>1</int></value></param></params>"
        b"</methodResponse>",
        b"<methodResponse><params><param><value>four</value></param></params></methodResponse>",
        b"<methodResponse><params><param><value><array><data></data></array></value></param>"
        b"</params></methodResponse>",
        b"<methodResponse><params><param><value><array><data><value>a</value><value>b</value>"
        b"<value>c</value></data></array></value></param></params></methodResponse>",
        b"</value>",
        b"<methodResponse></array></methodResponse>",
    ],
)
def test_invalid_responses_are_not_from_a_master(body: bytes) -> None:
    with answering(body) as client:
        for ask in (
            lambda: client.read(["/n"]),
            client.system_state,
            client.topic_types,
            lambda: client.lookup_service("/n/describe"),
            lambda: client.write({"/n": 1}),
        ):
            with pytest.raises(MasterUnreachable, match="http://localhost"):
                ask()


@pytest.mark.parametrize(
    "uri", ["ftp://localhost/", "nonsense", "http://localhost:nonsense/", "http://./"]
)
def test_uri_that_leads_nowhere(uri: str) -> None:
    with pytest.raises(MasterUnreachable, match=uri[:4]):
        MasterClient("/n", master_uri=uri).read([])


def test_no_listening_master() -> None:
    with pytest.raises(MasterUnreachable, match="refused"):
        MasterClient("/n", master_uri=f"http://localhost:{free_port()}/").read([])


def test_silence_is_waited_for_no_longer_than_the_time_out() -> None:
    with socket.socket() as silent:
        silent.bind(("localhost", 0))
        silent.listen(5)
        client = MasterClient("/n", "", 0.1, f"http://localhost:{silent.getsockname()[1]}/")
        before = time.monotonic()
        with pytest.raises(MasterUnreachable, match="timed out"):
            client.read(["/n"])
        with pytest.raises(MasterUnreachable, match="timed out"):
            client.unsubscribe(["/n"], timeout=0.1)
        assert time.monotonic() - before < 15.0


def test_master_that_is_stopped_is_waited_for_no_longer_than_the_time_out() -> None:
    real = processes.Master()
    try:
        # Over an existing connection: opening one has a separate time-out.
        client = MasterClient("/n", "http://localhost:1/", 3.0, real.uri)
        with contextlib.closing(client):
            pid = client.read([]).master_pid
            real.send_signal(signal.SIGSTOP)
            before = time.monotonic()
            with pytest.raises(MasterUnreachable, match="timed out"):
                client.read([])
            assert time.monotonic() - before < 15.0
            real.send_signal(signal.SIGCONT)
            answered = MasterClient("/n", "http://localhost:1/", master_uri=real.uri)
            with contextlib.closing(answered):
                assert answered.read([]).master_pid == pid
    finally:
        real.kill()


def test_unset_key_is_missing() -> None:
    class Empty(Master):
        def _dispatch(self, method: str, arguments: Any) -> Any:
            if method == "getParam":
                return [-1, "Parameter is not set", 0]
            return super()._dispatch(method, arguments)

    server = SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    server.register_instance(Empty())
    with served(server) as uri:
        client = MasterClient("/n", master_uri=uri)
        with contextlib.closing(client):
            assert client.read(["/n"]).values == {"/n": MISSING}
