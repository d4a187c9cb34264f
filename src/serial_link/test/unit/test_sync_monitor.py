"""The contact with a board in time."""

import math
from typing import List

import pytest

from serial_link.host.sync_states import (
    ASK,
    ASKED,
    CLOSED,
    DAMAGED,
    HEARD,
    PROBING,
    SYNCED,
    LOST,
    MESSAGE,
    NOTICE,
    OPENED,
    PROBE,
    RESTART,
    SEEKING,
    SILENT,
    TIME,
    TOPIC,
    UNKNOWN,
)
from serial_link.host.sync_monitor import (
    ASK_EVERY_S,
    FOLLOWS_S,
    GROWTH,
    OVERDUE_S,
    PROBE_EVERY_S,
    QUIET_S,
    SILENT_ITERATIONS,
    TIME_EVERY_S,
    SyncMonitor,
)


def synced_monitor(now: float = 0.0) -> SyncMonitor:
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


def test_no_timeout_while_port_is_closed() -> None:
    monitor = SyncMonitor()
    assert monitor.next_due() == math.inf and monitor.poll(1e9) == []
    monitor = synced_monitor()
    assert monitor.handle(1.0, LOST) == [RESTART]
    assert monitor.state == CLOSED and monitor.next_due() == math.inf
    assert monitor.restarts == 0


def test_board_that_does_not_answer_is_asked_once_in_eleven_seconds_and_probed_ever_less() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    assert monitor.poll(0.9 * QUIET_S) == []
    probed_at = []
    while monitor.next_due() < OVERDUE_S:
        now = monitor.next_due()
        assert monitor.poll(now) == [PROBE]
        probed_at.append(now)
    pauses = [later - sooner for sooner, later in zip(probed_at, probed_at[1:])]
    assert probed_at[0] == pytest.approx(QUIET_S) and pauses[0] == pytest.approx(PROBE_EVERY_S)
    assert all(later == pytest.approx(GROWTH * sooner) for sooner, later in zip(pauses, pauses[1:]))
    assert len(pauses) > 5
    assert monitor.poll(OVERDUE_S) == [ASK] and monitor.state == ASKED
    monitor.handle(OVERDUE_S + 0.1, TOPIC)
    assert monitor.state == SYNCED


def test_board_that_never_answers_is_asked_every_eleven_seconds() -> None:
    monitor, asked_at = SyncMonitor(), []
    monitor.handle(0.0, OPENED)
    for _ in range(40):
        now = monitor.next_due()
        if ASK in monitor.poll(now):
            asked_at.append(now)
    assert asked_at[:3] == pytest.approx([OVERDUE_S, 2.0 * OVERDUE_S, 3.0 * OVERDUE_S])


def test_slow_sketch_buffer_keeps_room_for_messages() -> None:
    monitor = SyncMonitor()
    actions = monitor.handle(0.0, OPENED) + run(monitor, 0.0, 5.0)
    waiting = 8 * actions.count(ASK) + 2 * actions.count(PROBE)
    assert actions.count(ASK) == 1 and waiting <= 20


def test_board_that_boots_is_asked_as_soon_as_it_answers_a_probe() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)  # the question is lost on the bootloader
    run(monitor, 0.0, 2.0)
    now = monitor.next_due()
    assert monitor.poll(now) == [PROBE]
    assert monitor.handle(now + 0.01, TIME) == [] and monitor.state == HEARD
    assert run(monitor, now, now + 0.01 + FOLLOWS_S) == [ASK]
    assert monitor.handle(now + 0.15, TIME) == []
    monitor.handle(now + 0.16, TOPIC)
    assert monitor.state == SYNCED and now < 3.2


def test_slow_sketch_that_answers_the_question_late_is_not_asked_again() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    run(monitor, 0.0, 5.0)
    assert monitor.handle(5.0, TIME) == [] and monitor.handle(5.02, TOPIC) == []
    assert monitor.state == SYNCED
    assert run(monitor, 5.0, 9.9) == []  # its next turn is five seconds later


