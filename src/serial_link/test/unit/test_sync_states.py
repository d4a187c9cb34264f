"""States of the synchronization with a board, as a table."""

from typing import Set

from serial_link.host import sync_states
from serial_link.host.sync_states import (
    ASK,
    NEGOTIATING,
    CLOSED,
    PROBING,
    DUE,
    EVENTS,
    SYNCED,
    LOST,
    MESSAGE,
    NOTICE,
    OPENED,
    PROBE,
    RESTART,
    SILENT,
    STATES,
    TABLE,
    TIME,
    TOPIC,
    Move,
    move,
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
        assert move(state, LOST) == Move(CLOSED, RESTART)


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


def test_what_has_no_row_changes_nothing() -> None:
    assert move(CLOSED, TOPIC) == Move(CLOSED, "")
    assert move(NEGOTIATING, MESSAGE) == Move(NEGOTIATING, "")


def test_notice_changes_no_state() -> None:
    assert all(move(state, NOTICE) == Move(state) for state in STATES)


def test_a_silent_board_is_restarted_only_if_it_answers_two_probes() -> None:
    state = SYNCED
    for event, expected in ((DUE, (SILENT, PROBE)), (TIME, (PROBING, PROBE))):
        state, action = move(state, event)
        assert (state, action) == expected
    assert move(PROBING, TIME) == Move(NEGOTIATING, RESTART)
    assert move(PROBING, DUE) == Move(SILENT, PROBE)
    assert move(sync_states.CLOSED, OPENED) == Move(NEGOTIATING, ASK)
