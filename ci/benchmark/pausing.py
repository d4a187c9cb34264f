"""Processes that stay up and stand still, but for turns: so that starting them costs nothing."""

import contextlib
import os
import signal
import time
from typing import Iterator, List

#: How long what one process has sent before it stood still may take to come through, s.
DRAIN_S = 0.05


def stand_still(pids: List[int]) -> None:
    """Stop processes for the time being.

    :param pids: whoever hears before whoever sends: what has been sent is still taken
    """
    for number, pid in enumerate(reversed(pids)):
        if number:
            time.sleep(DRAIN_S)
        os.kill(pid, signal.SIGSTOP)


def go_on(pids: List[int]) -> None:
    """Have processes go on.

    :param pids: whoever hears before whoever sends
    """
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)


@contextlib.contextmanager
def standing(pids: List[int]) -> Iterator[None]:
    """Have processes stand still for a while."""
    stand_still(pids)
    try:
        yield
    finally:
        go_on(pids)  # or else they cannot end


@contextlib.contextmanager
def going(pids: List[int]) -> Iterator[None]:
    """Have processes that stand still go on for a while."""
    go_on(pids)
    try:
        yield
    finally:
        stand_still(pids)
