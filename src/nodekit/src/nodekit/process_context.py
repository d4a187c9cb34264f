# Pure: knows no ROS.
"""Context of this process: the state that all of its nodes share.

Each kind of state is a class of the module that uses it; the context creates its object at the
first use. So a lower module can share state without knowing the higher ones.
"""

import itertools
import threading
import weakref
from typing import Any, Callable, Dict, Iterator, Optional, Tuple, Type, TypeVar

T = TypeVar("T")


class ProcessContext:
    """Shared state of a process: single objects, sets of living objects, and numbers.

    :ivar exit_status: exit status of the process, unless its start is refused
    :ivar forks: number of forks between the start of the program and this process
    """

    def __init__(self) -> None:
        self.exit_status = 0
        self.forks = 0
        # A signal handler never waits for the thread that it interrupts: setdefault() is atomic,
        # and that thread may enter its own lock again.
        self._objects: Dict[Tuple[type, str], Any] = {}
        self._locks: Dict[Tuple[type, str], Any] = {}
        self._instances: Dict[type, "weakref.WeakSet[Any]"] = {}
        self._named: Dict[type, "weakref.WeakValueDictionary[str, Any]"] = {}
        self._numbers: Dict[type, Iterator[int]] = {}

    def get(self, cls: Type[T], create: Optional[Callable[[], T]] = None, name: str = "") -> T:
        """Return the process's only object of a class, created at the first call.

        :param cls: the class
        :param create: creates the object; the class itself by default
        :param name: distinguishes several objects of the class
        :raises Exception: from the creation, which the next call tries again
        """
        key = (cls, name)
        if key not in self._objects:
            with self._locks.setdefault(key, threading.RLock()):
                if key not in self._objects:
                    self._objects.setdefault(key, (create or cls)())
        found: T = self._objects[key]
        return found

    def find(self, cls: Type[T], name: str = "") -> Optional[T]:
        """Return the object that :meth:`get` has created, or None."""
        return self._objects.get((cls, name))

    def instances(self, cls: Type[T]) -> "weakref.WeakSet[T]":
        """Return the set of all objects of a class, to which they add themselves."""
        return self._instances.setdefault(cls, weakref.WeakSet())

    def by_name(self, cls: Type[T]) -> "weakref.WeakValueDictionary[str, T]":
        """Return the objects of a class by their names, under which they add themselves."""
        return self._named.setdefault(cls, weakref.WeakValueDictionary())

    def next_number(self, cls: type) -> int:
        """Return 1, 2, …: a number that the process has not used for this class."""
        return next(self._numbers.setdefault(cls, itertools.count(1)))


#: The context of this process.
PROCESS = ProcessContext()