@pytest.mark.parametrize("turn", [1.0, 3.0, 5.0, 7.0])
@pytest.mark.parametrize("publishes", [False, True])
def test_sketch_with_a_slow_loop_is_neither_restarted_nor_asked_again(
    turn: float, publishes: bool
) -> None:
    monitor = SyncMonitor()
    actions = monitor.handle(0.0, OPENED)
    asked_time_at = -10.0
    probes = []
    for number in range(1, 20):
        now = (number - 0.5) * turn
        done = run(monitor, 0.0, now)
        actions += done
        probes.append(done.count(PROBE))
        if number == 1:
            asked_time_at = now
            actions += monitor.handle(now, TIME) + monitor.handle(now, TOPIC)
        elif now - asked_time_at > 2.5:
            asked_time_at = now
            done = monitor.handle(now, TIME)
            actions += done
            probes[-1] += done.count(PROBE)
        if publishes:
            actions += monitor.handle(now, MESSAGE)
    assert actions.count(ASK) == 1 and RESTART not in actions and monitor.restarts == 0
    assert max(probes[8:]) <= 2


def test_patience_returns_to_its_minimum_when_the_loop_becomes_quick() -> None:
    monitor = synced_monitor()
    monitor.handle(5.0, TIME)
    assert monitor.patience == SILENT_ITERATIONS * 5.0
    monitor.handle(5.0 + TIME_EVERY_S, TIME)
    assert monitor.patience == QUIET_S


@pytest.mark.parametrize("event", [MESSAGE, TOPIC])
def test_board_that_sends_in_each_iteration_has_no_longer_loop(event: str) -> None:
    monitor = synced_monitor()
    run(monitor, 0.0, 2.8)
    monitor.handle(2.8, TIME)
    assert monitor.patience == SILENT_ITERATIONS * 2.8  # it has sent nothing else
    for iteration in range(1, 8):  # the first time request after 2.5 s is in the seventh
        now = 2.8 + 0.4 * iteration
        run(monitor, 0.0, now)
        monitor.handle(now, event)
    monitor.handle(now, TIME)
    assert monitor.patience == pytest.approx(SILENT_ITERATIONS * 0.4)


def test_slow_sketch_that_was_reset_is_asked_again() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    monitor.handle(4.0, TIME)
    monitor.handle(4.0, TOPIC)
    for number in range(1, 4):
        run(monitor, 0.0, 4.0 + 5.0 * number)
        monitor.handle(4.0 + 5.0 * number, TIME)
        monitor.handle(4.0 + 5.0 * number, MESSAGE)
    actions = run(monitor, 0.0, 29.0)  # reset, and its loop waits: both probes are read at once
    assert actions.count(PROBE) >= 2
    answers = [monitor.handle(29.0, TIME) for _ in range(actions.count(PROBE))]
    assert answers[1] == [RESTART, ASK] and [ASK] not in answers
    assert monitor.state == ASKED and monitor.restarts == 1
    # Not of the ten seconds after which it answered the probe.
    assert monitor.patience == SILENT_ITERATIONS * 5.0


def slow_monitor() -> SyncMonitor:
    """Return a monitor of a board whose loop takes five seconds, at 10 s."""
    monitor = synced_monitor()
    for now in (5.0, 10.0):
        monitor.handle(now, MESSAGE)
        monitor.handle(now, TIME)
    assert monitor.patience == SILENT_ITERATIONS * 5.0
    return monitor


def test_answer_in_the_middle_of_a_slow_loop_or_to_a_probe_does_not_shorten_it() -> None:
    monitor = slow_monitor()
    monitor.ask(10.0)
    monitor.handle(11.0, TIME)
    monitor.handle(11.0, TOPIC)
    monitor.handle(12.0, TIME)
    assert monitor.patience == SILENT_ITERATIONS * 5.0


