# Pure: knows no ROS.
"""Old names of the public API: they work in all of 1.x, and each warns once."""

import warnings
from typing import Any, Callable, Dict, Set

from nodekit.process_context import PROCESS

#: Names that the package itself had, and the new ones.
OLD_NAMES: Dict[str, str] = {"give_up": "abort", "Latest": "LatestMessage"}


class WarnedNames(Set[str]):
    """Old names about which the process has warned."""


def warn_once(old: str, new: str) -> None:
    """Warn about the use of an old name, once per process, at the line of the caller's caller.

    :param old: the name
    :param new: what to use instead
    """
    warned = PROCESS.get(WarnedNames)
    if old not in warned:
        warned.add(old)
        text = f"{old}: deprecated name; use {new}"
        warnings.warn(text, DeprecationWarning, stacklevel=3)


class OldMethod:
    """An old name of a method, as an attribute of its class.

    :param new: name of the method
    :param keywords: new names of its arguments by their old ones, where they differ
    """

    def __init__(self, new: str, **keywords: str) -> None:
        self._new, self._keywords = new, keywords
        self._old = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._old = name

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        warn_once(f"{self._old}()", f"{self._new}()")
        method: Callable[..., Any] = getattr(instance, self._new)
        if not self._keywords:
            return method
        return lambda *args, **kwds: method(
            *args, **{self._keywords.get(name, name): value for name, value in kwds.items()}
        )
