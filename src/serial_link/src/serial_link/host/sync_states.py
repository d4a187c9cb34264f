"""States of the synchronization with a board, as a table."""

from typing import Dict, NamedTuple, Tuple

#: States. CLOSED: the port is not open. ASKED: a question for the topics is under way. SEEKING: it
#: was not answered, and the board is probed. HEARD: the board has asked for the time, in answer to
#: the question or to a probe. SYNCED: the board answers. SILENT: no frame has proven lately that
#: the board is configured. PROBING: the board has asked for the time meanwhile.
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

#: Events: the port was opened or lost; a frame arrived (see below); it is time to do something
#: again; rosserial's library has forgotten the host by now; a sketch without topics has answered.
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
#: DAMAGED cannot be read: an answer may have been lost.
TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE = "topic", "time", "message", "unknown", "notice"
DAMAGED = "damaged"
DUE, OVERDUE, EMPTY = "due", "overdue", "empty"
EVENTS = (OPENED, LOST, TOPIC, TIME, MESSAGE, UNKNOWN, NOTICE, DAMAGED, DUE, OVERDUE, EMPTY)

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
#:
#: A sketch that waits in its loop reads neither, and what it was sent waits in the 64 bytes of an
#: AVR's port, where each question costs a turn of its loop. So there is one question at a time: a
#: board that was not there for it shows by its answer to a probe, of two bytes, that it is now. It
#: answers at once all that wait there, so two probes a turn are enough.
TABLE: Dict[Tuple[str, str], Move] = {
    (CLOSED, OPENED): Move(ASKED, ASK),
    (ASKED, LOST): Move(CLOSED, RESTART),
    (ASKED, TOPIC): Move(SYNCED),
    (ASKED, EMPTY): Move(SYNCED),
    (ASKED, DUE): Move(SEEKING, PROBE),
    (SEEKING, LOST): Move(CLOSED, RESTART),
    (SEEKING, TOPIC): Move(SYNCED),
    (SEEKING, TIME): Move(HEARD),
    (SEEKING, DAMAGED): Move(ASKED, ASK),
    (SEEKING, DUE): Move(SEEKING, PROBE),
    (SEEKING, OVERDUE): Move(ASKED, ASK),
    (HEARD, LOST): Move(CLOSED, RESTART),
    (HEARD, TOPIC): Move(SYNCED),
    (HEARD, TIME): Move(ASKED, ASK),
    (HEARD, NOTICE): Move(ASKED, ASK),
    (HEARD, UNKNOWN): Move(ASKED, ASK),
    (HEARD, DUE): Move(ASKED, ASK),
    (SYNCED, LOST): Move(CLOSED, RESTART),
    (SYNCED, UNKNOWN): Move(SYNCED, ASK),
    (SYNCED, DUE): Move(SILENT, PROBE),
    (SILENT, LOST): Move(CLOSED, RESTART),
    (SILENT, TOPIC): Move(SYNCED),
    (SILENT, TIME): Move(PROBING, PROBE),
    (SILENT, MESSAGE): Move(SYNCED),
    (SILENT, UNKNOWN): Move(SYNCED, ASK),
    (SILENT, DUE): Move(SILENT, PROBE),
    (SILENT, OVERDUE): Move(ASKED, RESTART),
    (PROBING, LOST): Move(CLOSED, RESTART),
    (PROBING, TOPIC): Move(SYNCED),
    (PROBING, TIME): Move(ASKED, RESTART),
    (PROBING, MESSAGE): Move(SYNCED),
    (PROBING, UNKNOWN): Move(SYNCED, ASK),
    (PROBING, DUE): Move(SILENT, PROBE),
}


def move(state: str, event: str) -> Move:
    """Return what follows from an event in a state; without a row in the table, nothing does."""
    return TABLE.get((state, event), Move(state))
