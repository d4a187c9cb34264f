"""Base class of the demos: an executor chosen by a parameter, and a log of all calls."""

import contextlib
import sys
import threading
import time
from typing import Generic, List, Type, TypeVar, Union

import rospy

from executors_demo.call_log import CallLog
from nodekit import (
    EnumParameter,
    FloatParameter,
    IntParameter,
    MultiThreadedExecutor,
    Node,
    ParameterSet,
    SingleThreadedExecutor,
)

#: Time for a replaced executor to finish its waiting calls [s].
_DRAIN_S = 600.0

Executor = Union[SingleThreadedExecutor, MultiThreadedExecutor]


class ExecutorParameters(ParameterSet):
    """Parameters that choose the executor of a demo."""

    executor = EnumParameter("multi", choices=("single", "multi"), help="executor")
    threads = IntParameter(4, minimum=1, maximum=100, help="threads of the executor multi")

    def new_executor(self) -> Executor:
        """Return an executor with these settings."""
        if self.executor == "single":
            return SingleThreadedExecutor()
        return MultiThreadedExecutor(self.threads)


def period_of(default: float, what: str) -> FloatParameter:
    """Declare the period of a callback.

    :param default: time between calls [s]
    :param what: name of the callback
    """
    text = f"time between calls of {what}"
    return FloatParameter(default, minimum=0.001, maximum=3600.0, unit="s", help=text)


def sleep_of(default: float, what: str) -> FloatParameter:
    """Declare how long a callback sleeps, to simulate work.

    :param default: duration [s]
    :param what: name of the callback
    """
    text = f"duration of the sleep in a call of {what}"
    return FloatParameter(default, minimum=0.0, maximum=3600.0, unit="s", help=text)


Settings = TypeVar("Settings", bound=ExecutorParameters)


class Demo(Generic[Settings]):
    """Node whose callbacks run on an executor chosen by a parameter, even at run time.

    :param node: the node's API
    :param declaration: class that declares its parameters
    """

    def __init__(self, node: Node, declaration: Type[Settings]) -> None:
        self.parameters = node.declare_parameters(declaration, on_change=self._on_change)
        self._call_log = CallLog(_print)
        self._executor = self.parameters.values.new_executor()
        self._nodes: List[Node] = []
        self.add_node(node)

    @property
    def settings(self) -> Settings:
        """The parameters in force."""
        return self.parameters.values

    def add_node(self, node: Node) -> None:
        """Add a node to the executor.

        :param node: another node of this process
        """
        self._nodes.append(node)
        self._executor.add_node(node)

    def work(self, who: str, length: float, note: str = "") -> None:
        """Work for some time, and log its start and end.

        :param who: name of the callback, one word
        :param length: duration [s]
        :param note: subject of the call
        """
        with self._call_log.call(who, note):
            time.sleep(length)

    def _on_change(self, new: Settings, old: Settings) -> None:
        if (new.executor, new.threads) == (old.executor, old.threads):
            return
        previous, self._executor = self._executor, new.new_executor()
        for node in self._nodes:
            self._executor.add_node(node)
        # In another thread: shutdown waits for running calls, of which this is one.
        threading.Thread(target=previous.shutdown, args=(_DRAIN_S,), daemon=True).start()


def _print(line: str) -> None:
    rospy.loginfo("%s", line)
    with contextlib.suppress(OSError):  # the pipe is closed: nodekit reports that
        sys.stdout.flush()  # otherwise "| tee" shows lines late
