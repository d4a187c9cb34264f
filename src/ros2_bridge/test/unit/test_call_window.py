"""Calls that a server's queue holds at a time."""

import threading
import time
from typing import List

from nodekit.testing.waiting import wait_until
from ros2_bridge.ros2.call_window import CallWindow


def test_calls_beyond_queue_wait_for_an_answer() -> None:
    window = CallWindow(most=2, taken=60.0)
    far = time.monotonic() + 60.0
    first, second = window.enter(far), window.enter(far)
    assert first is not None and second is not None and len(window) == 2
    assert window.enter(time.monotonic()) is None and len(window) == 2
    entered: List[object] = []
    waiting = threading.Thread(target=lambda: entered.append(window.enter(far)))
    waiting.start()
    window.leave(first)
    waiting.join(30.0)
    assert entered not in ([], [None]) and len(window) == 2


def test_old_calls_do_not_count() -> None:
    window = CallWindow(most=1, taken=0.05)
    assert window.enter(time.monotonic()) is not None
    # Without an answer: a server that works on several at a time is not held up.
    deadline = time.monotonic() + 10.0
    assert window.enter(deadline) is not None and time.monotonic() < deadline
    assert len(window) == 2


def test_each_waiting_call_enters_in_its_turn() -> None:
    window, most = CallWindow(most=3, taken=60.0), []

    def call() -> None:
        turn = window.enter(time.monotonic() + 60.0)
        most.append(len(window))
        assert turn is not None
        window.leave(turn)

    threads = [threading.Thread(target=call) for _ in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30.0)
    wait_until(lambda: len(most) == 50, lambda: f"{len(most)} of 50")
    assert max(most) <= 3 and len(window) == 0
