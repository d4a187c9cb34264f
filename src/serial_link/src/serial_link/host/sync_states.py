"""States of the synchronization with a board, as a table."""

from typing import Dict, NamedTuple, Tuple

#: States: the port is not open; it is, and the board is asked for its topics; the board answers;
#: no frame has proven for a moment that it is configured; it has asked for the time meanwhile.
CLOSED, NEGOTIATING, SYNCED, SILENT, PROBING = (
    "closed",
    "negotiating",
    "synced",
    "silent",
    "probing",
)
STATES = (CLOSED, NEGOTIATING, SYNCED, SILENT, PROBING)

#: Events: the port was opened or lost; a frame arrived (see below); it is time to do something
#: again; no frame has proven for so long that the board is configured that it has ceased to be.
OPENED, LOST = "opened", "lost"
#: Frames, and what each proves, by rosserial's node_handle.h. A board is configured once it has
#: answered the question for its topics, until it is reset.
#: TOPIC tells of a topic: the board answers the question, and is configured.
#: MESSAGE is of a known topic or service: the library sends these only while configured.
#: UNKNOWN is of an unknown one: configured, but perhaps by another host or with another sketch.
#: TIME asks for the time: a configured board does every 2.5 s, and any board that is asked for its
#: topics; but one that is not configured answers a probe by it, so twice at once proves a reset.
#: NOTICE is a log line, a parameter request or an unknown special id: a board sends these before
#: it is configured as well, so they prove nothing.
TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE = "topic", "time", "message", "unknown", "notice"
DUE, OVERDUE = "due", "overdue"
EVENTS = (OPENED, LOST, TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE, DUE, OVERDUE)

#: Actions: ask for the topics; send what only a board answers that waits to be asked; have what was
#: meant for the board before its restart forgotten.
ASK, PROBE, RESTART = "ask", "probe", "restart"


class Move(NamedTuple):
    """Reaction to an event.

    :param state: the next state
    :param action: what to do, empty for nothing
    """

    state: str
    action: str = ""


#: A board that was reset says nothing until it is asked, so silence is what shows it. A quick board
#: is silent for a moment only after a reset; one that only listens always is. So the silent board
#: is probed: only one that waits to be asked answers, with a request for the time. The others ask
#: for the time every 2.5 s; hence the second probe, which those do not answer.
TABLE: Dict[Tuple[str, str], Move] = {
    (CLOSED, OPENED): Move(NEGOTIATING, ASK),
    (NEGOTIATING, LOST): Move(CLOSED, RESTART),
    (NEGOTIATING, TOPIC): Move(SYNCED),
    (NEGOTIATING, TIME): Move(SYNCED),
    (NEGOTIATING, DUE): Move(NEGOTIATING, ASK),
    (SYNCED, LOST): Move(CLOSED, RESTART),
    (SYNCED, UNKNOWN): Move(SYNCED, ASK),
    (SYNCED, DUE): Move(SILENT, PROBE),
    (SILENT, LOST): Move(CLOSED, RESTART),
    (SILENT, TOPIC): Move(SYNCED),
    (SILENT, TIME): Move(PROBING, PROBE),
    (SILENT, MESSAGE): Move(SYNCED),
    (SILENT, UNKNOWN): Move(SYNCED, ASK),
    (SILENT, DUE): Move(SILENT, PROBE),
    (SILENT, OVERDUE): Move(NEGOTIATING, RESTART),
    (PROBING, LOST): Move(CLOSED, RESTART),
    (PROBING, TOPIC): Move(SYNCED),
    (PROBING, TIME): Move(NEGOTIATING, RESTART),
    (PROBING, MESSAGE): Move(SYNCED),
    (PROBING, UNKNOWN): Move(SYNCED, ASK),
    (PROBING, DUE): Move(SILENT, PROBE),
}


def move(state: str, event: str) -> Move:
    """Return what follows from an event in a state; without a row in the table, nothing does."""
    return TABLE.get((state, event), Move(state))
