"""Entry point of node scripts: imports only needed parts of rospy, and calls a module's main."""

import atexit
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
        with ended_by_interrupt():
            import_ros()
            _check_namespace()
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
    """End the process with a status that no further signal changes, and no thread that runs on.

    Python resets its handlers before it has ended, so that a SIGTERM soon after a SIGINT would kill
    it; an ignored signal stays ignored. Python before 3.14 may also crash while it clears its
    modules, if a daemon thread wakes up meanwhile (python/cpython#87135), and rospy leaves several:
    the process ends after the exit handlers, before that. Must be called by the main thread.

    :param status: as for ``sys.exit``
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    atexit.register(_end_after_exit_handlers, status)
    sys.exit(status)  # type: ignore[arg-type]


def _end_after_exit_handlers(status: object) -> NoReturn:
    """Call the other exit handlers, then end the process.

    The handler that is registered last is called first.
    """
    atexit.unregister(_end_after_exit_handlers)
    with contextlib.suppress(BaseException):  # Python 3.8 raises what it has printed
        atexit._run_exitfuncs()
    end_at_once(status)


def end_at_once(status: object) -> NoReturn:
    """End the process without its exit handlers.

    :param status: as for ``sys.exit``, but a text is not printed
    """
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):  # closed or None
            stream.flush()
    os._exit(status & 0xFF if isinstance(status, int) else int(status is not None))


def _replace_closed_output() -> None:
    """Replace an output that is closed at the start, as by ``>&-``, by the null device.

    Python has no object for it then, and the first line of rospy's log would end the node.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))


@contextlib.contextmanager
def ended_by_interrupt(status: int = 0) -> Iterator[None]:
    """End the process immediately on Ctrl-C, while the block imports modules.

    Many imported modules treat any exception as a missing optional module: a KeyboardInterrupt
    could be lost there, and the node would start after all. numpy makes an ImportError of it.

    :param status: exit status
    """
    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:  # ignored, as in the background of a script
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: os._exit(status))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check_namespace() -> None:
    """End with one line if rospy cannot be imported because of its namespace."""
    names = importlib.import_module("nodekit.node.name_rules")
    try:
        names.check_namespace(os.environ, sys.argv)
    except names.IllegalName as error:
        end(str(error))


def import_ros() -> None:
    """Import ROS without modules that a node does not need: this saves a third of the import time.

    Messages import numpy if it is installed, only to accept its numbers as well: 30 ms and 14 MB
    (measured on Debian 12). roslib imports catkin's file search, which rospy never uses, and with
    it a parser generator: 40 ms. Both can be imported normally afterwards.
    """
    with _stand_in("numpy", None):
        importlib.import_module("genpy.message")
    catkin = "catkin.find_in_workspaces"
    with _stand_in(catkin, _lazy(catkin, "find_in_workspaces")):
        importlib.import_module("roslib.packages")


@contextlib.contextmanager
def _stand_in(name: str, module: Optional[types.ModuleType]) -> Iterator[None]:
    """Put a module in place of another that is not imported yet.

    :param name: full name of the module
    :param module: the module to import instead; None for an ImportError
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


def _lazy(name: str, function: str) -> types.ModuleType:
    """Return a module with one function, which imports the real module when called.

    :param name: full name of the module
    :param function: name of the function
    """

    def call(*args: Any, **kwds: Any) -> Any:
        return getattr(importlib.import_module(name), function)(*args, **kwds)

    module = types.ModuleType(name)
    setattr(module, function, call)
    return module
