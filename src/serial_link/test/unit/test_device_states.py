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
    Transition,
    find_transition,
)


def test_the_table_has_known_names_only() -> None:
    assert TABLE
    for (state, event), (target, actions) in TABLE.items():
        assert state in STATES and event in EVENTS and target in STATES
        assert set(actions) <= {ASK_TIME, NEGOTIATE, SET_TIME, DELIVER}


def test_it_is_as_the_library_for_boards_does_it() -> None:
    for state in STATES:
        assert find_transition(state, TOPICS_REQUESTED) == Transition(
            CONFIGURED, (ASK_TIME, NEGOTIATE)
        )
        assert find_transition(state, MESSAGE) == Transition(state, (DELIVER,))
    assert find_transition(WAITING, OTHER_VERSION) == Transition(WAITING, (ASK_TIME,))
    assert find_transition(CONFIGURED, OTHER_VERSION) == Transition(CONFIGURED)
    assert find_transition(CONFIGURED, TIME_DUE) == Transition(CONFIGURED, (ASK_TIME,))
    assert find_transition(WAITING, TIME_DUE) == Transition(WAITING)
    assert (
        find_transition(CONFIGURED, HOST_LOST)
        == find_transition(CONFIGURED, STOP_RECEIVED)
        == Transition(WAITING)
    )
