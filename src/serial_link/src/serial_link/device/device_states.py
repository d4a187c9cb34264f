"""State table of rosserial's board library: when a board publishes."""

from typing import Dict, NamedTuple, Tuple

#: States: it was not asked for its topics since its start; it was, and publishes.
WAITING, CONFIGURED = "waiting", "configured"
STATES = (WAITING, CONFIGURED)

#: Events: frames that ask for the topics, tell the time, have it stop, or carry anything else; the
#: beginning of a frame of another version; it is time to ask for the time, or it was not told for
#: so long that the host is gone.
TOPICS_REQUESTED, TIME_RECEIVED, STOP_RECEIVED, MESSAGE = (
    "topics requested",
    "time received",
    "stop received",
    "message",
)
OTHER_VERSION, TIME_DUE, HOST_LOST = "other version", "time due", "host lost"
EVENTS = (
    TOPICS_REQUESTED,
    TIME_RECEIVED,
    STOP_RECEIVED,
    MESSAGE,
    OTHER_VERSION,
    TIME_DUE,
    HOST_LOST,
)

#: Actions, in their order.
ASK_TIME, NEGOTIATE, SET_TIME, DELIVER = "ask time", "negotiate", "set time", "deliver"


class Move(NamedTuple):
    """Reaction to an event.

    :param state: the next state
    :param actions: what to do, in order
    """

    state: str
    actions: Tuple[str, ...] = ()


TABLE: Dict[Tuple[str, str], Move] = {
    (WAITING, TOPICS_REQUESTED): Move(CONFIGURED, (ASK_TIME, NEGOTIATE)),
    (WAITING, OTHER_VERSION): Move(WAITING, (ASK_TIME,)),
    (WAITING, TIME_RECEIVED): Move(WAITING, (SET_TIME,)),
    (WAITING, MESSAGE): Move(WAITING, (DELIVER,)),
    (CONFIGURED, TOPICS_REQUESTED): Move(CONFIGURED, (ASK_TIME, NEGOTIATE)),
    (CONFIGURED, TIME_RECEIVED): Move(CONFIGURED, (SET_TIME,)),
    (CONFIGURED, MESSAGE): Move(CONFIGURED, (DELIVER,)),
    (CONFIGURED, STOP_RECEIVED): Move(WAITING),
    (CONFIGURED, TIME_DUE): Move(CONFIGURED, (ASK_TIME,)),
    (CONFIGURED, HOST_LOST): Move(WAITING),
}


def move(state: str, event: str) -> Move:
    """Return what follows from an event in a state; without a row in the table, nothing does."""
    return TABLE.get((state, event), Move(state))
