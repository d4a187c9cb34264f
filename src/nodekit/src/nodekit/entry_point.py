"""The first lines of a node's process, before rospy is imported, and the last ones."""

import contextlib
import importlib
import os
import signal
import sys
import types
from typing import Any, Iterator, NoReturn, Optional


def main(node: str) -> None:
    """Run the ``main`` of a node's module.

    :param node: name of the module, e.g. ``basic_comms.nodes.talker``
    """
    try:
        _replace_closed_output()
        with _ended_by_interrupt():
            import_ros()
            _judge_namespace()
            module = importlib.import_module(node)
        module.main()
    except KeyboardInterrupt:
        end(0)  # Ctrl-C before rospy took over the signal


def run_command(name: str) -> None:
    """Run a command of nodekit, as ``rosrun nodekit NAME`` does.

    :param name: its name, e.g. ``describe``
    """
    importlib.import_module(f"nodekit.commands.{name}").main()


def end(status: object) -> NoReturn:
    """End the process with a status that no further signal changes.

    Python gives up its handlers before it has ended, so that a SIGTERM soon after a SIGINT would
    kill it; what is ignored stays so. Called by the main thread.

    :param status: as for ``sys.exit``
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    sys.exit(status)  # type: ignore[arg-type]


def _replace_closed_output() -> None:
    """Let a node write where it was started without an output, as by ``>&-``: nobody reads it.

    Python has no object for it then, and the first line of rospy's log would end the node.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))


@contextlib.contextmanager
def _ended_by_interrupt() -> Iterator[None]:
    """End the process at Ctrl-C, at once.

    Much of what is imported takes any exception for something optional that is missing: one that
    Ctrl-C raised would be swallowed now and then, and the node start all the same.
    """
    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:  # ignored, as in the background of a script
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: os._exit(0))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _judge_namespace() -> None:
    """End with a sentence where rospy could not be imported because of its namespace."""
    names = importlib.import_module("nodekit.node.name_rules")
    try:
        names.check_namespace(os.environ, sys.argv)
    except names.IllegalName as error:
        end(str(error))


def import_ros() -> None:
    """Leave out what ROS imports and a node does not need: a third of the time of all imports.

    The messages import numpy wherever it is installed, only to take its numbers as well as
    Python's: 30 ms and 14 MB (measured on Debian 12). roslib imports catkin's search for files,
    which rospy never asks for, and that a parser generator: 40 ms. Both are there again for
    whoever wants them afterwards.
    """
    with _stand_in("numpy", None):
        importlib.import_module("genpy.message")
    catkin = "catkin.find_in_workspaces"
    with _stand_in(catkin, _late(catkin, "find_in_workspaces")):
        importlib.import_module("roslib.packages")


@contextlib.contextmanager
def _stand_in(name: str, module: Optional[types.ModuleType]) -> Iterator[None]:
    """Put a module in place of another, unless that is there already.

    :param name: full name of the module
    :param module: what is imported instead; None for an ImportError
    """
    if name in sys.modules:
        yield
        return
    sys.modules[name] = module  # type: ignore[assignment]
    try:
        yield
    finally:
        if sys.modules.get(name) is module:
            del sys.modules[name]


def _late(name: str, function: str) -> types.ModuleType:
    """Return a module with a function that imports the true one when it is called.

    :param name: full name of the module
    :param function: name of the function
    """

    def call(*args: Any, **kwds: Any) -> Any:
        return getattr(importlib.import_module(name), function)(*args, **kwds)

    module = types.ModuleType(name)
    setattr(module, function, call)
    return module
