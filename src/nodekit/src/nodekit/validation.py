# Pure: knows no ROS.
"""Judge what a node's class hands to nodekit, so that an error comes at its own line.

Otherwise it would come at the node's start or at the first message, where nothing names that line.
"""

import inspect
import math
import numbers

#: The longest time-out of a request, s.
LONGEST_S = 1e9


def check_name(name: object, what: str) -> None:
    """Judge whether a name is text.

    :param name: what was given
    :param what: what it names, for the error
    :raises TypeError: if it is not
    """
    if not isinstance(name, str):
        raise TypeError(f"{what}: refused {_shown(name)}: must be text")


def check_function(function: object, what: str) -> None:
    """Judge what is to be called later.

    :param function: what was given
    :param what: what it is for, for the error
    :raises TypeError: if it cannot be called, or if that would only make a coroutine or a generator
    """
    if not callable(function):
        raise TypeError(f"{what}: refused {_shown(function)}: must be a function")
    for called in (function, getattr(type(function), "__call__")):
        if inspect.iscoroutinefunction(called) or inspect.isasyncgenfunction(called):
            advice = "write def, and in it asyncio.run(...) around what must be awaited"
            why = f"must not be async def, as nobody awaits it: {advice}"
            raise TypeError(f"{what}: refused {_shown(function)}: {why}")
        if inspect.isgeneratorfunction(called):
            why = "must not have a yield, as it would do nothing: write return, or call a function"
            raise TypeError(f"{what}: refused {_shown(function)}: {why}")


def check_message_class(given: object, topic: str) -> None:
    """Judge the type of a topic.

    :param given: what was given
    :param topic: the topic, for the error
    :raises TypeError: if it is not a message class
    """
    if not (isinstance(given, type) and hasattr(given, "_md5sum") and hasattr(given, "serialize")):
        must = "must be a message class, such as std_msgs.msg.Float32"
        raise TypeError(f"topic {topic}: refused {_shown(given)}: {must}")


def check_service_class(given: object, service: str) -> None:
    """Judge the type of a service.

    :param given: what was given
    :param service: the service, for the error
    :raises TypeError: if it is not a service class
    """
    if not (isinstance(given, type) and hasattr(given, "_request_class")):
        must = "must be a service class, such as std_srvs.srv.Trigger"
        raise TypeError(f"service {service}: refused {_shown(given)}: {must}")


def check_timeout(timeout: object) -> None:
    """Judge the time-out of a request, which must end.

    :param timeout: what was given, s
    :raises ValueError: if it is not one
    """
    if not (isinstance(timeout, numbers.Real) and 0.0 < float(timeout) <= LONGEST_S):
        must = f"must be a number in (0, {LONGEST_S:g}]"
        raise ValueError(f"timeout: refused {timeout!r} s: {must}")


def check_wait(timeout: object) -> None:
    """Judge how long to wait at most.

    :param timeout: what was given, s; infinity for ever
    :raises ValueError: if it is no number
    """
    if not isinstance(timeout, numbers.Real) or math.isnan(timeout):
        must = "must be a number, math.inf to wait as long as it takes"
        raise ValueError(f"timeout: refused {timeout!r} s: {must}")


def _shown(given: object) -> str:
    """Return what was given, as its author knows it."""
    return str(getattr(given, "__qualname__", " ".join(repr(given).split())[:80]))
