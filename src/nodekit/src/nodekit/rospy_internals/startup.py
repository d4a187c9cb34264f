"""What is changed in rospy before a node starts: patches, signals, and how long it waits."""

import contextlib
import functools
import signal
import time
import types
from types import FrameType
from typing import Any, Iterator, Optional

import rospy.core
import rospy.impl.init

from nodekit.rospy_internals.incoming_topic import cache_statistics_setting
from nodekit.rospy_internals.logs import patch_logs
from nodekit.rospy_internals.serialization import patch_serialization
from nodekit.rospy_internals.shutdown import patch_shutdown
from nodekit.rospy_internals.tcpros_server import patch_tcpros_server

#: How often to look whether the node is registered, s.
_LOOK_EVERY_S = 0.001


@functools.lru_cache(maxsize=None)
def apply_patches() -> None:
    """Apply all patches, once in a process; before ``rospy.init_node``."""
    cache_statistics_setting()
    patch_tcpros_server()
    patch_logs()
    patch_serialization()
    patch_shutdown()


def register_signals() -> None:
    """Have rospy shut the node down on SIGINT and SIGTERM, and when its terminal is closed.

    ``rospy.init_node`` does the same for the first two where it is called by the main thread. But
    rospy's answer to a second signal interrupts its answer to the first, and does what must not
    be done twice at a time, such as writing to the log file: the node hung, or ended with a
    traceback. Here only the first is answered.
    """
    rospy.core.register_signals()
    shut_down: Any = signal.getsignal(signal.SIGTERM)
    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # which is nohup's doing
        numbers.append(signal.SIGHUP)

    def answer_first(number: int, frame: Optional[FrameType]) -> None:
        for each in numbers:
            signal.signal(each, _leave)
        shut_down(number, frame)

    for number in numbers:
        signal.signal(number, answer_first)


def _leave(_number: int, _frame: Optional[FrameType]) -> None:
    """Do nothing. SIG_IGN in its place makes Python complain of a signal that is on its way."""


@contextlib.contextmanager
def fast_init_poll() -> Iterator[None]:
    """Start a node as soon as it is registered; ``rospy.init_node`` looks every 0.1 s only."""
    module = rospy.impl.init
    if getattr(module, "time", None) is not time:  # it waits in another way
        yield
        return
    module.time = types.SimpleNamespace(sleep=lambda s: time.sleep(min(s, _LOOK_EVERY_S)))
    try:
        yield
    finally:
        module.time = time