def test_time_request_that_answers_a_question_tells_nothing_about_the_loop() -> None:
    monitor = synced_monitor()
    monitor.handle(2.5, TIME)
    monitor.ask(6.5)
    monitor.handle(6.51, TIME)
    assert monitor.patience == QUIET_S


def test_slow_board_has_time_for_an_answer_before_the_next_question() -> None:
    monitor = slow_monitor()
    assert monitor.handle(20.0, UNKNOWN) == [ASK]
    assert monitor.handle(20.0 + 1.4 * 5.0, UNKNOWN) == []
    assert monitor.handle(20.0 + 1.6 * 5.0, UNKNOWN) == [ASK]


def test_next_board_at_the_port_is_not_taken_for_slow() -> None:
    monitor = slow_monitor()
    monitor.handle(10.0, LOST)
    monitor.handle(11.0, OPENED)
    assert monitor.patience == QUIET_S


@pytest.mark.parametrize("events", [[LOST, OPENED], [TIME, TIME]])
def test_pauses_between_questions_begin_anew_after_a_restart(events: List[str]) -> None:
    monitor = synced_monitor()
    for step in range(1, 200):
        monitor.handle(0.1 * step, UNKNOWN)
    monitor.poll(21.0)
    assert monitor.state == SILENT
    for event in events:
        monitor.handle(21.0, event)
    monitor.handle(21.1, TOPIC)
    assert monitor.handle(21.5, UNKNOWN) == [ASK]


def test_unknown_topic_during_a_pause_between_questions_proves_that_the_board_is_there() -> None:
    monitor = synced_monitor()
    for now in (1.0, 1.5, 2.5):
        assert monitor.handle(now, UNKNOWN) == [ASK]
    monitor.poll(2.9)
    assert monitor.state == SILENT
    assert monitor.handle(3.0, UNKNOWN) == [] and monitor.state == SYNCED


def test_question_on_demand_is_followed_by_a_pause() -> None:
    monitor = synced_monitor()
    assert monitor.ask(5.0) == [ASK] and monitor.handle(5.1, UNKNOWN) == []


def test_loss_of_a_board_that_is_probed_is_no_restart() -> None:
    monitor = synced_monitor()
    monitor.poll(QUIET_S)
    monitor.handle(QUIET_S, TIME)
    assert monitor.state == PROBING and monitor.handle(0.4, LOST) == [RESTART]
    assert monitor.restarts == 0


def test_topics_on_a_slow_line_may_follow_the_time_request_later() -> None:
    monitor = SyncMonitor(0.5)
    monitor.handle(0.0, OPENED)
    assert monitor.poll(1.0) == [PROBE]
    assert monitor.next_due() == 1.0 + PROBE_EVERY_S + 0.5
    run(monitor, 1.0, 2.0)
    monitor.handle(2.0, TIME)
    assert monitor.state == HEARD and monitor.next_due() == 2.0 + FOLLOWS_S + 0.5


def test_answers_without_topics_do_not_add_up_over_restarts() -> None:
    monitor = SyncMonitor()
    for start in (0.0, 10.0):
        monitor.handle(start, OPENED)
        monitor.handle(start + 0.01, TIME)
        monitor.poll(start + QUIET_S)
        assert monitor.state == SEEKING
        monitor.handle(start + 1.0, TOPIC)
        monitor.handle(start + 2.0, LOST)


def test_sketch_without_topics_is_synced_by_the_second_answer() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    monitor.handle(0.01, TIME)
    assert set(run(monitor, 0.0, 2.5)) == {PROBE}
    monitor.handle(2.51, TIME)
    assert run(monitor, 0.0, 2.51 + FOLLOWS_S)[-1] == ASK
    monitor.handle(2.7, TIME)
    run(monitor, 0.0, 3.1)
    assert monitor.state in (SYNCED, SILENT)


