"""Base of the demos: an executor that a parameter chooses, and a log of all calls."""

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

#: How long an executor that was exchanged may take for the calls that still wait for it, s.
_DRAIN_S = 600.0

Executor = Union[SingleThreadedExecutor, MultiThreadedExecutor]


class ExecutorParameters(ParameterSet):
    """Which executor makes the calls of a demo."""

    executor = EnumParameter("multi", choices=("single", "multi"), help="executor")
    threads = IntParameter(4, minimum=1, maximum=100, help="threads of the executor multi")

    def new_executor(self) -> Executor:
        """Return an executor as these values have it."""
        if self.executor == "single":
            return SingleThreadedExecutor()
        return MultiThreadedExecutor(self.threads)


def period_of(default: float, what: str) -> FloatParameter:
    """Declare how often something is called.

    :param default: time between calls, s
    :param what: what is called
    """
    text = f"time between calls of {what}"
    return FloatParameter(default, minimum=0.001, maximum=3600.0, unit="s", help=text)


def sleep_of(default: float, what: str) -> FloatParameter:
    """Declare how long a call sleeps, which stands for work that takes its time.

    :param default: length, s
    :param what: what is called
    """
    text = f"how long a call of {what} sleeps"
    return FloatParameter(default, minimum=0.0, maximum=3600.0, unit="s", help=text)


Settings = TypeVar("Settings", bound=ExecutorParameters)


class Demo(Generic[Settings]):
    """A node whose callbacks an executor calls; a parameter chooses it, also while it runs.

    :param node: what it makes everything through
    :param declaration: the class that declares its parameters
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
        """Have the executor call the callbacks of a node, too.

        :param node: another node of this process
        """
        self._nodes.append(node)
        self._executor.add_node(node)

    def work(self, who: str, length: float, note: str = "") -> None:
        """Work for some time, and log when that begins and ends.

        :param who: what is called; one word
        :param length: how long it takes, s
        :param note: what the call is about
        """
        with self._call_log.call(who, note):
            time.sleep(length)

    def _on_change(self, new: Settings, old: Settings) -> None:
        if (new.executor, new.threads) == (old.executor, old.threads):
            return
        previous, self._executor = self._executor, new.new_executor()
        for node in self._nodes:
            self._executor.add_node(node)
        # Beside: it waits for the calls under way, and this is one of them.
        threading.Thread(target=previous.shutdown, args=(_DRAIN_S,), daemon=True).start()


def _print(line: str) -> None:
    rospy.loginfo("%s", line)
    with contextlib.suppress(OSError):  # the pipe's reader has gone: nodekit reports that
        sys.stdout.flush()  # or else "| tee" shows nothing for a while
