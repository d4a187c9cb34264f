"""Preparation of rospy before a node starts: patches, signal handlers, and a faster init_node."""

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
from nodekit.rospy_internals.log_handlers import patch_logs
from nodekit.rospy_internals.serialization_errors import patch_serialization
from nodekit.rospy_internals.shutdown import ignore_requests_to_others, patch_shutdown
from nodekit.rospy_internals.tcpros_server import patch_tcpros_server

#: Period of the check whether the node is registered [s].
_POLL_S = 0.001


@functools.lru_cache(maxsize=None)
def apply_patches() -> None:
    """Apply all patches, once in a process, before ``rospy.init_node``."""
    cache_statistics_setting()
    patch_tcpros_server()
    patch_logs()
    patch_serialization()
    patch_shutdown()
    ignore_requests_to_others()


def register_signals() -> None:
    """Shut the node down on SIGINT and SIGTERM, and when its terminal is closed.

    ``rospy.init_node`` handles the first two if the main thread calls it. But a second signal
    interrupts rospy's handler, which is not reentrant (it writes to the log file): the node hung,
    or ended with a traceback. Here only the first signal is handled.
    """
    rospy.core.register_signals()
    shut_down: Any = signal.getsignal(signal.SIGTERM)
    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # ignored under nohup
        numbers.append(signal.SIGHUP)

    def handle_first(number: int, frame: Optional[FrameType]) -> None:
        for each in numbers:
            signal.signal(each, _ignore)
        shut_down(number, frame)

    for number in numbers:
        signal.signal(number, handle_first)


def _ignore(_number: int, _frame: Optional[FrameType]) -> None:
    """Ignore a signal. With SIG_IGN, Python would print an error for a pending signal."""


@contextlib.contextmanager
def fast_init_poll() -> Iterator[None]:
    """Poll fast within ``rospy.init_node``, which checks every 0.1 s whether it is registered."""
    module = rospy.impl.init
    if getattr(module, "time", None) is not time:  # an unknown version of rospy
        yield
        return
    module.time = types.SimpleNamespace(sleep=lambda s: time.sleep(min(s, _POLL_S)))
    try:
        yield
    finally:
        module.time = time
