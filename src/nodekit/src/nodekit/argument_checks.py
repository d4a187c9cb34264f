# Pure: knows no ROS.
"""Checks of arguments of nodekit's methods; errors point to the line of the call.

Otherwise the error would occur at the node's start or at the first message, far from that line.
"""

import inspect
import math
import numbers
from typing import Any, Callable, Optional

#: Longest time-out of a request [s].
LONGEST_S = 1e9


def check_name(name: object, what: str) -> None:
    """Check that a name is text.

    :param name: the argument
    :param what: subject of the name, for the error
    :raises TypeError: if it is not
    """
    if not isinstance(name, str):
        raise TypeError(f"{what}: refused {_shown(name)}: must be text")


def check_function(function: object, what: str, arguments: Optional[int] = None) -> None:
    """Check that a callback is a plain function.

    :param function: the argument
    :param what: purpose of the function, for the error
    :param arguments: number of arguments that it is called with; None to accept any
    :raises TypeError: if it is not callable, is a coroutine or generator function, or cannot be
        called with that number of arguments
    """
    if not callable(function):
        raise TypeError(f"{what}: refused {_shown(function)}: must be a function")
    for called in (function, getattr(type(function), "__call__")):
        if inspect.iscoroutinefunction(called) or inspect.isasyncgenfunction(called):
            advice = "write def, and in it asyncio.run(...) around what must be awaited"
            why = f"must not be async def, as it is never awaited: {advice}"
            raise TypeError(f"{what}: refused {_shown(function)}: {why}")
        if inspect.isgeneratorfunction(called):
            why = "must not have a yield, as it would do nothing: write return, or call a function"
            raise TypeError(f"{what}: refused {_shown(function)}: {why}")

    if arguments is not None and not isinstance(function, type):
        _check_arguments(function, what, arguments)


def _check_arguments(function: Callable[..., Any], what: str, arguments: int) -> None:
    try:
        # A decorator may call the function that it wraps with other arguments.
        signature = inspect.signature(function, follow_wrapped=False)
    except (TypeError, ValueError):  # C functions may lack a signature, proxies have a wrong one
        return
    try:
        signature.bind(*range(arguments))
    except TypeError:
        number = {0: "no argument", 1: "one argument"}.get(arguments, f"{arguments} arguments")
        given = ", ".join(signature.parameters)
        why = f"must take {number}, and its parameters are ({given})"
        raise TypeError(f"{what}: refused {_shown(function)}: {why}") from None


def check_message_class(given: object, topic: str) -> None:
    """Check the type of a topic.

    :param given: the argument
    :param topic: the topic, for the error
    :raises TypeError: if it is not a message class
    """
    if not (isinstance(given, type) and hasattr(given, "_md5sum") and hasattr(given, "serialize")):
        must = "must be a message class, such as std_msgs.msg.Float32"
        raise TypeError(f"topic {topic}: refused {_shown(given)}: {must}")


def check_service_class(given: object, service: str) -> None:
    """Check the type of a service.

    :param given: the argument
    :param service: the service, for the error
    :raises TypeError: if it is not a service class
    """
    if not (isinstance(given, type) and hasattr(given, "_request_class")):
        must = "must be a service class, such as std_srvs.srv.Trigger"
        raise TypeError(f"service {service}: refused {_shown(given)}: {must}")


def check_action_class(given: object, action: str) -> None:
    """Check the type of an action.

    :param given: the argument
    :param action: the action, for the error
    :raises TypeError: if it is not an action class
    """
    parts = {"action_goal", "action_result", "action_feedback"}
    if not (isinstance(given, type) and parts.issubset(getattr(given, "__slots__", ()))):
        must = "must be an action class, such as actionlib.msg.TestAction"
        raise TypeError(f"action {action}: refused {_shown(given)}: {must}")


def check_timeout(timeout: object) -> None:
    """Check the time-out of a request, which must be finite.

    :param timeout: the argument [s]
    :raises ValueError: if it is not in (0, LONGEST_S]
    """
    if not (isinstance(timeout, numbers.Real) and 0.0 < float(timeout) <= LONGEST_S):
        must = f"must be a number in (0, {LONGEST_S:g}]"
        raise ValueError(f"timeout: refused {timeout!r} s: {must}")


def check_wait(timeout: object) -> None:
    """Check the time-out of a wait, which may be infinite.

    :param timeout: the argument [s]; infinity for no limit
    :raises ValueError: if it is not a number
    """
    if not isinstance(timeout, numbers.Real) or math.isnan(timeout):
        must = "must be a number, or math.inf for no limit"
        raise ValueError(f"timeout: refused {timeout!r} s: {must}")


def _shown(given: object) -> str:
    """Return an argument as short text for an error message."""
    return str(getattr(given, "__qualname__", " ".join(repr(given).split())[:80]))