def test_sketch_that_advertises_after_its_first_answer_is_asked_again_when_it_publishes() -> None:
    monitor = SyncMonitor()
    monitor.handle(0.0, OPENED)
    assert not monitor.is_bare
    monitor.handle(0.02, TIME)
    assert monitor.is_bare
    assert run(monitor, 0.0, QUIET_S) == [PROBE]
    assert monitor.handle(0.35, UNKNOWN) == [ASK]
    assert monitor.handle(0.36, UNKNOWN) == [] and not monitor.is_bare
    monitor.handle(0.37, TIME)
    monitor.handle(0.38, TOPIC)
    assert monitor.state == SYNCED and not monitor.is_bare


def test_messages_before_the_answer_cause_no_second_question() -> None:
    monitor = SyncMonitor()
    actions = monitor.handle(0.0, OPENED)
    for step in range(1, 100):
        actions += run(monitor, 0.0, 0.1 * step) + monitor.handle(0.1 * step, UNKNOWN)
    assert actions.count(ASK) == 1


def test_damaged_frames_before_the_answer_bring_questions_ever_more_rarely() -> None:
    monitor = SyncMonitor()
    actions = monitor.handle(0.0, OPENED)
    asked_at = []
    for step in range(1, 600):
        now = 0.1 * step
        if ASK in run(monitor, 0.0, now) + monitor.handle(now, DAMAGED):
            asked_at.append(now)
    assert actions == [ASK] and asked_at[0] < 1.0
    assert 7 <= len(asked_at) <= 10
    assert asked_at[-1] - asked_at[-2] >= 0.99 * OVERDUE_S


def test_a_board_that_says_something_is_not_probed() -> None:
    monitor = synced_monitor()
    for step in range(1, 50):
        assert monitor.poll(0.2 * step) == []
        monitor.handle(0.2 * step, MESSAGE)
    assert monitor.poll(0.2 * 49 + QUIET_S) == [PROBE]
    assert monitor.state == SILENT


def test_board_that_only_subscribes_stays_synced() -> None:
    monitor = synced_monitor()
    for request in range(1, 10):
        actions = run(monitor, 0.0, 2.5 * request)
        assert set(actions) == {PROBE} and len(actions) <= 6
        assert monitor.handle(2.5 * request, TIME) == [PROBE]
        assert monitor.state == PROBING
        assert monitor.poll(2.5 * request + PROBE_EVERY_S) == [PROBE]
        assert monitor.state == SILENT
    assert monitor.restarts == 0


def test_a_board_that_was_reset_is_back_within_a_second_of_its_start() -> None:
    monitor = synced_monitor()
    back_at = 1.7
    assert set(run(monitor, 0.0, back_at)) == {PROBE}
    now = monitor.next_due()  # the first probe that it is there for
    monitor.poll(now)
    assert monitor.handle(now + 0.01, TIME) == [PROBE]
    assert monitor.handle(now + 0.02, TIME) == [RESTART, ASK]
    assert monitor.state == ASKED and monitor.restarts == 1
    assert now + 0.02 - back_at < 1.0
    monitor.handle(now + 0.03, TIME)
    monitor.handle(now + 0.04, TOPIC)
    assert monitor.state == SYNCED


def test_a_reset_board_that_logs_in_its_loop_is_asked_again() -> None:
    monitor = synced_monitor()
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
    assert monitor.state == ASKED and monitor.restarts == 1


@pytest.mark.parametrize("state", [SILENT, PROBING])
def test_notice_while_probing_proves_nothing(state: str) -> None:
    monitor = synced_monitor()
    monitor.poll(QUIET_S)
    if state == PROBING:
        monitor.handle(QUIET_S, TIME)
    assert monitor.handle(QUIET_S, NOTICE) == []
    assert monitor.state == state


