"""Services with a button on the page; nodes and threads are fakes."""

from types import SimpleNamespace
from typing import Any, Dict, List, Tuple

import pytest
import rosservice
from std_srvs.srv import SetBool, Trigger
from test_parameter_sender import SlowWorker

from topic_scope.controls import service_buttons


def test_only_services_of_the_two_known_types_have_a_button(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    types = {
        "/on": "std_srvs/SetBool",
        "/home": "std_srvs/Trigger",
        "/clear": "std_srvs/Empty",
        "/own": "other_srvs/SetBool",
    }

    def type_of(service: str) -> str:
        if service not in types:
            raise rosservice.ROSServiceIOException("no answer")
        return types[service]

    monkeypatch.setattr(rosservice, "get_service_type", type_of)
    kinds = {name: service_buttons.kind_of(name) for name in [*types, "/silent"]}
    assert kinds == {"/on": "SetBool", "/home": "Trigger", "/clear": "", "/own": "", "/silent": ""}


def test_calls_are_answered_with_the_result_of_the_service(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    calls: List[Tuple[Any, ...]] = []
    answers: List[Dict[str, Any]] = []
    worker = SlowWorker()

    def call_service(service: str, kind: Any, *arguments: Any, timeout: float) -> Any:
        calls.append((service, kind, *arguments))
        if service == "/silent":
            raise TimeoutError("no answer")
        reply = SimpleNamespace(success=arguments != (False,), message="said")
        return SimpleNamespace(result=lambda: reply)

    monkeypatch.setattr(service_buttons, "call_service", call_service)

    def call(service: str, kind: str, data: Any = None) -> None:
        service_buttons.call(worker, service, kind, data, answers.append)

    call("/on", "SetBool", True)
    call("/on", "SetBool", True)  # while the first has no answer
    worker.work.pop()()
    call("/on", "SetBool", False)
    worker.work.pop()()
    call("/home", "Trigger")
    worker.work.pop()()
    call("/silent", "Trigger")
    worker.work.pop()()
    with pytest.raises(ValueError, match="/on takes true or false"):
        call("/on", "SetBool")
    on, home = ("/on", SetBool), ("/home", Trigger)
    assert calls == [(*on, True), (*on, False), home, ("/silent", Trigger)]
    assert [(one["service"], one["success"], one["message"]) for one in answers] == [
        ("/on", False, "an earlier call has not been answered yet"),
        ("/on", True, "said"),
        ("/on", False, "said"),
        ("/home", True, "said"),
        ("/silent", False, "no answer"),
    ]
