"""Whether a board publishes, as a table."""

from serial_link.device.configuring import (
    ASK_TIME,
    CONFIGURED,
    DELIVER,
    EVENTS,
    FORGOTTEN,
    MESSAGE,
    NEGOTIATE,
    OTHER_VERSION,
    SET_TIME,
    STATES,
    STOPPED,
    TABLE,
    TIME_DUE,
    WAITING,
    WANTED,
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
        assert move(state, WANTED) == Move(CONFIGURED, (ASK_TIME, NEGOTIATE))
        assert move(state, MESSAGE) == Move(state, (DELIVER,))
    assert move(WAITING, OTHER_VERSION) == Move(WAITING, (ASK_TIME,))
    assert move(CONFIGURED, OTHER_VERSION) == Move(CONFIGURED)
    assert move(CONFIGURED, TIME_DUE) == Move(CONFIGURED, (ASK_TIME,))
    assert move(WAITING, TIME_DUE) == Move(WAITING)
    assert move(CONFIGURED, FORGOTTEN) == move(CONFIGURED, STOPPED) == Move(WAITING)
