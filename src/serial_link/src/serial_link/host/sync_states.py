"""State table of the synchronization with a board."""

from typing import Dict, NamedTuple, Tuple

#: States. CLOSED: the port is not open. ASKED: the topics were requested. SEEKING: the request was
#: not answered, and the board is probed. HEARD: the board requested the time, in answer to the
#: topic request or to a probe. SYNCED: the board answers. SILENT: no recent frame has proven that
#: the board is configured. PROBING: as SILENT, and the board has requested the time.
CLOSED, ASKED, SEEKING, HEARD, SYNCED, SILENT, PROBING = (
    "closed",
    "asked",
    "seeking",
    "heard",
    "synced",
    "silent",
    "probing",
)
STATES = (CLOSED, ASKED, SEEKING, HEARD, SYNCED, SILENT, PROBING)

#: Events: the port was opened or lost; a frame arrived (see below); a timeout has elapsed;
#: rosserial's library has forgotten the host by now; a sketch without topics has answered.
OPENED, LOST = "opened", "lost"
#: Frames, and what they prove, according to rosserial's node_handle.h. A board is configured from
#: its answer to the topic request until it is reset.
#: TOPIC announces a topic: the board is answering, and is configured.
#: MESSAGE belongs to a known topic or service: the library sends these only while configured.
#: UNKNOWN has an unknown topic id: configured, but perhaps by another host or with another sketch.
#: TIME requests the time: a configured board does so every 2.5 s, and any board when its topics are
#: requested; an unconfigured board also answers a probe with it, so two in a row prove a reset.
#: NOTICE is a log line, a parameter request or an unknown special id: a board also sends these
#: before it is configured, so they prove nothing.
#: DAMAGED is a corrupt frame: an answer may have been lost.
TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE = "topic", "time", "message", "unknown", "notice"
DAMAGED = "damaged"
DUE, OVERDUE, EMPTY = "due", "overdue", "empty"
EVENTS = (OPENED, LOST, TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE, DAMAGED, DUE, OVERDUE, EMPTY)

#: Actions: request the topics; send a probe, which only an unconfigured board answers; drop pending
#: messages for the board from before its restart.
ASK, PROBE, RESTART = "ask", "probe", "restart"


class Transition(NamedTuple):
    """Reaction to an event.

    :param state: the next state
    :param action: what to do, empty for nothing
    """

    state: str
    action: str = ""


#: A board that was reset stays silent until its topics are requested, so only silence reveals a
#: reset. A quick board is briefly silent only after a reset; a board that only subscribes is always
#: silent. So a silent board is probed: only an unconfigured board answers, with a time request. The
#: others request the time every 2.5 s; hence the second probe, which they do not answer.
#:
#: A sketch that blocks in its loop reads nothing, and bytes sent to it wait in the 64-byte buffer
#: of an AVR's port, where each topic request costs one iteration of its loop. So only one topic
#: request is pending at a time: a board that missed it proves by its answer to a two-byte probe
#: that it is listening now. It answers all probes in its buffer together, so two probes per
#: iteration suffice.
#:
#: A board announces its topics right after the time request that answers the topic request. If none
#: followed, the first message proves that the sketch has advertised topics since: it is asked.
TABLE: Dict[Tuple[str, str], Transition] = {
    (CLOSED, OPENED): Transition(ASKED, ASK),
    (ASKED, LOST): Transition(CLOSED, RESTART),
    (ASKED, TOPIC): Transition(SYNCED),
    (ASKED, EMPTY): Transition(SYNCED),
    (ASKED, DUE): Transition(SEEKING, PROBE),
    (SEEKING, LOST): Transition(CLOSED, RESTART),
    (SEEKING, TOPIC): Transition(SYNCED),
    (SEEKING, TIME): Transition(HEARD),
    (SEEKING, UNKNOWN): Transition(ASKED, ASK),
    (SEEKING, DAMAGED): Transition(ASKED, ASK),
    (SEEKING, DUE): Transition(SEEKING, PROBE),
    (SEEKING, OVERDUE): Transition(ASKED, ASK),
    (HEARD, LOST): Transition(CLOSED, RESTART),
    (HEARD, TOPIC): Transition(SYNCED),
    (HEARD, TIME): Transition(ASKED, ASK),
    (HEARD, NOTICE): Transition(ASKED, ASK),
    (HEARD, UNKNOWN): Transition(ASKED, ASK),
    (HEARD, DUE): Transition(ASKED, ASK),
    (SYNCED, LOST): Transition(CLOSED, RESTART),
    (SYNCED, UNKNOWN): Transition(SYNCED, ASK),
    (SYNCED, DUE): Transition(SILENT, PROBE),
    (SILENT, LOST): Transition(CLOSED, RESTART),
    (SILENT, TOPIC): Transition(SYNCED),
    (SILENT, TIME): Transition(PROBING, PROBE),
    (SILENT, MESSAGE): Transition(SYNCED),
    (SILENT, UNKNOWN): Transition(SYNCED, ASK),
    (SILENT, DUE): Transition(SILENT, PROBE),
    (SILENT, OVERDUE): Transition(ASKED, RESTART),
    (PROBING, LOST): Transition(CLOSED, RESTART),
    (PROBING, TOPIC): Transition(SYNCED),
    (PROBING, TIME): Transition(ASKED, RESTART),
    (PROBING, MESSAGE): Transition(SYNCED),
    (PROBING, UNKNOWN): Transition(SYNCED, ASK),
    (PROBING, DUE): Transition(SILENT, PROBE),
}


def find_transition(state: str, event: str) -> Transition:
    """Return the transition of an event in a state; no change if the table has no row."""
    return TABLE.get((state, event), Transition(state))
