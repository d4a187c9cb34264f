"""State table of rosserial's board library: negotiation of topics, time, and lost hosts."""

from typing import Dict, NamedTuple, Tuple

#: States: not asked for its topics since the start; asked, and publishing.
WAITING, CONFIGURED = "waiting", "configured"
STATES = (WAITING, CONFIGURED)

#: Events: a frame that requests the topics, carries the time, stops publishing, or carries anything
#: else; the beginning of a frame of another version; the time to request the time; and the timeout
#: after the last time frame, after which the host counts as lost.
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

#: Actions: request the time, announce the topics, set the clock, deliver a message.
ASK_TIME, NEGOTIATE, SET_TIME, DELIVER = "ask time", "negotiate", "set time", "deliver"


class Transition(NamedTuple):
    """Reaction to an event.

    :param state: the next state
    :param actions: what to do, in order
    """

    state: str
    actions: Tuple[str, ...] = ()


TABLE: Dict[Tuple[str, str], Transition] = {
    (WAITING, TOPICS_REQUESTED): Transition(CONFIGURED, (ASK_TIME, NEGOTIATE)),
    (WAITING, OTHER_VERSION): Transition(WAITING, (ASK_TIME,)),
    (WAITING, TIME_RECEIVED): Transition(WAITING, (SET_TIME,)),
    (WAITING, MESSAGE): Transition(WAITING, (DELIVER,)),
    (CONFIGURED, TOPICS_REQUESTED): Transition(CONFIGURED, (ASK_TIME, NEGOTIATE)),
    (CONFIGURED, TIME_RECEIVED): Transition(CONFIGURED, (SET_TIME,)),
    (CONFIGURED, MESSAGE): Transition(CONFIGURED, (DELIVER,)),
    (CONFIGURED, STOP_RECEIVED): Transition(WAITING),
    (CONFIGURED, TIME_DUE): Transition(CONFIGURED, (ASK_TIME,)),
    (CONFIGURED, HOST_LOST): Transition(WAITING),
}


def find_transition(state: str, event: str) -> Transition:
    """Return the transition of an event in a state; the same state if the table has no row."""
    return TABLE.get((state, event), Transition(state))
