"""Calls of SetBool and Trigger services, for which pages show buttons."""

from typing import Any, Callable, Dict, List

import rosservice
from std_srvs.srv import SetBool, Trigger

from nodekit import call_service
from topic_scope.graph.worker import Worker

#: Timeout of a call [s]; some services first do their work, e.g. drive a robot home.
_ANSWER_S = 60.0
_CLASSES = {"SetBool": SetBool, "Trigger": Trigger}


def type_of(service: str) -> str:
    """Return the type of a service, empty if its node does not answer; waits for the node.

    :param service: its name
    """
    try:
        return str(rosservice.get_service_type(service))
    except rosservice.ROSServiceIOException:
        return ""


def kind_of(service: str) -> str:
    """Return SetBool or Trigger, empty for a service of another type; waits for its node.

    :param service: its name
    """
    package, _, kind = type_of(service).partition("/")
    return kind if package == "std_srvs" and kind in _CLASSES else ""


def call(
    worker: Worker,
    service: str,
    kind: str,
    data: Any,
    answer: Callable[[Dict[str, Any]], None],
) -> None:
    """Call a service without blocking.

    :param worker: worker that waits for the reply
    :param service: its name
    :param kind: SetBool or Trigger
    :param data: for SetBool, the Boolean
    :param answer: receives the reply
    :raises ValueError: if the data have the wrong type
    """
    if kind == "SetBool" and data is None:
        raise ValueError(f"{service} takes true or false")
    arguments: List[Any] = [data] if kind == "SetBool" else []

    def on_result(result: Any) -> None:
        failed = isinstance(result, Exception)
        success = not failed and bool(result.success)
        text = str(result) if failed else result.message
        answer({"type": "called", "service": service, "success": success, "message": text})

    def work() -> Any:
        return call_service(service, _CLASSES[kind], *arguments, timeout=_ANSWER_S).result()

    if not worker.run(("call", service), work, on_result):
        on_result(RuntimeError("an earlier call has not been answered yet"))