def test_board_that_sends_only_notices_is_overdue_after_the_librarys_timeout() -> None:
    monitor = synced_monitor()
    for step in range(1, 400):
        now = 0.05 * step
        monitor.handle(now, NOTICE)
        if RESTART in monitor.poll(now):
            break
    assert OVERDUE_S <= now <= OVERDUE_S + 2.0 * PROBE_EVERY_S
    assert 10.0 < OVERDUE_S < 12.0


def test_time_requests_provoked_by_bytes_of_messages_hide_no_reset() -> None:
    monitor = synced_monitor()
    for step in range(1, 20):  # each message to the board has a byte 0xff that is not a frame's
        now = 0.1 * step
        monitor.poll(now)
        if ASK in monitor.handle(now, TIME):
            break
    assert monitor.state == ASKED and now < 1.0


def test_a_quick_board_that_was_reset_is_missed_within_half_a_second() -> None:
    monitor = synced_monitor()
    monitor.handle(1.0, MESSAGE)
    assert monitor.poll(1.5) == [PROBE]
    assert monitor.handle(1.51, TIME) == [PROBE]
    assert monitor.handle(1.52, TIME) == [RESTART, ASK]


def test_silent_board_is_requested_again() -> None:
    monitor = synced_monitor()
    actions = run(monitor, 0.0, 0.99 * OVERDUE_S)
    assert set(actions) == {PROBE} and monitor.state == SILENT
    assert run(monitor, 0.0, OVERDUE_S + PROBE_EVERY_S)[:2] == [RESTART, ASK]
    assert monitor.state == ASKED


@pytest.mark.parametrize("state", [SYNCED, SILENT, PROBING])
def test_unknown_topic_causes_request_after_pause(state: str) -> None:
    monitor = synced_monitor()
    if state != SYNCED:
        monitor.poll(QUIET_S)
    if state == PROBING:
        monitor.handle(QUIET_S, TIME)
    assert monitor.state == state
    assert monitor.handle(1.0, UNKNOWN) == [ASK]
    assert monitor.handle(1.0 + 0.9 * ASK_EVERY_S, UNKNOWN) == []
    assert monitor.state == SYNCED


def test_pauses_grow_while_topic_stays_unknown() -> None:
    monitor = synced_monitor()
    asked_at = []
    for step in range(1, 600):  # its messages come ten times a second
        now = 0.1 * step
        if ASK in monitor.handle(now, UNKNOWN):
            asked_at.append(now)
            monitor.handle(now + 0.01, TIME)
            monitor.handle(now + 0.02, TOPIC)
    assert 7 <= len(asked_at) <= 10
    assert asked_at[-1] - asked_at[-2] >= OVERDUE_S
    assert monitor.handle(asked_at[-1] + 60.0, UNKNOWN) == [ASK]
    assert monitor.handle(asked_at[-1] + 60.6, UNKNOWN) == [ASK]


@pytest.mark.parametrize("baud", [2400, 4800])
def test_board_on_a_slow_line_is_not_restarted_by_its_own_answers(baud: int) -> None:
    frame = 1280 / baud
    monitor = SyncMonitor(frame)
    actions = monitor.handle(0.0, OPENED)
    for number in range(40):  # the time request, then a topic, message or nothing, each on the line
        now = 0.1 + 2.5 * number
        actions += run(monitor, 0.0, now)
        actions += monitor.handle(now, TIME)
        if number == 0:
            actions += run(monitor, 0.0, now + 0.9 * frame)
            actions += monitor.handle(now + 0.9 * frame, TOPIC)
    assert actions.count(ASK) == 1 and RESTART not in actions


def test_topics_are_requested_eleven_seconds_after_the_last_message() -> None:
    monitor = synced_monitor()
    for now in (1.0, 2.0):
        assert monitor.handle(now, MESSAGE) == [] and monitor.state == SYNCED
        assert monitor.next_due() == now + monitor.patience
    while monitor.state != ASKED:
        now = monitor.next_due()
        monitor.poll(now)
    assert now == 2.0 + OVERDUE_S
