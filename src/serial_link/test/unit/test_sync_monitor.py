"""The contact with a board in time."""

import math
from typing import List

import pytest

from serial_link.host.sync_states import (
    ASK,
    NEGOTIATING,
    CLOSED,
    PROBING,
    SYNCED,
    LOST,
    MESSAGE,
    NOTICE,
    OPENED,
    PROBE,
    RESTART,
    SILENT,
    TIME,
    TOPIC,
    UNKNOWN,
)
from serial_link.host.sync_monitor import (
    ASK_EVERY_S,
    OVERDUE_S,
    PROBE_EVERY_S,
    QUIET_S,
    SyncMonitor,
)


def in_step(now: float = 0.0) -> SyncMonitor:
    monitor = SyncMonitor()
    assert monitor.handle(now, OPENED) == [ASK]
    assert monitor.handle(now, TIME) == []
    assert monitor.handle(now, TOPIC) == []
    assert monitor.state == SYNCED
    return monitor


def run(monitor: SyncMonitor, start: float, end: float) -> List[str]:
    """Poll whenever something is due."""
    actions: List[str] = []
    while start <= monitor.next_due() <= end:
        actions += monitor.poll(monitor.next_due())
    return actions


def test_nothing_is_due_while_the_port_is_closed() -> None:
    monitor = SyncMonitor()
    assert monitor.next_due() == math.inf and monitor.poll(1e9) == []
    monitor = in_step()
    assert monitor.handle(1.0, LOST) == [RESTART]
    assert monitor.state == CLOSED and monitor.next_due() == math.inf
    assert monitor.restarts == 0


def test_a_board_is_asked_until_it_answers() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    assert monitor.poll(0.9 * ASK_EVERY_S) == []
    assert run(monitor, 0.0, 1.01) == [ASK] * 4
    monitor.handle(1.1, TOPIC)
    assert monitor.state == SYNCED


def test_a_board_that_says_something_is_not_probed() -> None:
    monitor = in_step()
    for step in range(1, 50):
        assert monitor.poll(0.2 * step) == []
        monitor.handle(0.2 * step, MESSAGE)
    assert monitor.poll(0.2 * 49 + QUIET_S) == [PROBE]
    assert monitor.state == SILENT


def test_a_board_that_only_listens_stays_in_contact() -> None:
    monitor = in_step()
    for request in range(1, 10):
        actions = run(monitor, 0.0, 2.5 * request)
        assert set(actions) == {PROBE}
        assert monitor.handle(2.5 * request, TIME) == [PROBE]
        assert monitor.state == PROBING
        assert monitor.poll(2.5 * request + PROBE_EVERY_S) == [PROBE]
        assert monitor.state == SILENT
    assert monitor.restarts == 0


def test_a_board_that_was_reset_is_back_within_a_second_of_its_start() -> None:
    monitor = in_step()
    back_at = 1.7
    assert set(run(monitor, 0.0, back_at)) == {PROBE}
    now = monitor.next_due()  # the first probe that it is there for
    monitor.poll(now)
    assert monitor.handle(now + 0.01, TIME) == [PROBE]
    assert monitor.handle(now + 0.02, TIME) == [RESTART, ASK]
    assert monitor.state == NEGOTIATING and monitor.restarts == 1
    assert now + 0.02 - back_at < 1.0
    monitor.handle(now + 0.03, TIME)
    assert monitor.state == SYNCED


def test_a_reset_board_that_logs_in_its_loop_is_asked_again() -> None:
    monitor = in_step()
    actions: List[str] = []
    for step in range(1, 51):  # a log line or a parameter request every 0.1 s
        now = 0.1 * step
        actions += monitor.handle(now, NOTICE)
        polled = monitor.poll(now)
        while PROBE in polled:  # a board that waits to be asked answers each probe
            actions += polled
            polled = monitor.handle(now + 0.01, TIME)
        actions += polled
        if ASK in polled:
            break
    assert actions[-2:] == [RESTART, ASK] and now < 1.0
    assert monitor.state == NEGOTIATING and monitor.restarts == 1


@pytest.mark.parametrize("state", [SILENT, PROBING])
def test_notice_while_probing_proves_nothing(state: str) -> None:
    monitor = in_step()
    monitor.poll(QUIET_S)
    if state == PROBING:
        monitor.handle(QUIET_S, TIME)
    assert monitor.handle(QUIET_S, NOTICE) == []
    assert monitor.state == state


def test_board_that_sends_only_notices_is_overdue_after_the_librarys_timeout() -> None:
    monitor = in_step()
    for step in range(1, 400):
        now = 0.05 * step
        monitor.handle(now, NOTICE)
        if RESTART in monitor.poll(now):
            break
    assert OVERDUE_S <= now <= OVERDUE_S + 2.0 * PROBE_EVERY_S
    assert 10.0 < OVERDUE_S < 12.0


def test_time_requests_provoked_by_bytes_of_messages_hide_no_reset() -> None:
    monitor = in_step()
    for step in range(1, 20):  # each message to the board has a byte 0xff that is not a frame's
        now = 0.1 * step
        monitor.poll(now)
        if ASK in monitor.handle(now, TIME):
            break
    assert monitor.state == NEGOTIATING and now < 1.0


def test_a_quick_board_that_was_reset_is_missed_within_half_a_second() -> None:
    monitor = in_step()
    monitor.handle(1.0, MESSAGE)
    assert monitor.poll(1.5) == [PROBE]
    assert monitor.handle(1.51, TIME) == [PROBE]
    assert monitor.handle(1.52, TIME) == [RESTART, ASK]


def test_a_board_that_is_silent_for_too_long_is_asked_anew() -> None:
    monitor = in_step()
    actions = run(monitor, 0.0, 0.99 * OVERDUE_S)
    assert set(actions) == {PROBE} and monitor.state == SILENT
    assert run(monitor, 0.0, OVERDUE_S + PROBE_EVERY_S)[:2] == [RESTART, ASK]
    assert monitor.state == NEGOTIATING


@pytest.mark.parametrize("quiet", [False, True])
def test_a_topic_that_is_not_known_is_asked_for_but_not_again_at_once(quiet: bool) -> None:
    monitor = in_step()
    if quiet:
        monitor.poll(QUIET_S)
        assert monitor.state == SILENT
    assert monitor.handle(1.0, UNKNOWN) == [ASK]
    assert monitor.handle(1.0 + 0.9 * ASK_EVERY_S, UNKNOWN) == []
    assert monitor.handle(1.0 + 1.1 * ASK_EVERY_S, UNKNOWN) == [ASK]
    assert monitor.state == SYNCED
