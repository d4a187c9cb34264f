"""States of the synchronization with a board, as a table."""

from typing import Set

from serial_link.host import sync_states
from serial_link.host.sync_states import (
    ASK,
    ASKED,
    CLOSED,
    DAMAGED,
    PROBING,
    DUE,
    EMPTY,
    EVENTS,
    HEARD,
    SYNCED,
    LOST,
    MESSAGE,
    NOTICE,
    OPENED,
    OVERDUE,
    PROBE,
    RESTART,
    SEEKING,
    SILENT,
    STATES,
    TABLE,
    TIME,
    TOPIC,
    UNKNOWN,
    Transition,
    find_transition,
)


def test_the_table_has_known_names_only() -> None:
    assert TABLE
    for (state, event), (target, action) in TABLE.items():
        assert state in STATES and event in EVENTS and target in STATES
        assert action in ("", ASK, PROBE, RESTART)


def test_a_lost_port_closes_whatever_was() -> None:
    others = set(STATES) - {CLOSED}
    assert others
    for state in others:
        assert find_transition(state, LOST) == Transition(CLOSED, RESTART)


def test_every_state_is_reached_and_left() -> None:
    reached: Set[str] = {CLOSED}
    while True:
        more = {target for (state, _), (target, _) in TABLE.items() if state in reached}
        if more <= reached:
            break
        reached |= more
    assert reached == set(STATES)
    for state in STATES:
        assert any(target != state for (of, _), (target, _) in TABLE.items() if of == state)


def test_missing_row_keeps_state() -> None:
    assert find_transition(CLOSED, TOPIC) == Transition(CLOSED, "")
    assert find_transition(ASKED, MESSAGE) == Transition(ASKED, "")


def test_notice_only_explains_a_time_request() -> None:
    others = set(STATES) - {HEARD}
    assert others and all(find_transition(state, NOTICE) == Transition(state) for state in others)


def test_a_silent_board_is_restarted_only_if_it_answers_two_probes() -> None:
    state = SYNCED
    for event, expected in ((DUE, (SILENT, PROBE)), (TIME, (PROBING, PROBE))):
        state, action = find_transition(state, event)
        assert (state, action) == expected
    assert find_transition(PROBING, TIME) == Transition(ASKED, RESTART)
    assert find_transition(PROBING, DUE) == Transition(SILENT, PROBE)
    assert find_transition(sync_states.CLOSED, OPENED) == Transition(ASKED, ASK)


def test_next_frame_decides_what_a_time_request_answered() -> None:
    assert find_transition(SEEKING, TIME) == Transition(HEARD)
    assert find_transition(HEARD, TOPIC) == Transition(SYNCED)
    others = (TIME, NOTICE, UNKNOWN, DUE)
    assert {find_transition(HEARD, event) for event in others} == {Transition(ASKED, ASK)}


def test_frames_of_a_configured_board_synchronize_it() -> None:
    for state in (ASKED, SEEKING, HEARD, SILENT, PROBING):
        assert find_transition(state, TOPIC) == Transition(SYNCED)
    for state in (SILENT, PROBING):
        assert find_transition(state, MESSAGE) == Transition(SYNCED)
    for state in (SYNCED, SILENT, PROBING):
        assert find_transition(state, UNKNOWN) == Transition(SYNCED, ASK)
    assert find_transition(SEEKING, UNKNOWN) == Transition(ASKED, ASK)
    assert find_transition(ASKED, EMPTY) == Transition(SYNCED)


def test_board_that_does_not_answer_is_probed_and_asked_again() -> None:
    assert find_transition(ASKED, DUE) == Transition(SEEKING, PROBE)
    assert find_transition(SEEKING, DUE) == Transition(SEEKING, PROBE)
    for event in (OVERDUE, DAMAGED):
        assert find_transition(SEEKING, event) == Transition(ASKED, ASK)
    assert find_transition(SILENT, DUE) == Transition(SILENT, PROBE)
    assert find_transition(SILENT, OVERDUE) == Transition(ASKED, RESTART)


def test_pending_request_is_not_followed_by_another() -> None:
    asking = {
        event for (state, event), (_, action) in TABLE.items() if state == ASKED and action == ASK
    }
    assert not asking
