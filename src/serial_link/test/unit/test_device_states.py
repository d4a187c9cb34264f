"""Whether a board publishes, as a table."""

from serial_link.device.device_states import (
    ASK_TIME,
    CONFIGURED,
    DELIVER,
    EVENTS,
    HOST_LOST,
    MESSAGE,
    NEGOTIATE,
    OTHER_VERSION,
    SET_TIME,
    STATES,
    STOP_RECEIVED,
    TABLE,
    TIME_DUE,
    WAITING,
    TOPICS_REQUESTED,
    Move,
    move,
)


def test_the_table_has_known_names_only() -> None:
    assert TABLE
    for (state, event), (target, actions) in TABLE.items():
        assert state in STATES and event in EVENTS and target in STATES
        assert set(actions) <= {ASK_TIME, NEGOTIATE, SET_TIME, DELIVER}


def test_it_is_as_the_library_for_boards_does_it() -> None:
    for state in STATES:
        assert move(state, TOPICS_REQUESTED) == Move(CONFIGURED, (ASK_TIME, NEGOTIATE))
        assert move(state, MESSAGE) == Move(state, (DELIVER,))
    assert move(WAITING, OTHER_VERSION) == Move(WAITING, (ASK_TIME,))
    assert move(CONFIGURED, OTHER_VERSION) == Move(CONFIGURED)
    assert move(CONFIGURED, TIME_DUE) == Move(CONFIGURED, (ASK_TIME,))
    assert move(WAITING, TIME_DUE) == Move(WAITING)
    assert move(CONFIGURED, HOST_LOST) == move(CONFIGURED, STOP_RECEIVED) == Move(WAITING)
