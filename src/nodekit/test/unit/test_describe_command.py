"""Tests of the width of the output of the command describe."""

import os
import sys
import threading
from concurrent.futures import Future
from typing import Any, Callable

import pytest
from std_srvs.srv import TriggerResponse

from nodekit import BoolParameter, ParameterSet
from nodekit.commands import describe as command
from nodekit.node.clients import CallError
from nodekit.parameters.schema import as_yaml, describe


class Switch(ParameterSet):
    """A parameter with much to say."""

    on = BoolParameter(True, help="on or off, " * 30)


@pytest.fixture
def lines(monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]") -> Any:
    """Return the lines that describe a node, without a graph."""

    class Master:
        def __init__(self, _name: str) -> None:
            pass

        def namespaces_offering(self, _service: str, namespace: str) -> Any:
            return [namespace.rstrip("/")]

    def answer(*_arguments: Any) -> "Future[TriggerResponse]":
        future: "Future[TriggerResponse]" = Future()
        future.set_result(TriggerResponse(True, as_yaml(describe(Switch()))))
        return future

    def printed() -> Any:
        with pytest.raises(SystemExit) as ended:
            command.main()
        assert ended.value.code == 0
        return capsys.readouterr().out.splitlines()

    monkeypatch.setattr(command, "MasterClient", Master)
    monkeypatch.setattr(command, "call_service", answer)
    monkeypatch.setattr(sys, "argv", ["describe", "/switch"])
    return printed


def test_it_is_as_wide_as_the_terminal(monkeypatch: "pytest.MonkeyPatch", lines: Any) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    assert 90 < max(map(len, lines())) <= 100
    monkeypatch.setenv("COLUMNS", "1000")
    assert len(lines()) == 2


def test_a_pipe_has_80_columns(monkeypatch: "pytest.MonkeyPatch", lines: Any) -> None:
    def refuse(_descriptor: int) -> os.terminal_size:
        raise OSError("no terminal")

    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr(os, "get_terminal_size", refuse)
    node, *table = lines()
    assert node == "/switch"
    assert len(table) > 1 and 70 < max(map(len, table)) <= 80


def unanswered(future: "Future[Any]") -> None:
    future.set_exception(CallError("no answer within 2 s"))


def somebody_elses(future: "Future[Any]") -> None:
    future.set_result(TriggerResponse(True, "a door"))


@pytest.mark.parametrize(
    "end, why",
    [
        (unanswered, " does not answer: no answer within 2 s"),
        (somebody_elses, "/describe does not describe parameters"),
    ],
)
def test_status_and_names_report_one_undescribed_node_of_many(
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    lines: Any,
    end: Callable[["Future[Any]"], None],
    why: str,
) -> None:
    names = [f"/robot{number:02}" for number in range(2 * command._TOGETHER + 1)]
    mute, answer = names[3], command.call_service

    def answer_but_one(service: str, kind: Any) -> Any:
        future = answer(service, kind)
        if service.startswith(mute + "/"):
            future = Future()
            end(future)
        return future

    monkeypatch.setattr(command, "call_service", answer_but_one)
    monkeypatch.setattr(command.MasterClient, "namespaces_offering", lambda *_: names)
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 1
    printed = capsys.readouterr()
    told = [line for line in printed.out.splitlines() if line.startswith("/")]
    assert told == [name for name in names if name != mute]
    assert printed.err == f"describe: {mute}{why}\n"


def test_slow_node_is_described_before_one_that_is_slower(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]", lines: Any
) -> None:
    calls = {name: command.call_service(name, None) for name in ("/a/describe", "/b/describe")}
    (response,) = {call.result().message for call in calls.values()}
    calls = {name: Future() for name in calls}
    described, table = [], command.as_table

    def describe_and_end(*arguments: Any) -> str:
        described.append([name for name, call in calls.items() if call.done()])
        if not calls["/a/describe"].done():
            unanswered(calls["/a/describe"])
        return table(*arguments)

    monkeypatch.setattr(command, "_ORDER_S", 0.0)
    monkeypatch.setattr(command, "as_table", describe_and_end)
    monkeypatch.setattr(command, "call_service", lambda name, _: calls[name])
    monkeypatch.setattr(command.MasterClient, "namespaces_offering", lambda *_: ["/a", "/b"])
    threading.Timer(
        0.05, calls["/b/describe"].set_result, [TriggerResponse(True, response)]
    ).start()
    guard = threading.Timer(5.0, calls["/a/describe"].cancel)
    guard.start()
    with pytest.raises(SystemExit):
        command.main()
    guard.cancel()
    assert described == [["/b/describe"]]
    assert capsys.readouterr().err == "describe: /a does not answer: no answer within 2 s\n"
