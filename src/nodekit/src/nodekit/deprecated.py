# Pure: knows no ROS.
"""Old names of the public API: they work in all of 1.x, and each warns once."""

import warnings
from typing import Any, Callable, Dict, Set

#: Names that the package itself had, and the new ones.
OLD_NAMES: Dict[str, str] = {"give_up": "abort", "Latest": "LatestMessage"}

_warned: Set[str] = set()


def warn_once(old: str, new: str, stacklevel: int = 3) -> None:
    """Warn about the use of an old name, once per process.

    :param old: the name
    :param new: what to use instead
    :param stacklevel: which caller the warning points to, see :func:`warnings.warn`
    """
    if old not in _warned:
        _warned.add(old)
        text = f"{old}: deprecated name; use {new}"
        warnings.warn(text, DeprecationWarning, stacklevel)


class OldMethod:
    """An old name of a method, as an attribute of its class.

    :param new: name of the method
    :param keywords: new names of its arguments by their old ones, where they differ
    """

    def __init__(self, new: str, **keywords: str) -> None:
        self._new, self._keywords = new, keywords
        self._old = self._full_new = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._old, self._full_new = f"{owner.__name__}.{name}", f"{owner.__name__}.{self._new}"

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        warn_once(self._old, self._full_new)
        method: Callable[..., Any] = getattr(instance, self._new)
        if not self._keywords:
            return method
        return lambda *args, **kwds: method(
            *args, **{self._keywords.get(name, name): value for name, value in kwds.items()}
        )
