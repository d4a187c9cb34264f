"""Table of a board's topics and services, from its announcements after each topic request."""

from typing import Dict, List, NamedTuple, Optional, Set, Tuple

from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    TopicInfo,
    problem_of,
)

#: A round ends after this time without an announcement [s].
SETTLED_S = 0.2
#: Most repetitions of a damaged round.
MOST_ROUNDS = 20
#: Most announcements of a board: rosserial allows 25 in each direction; boards with more memory may
#: have more.
MOST_TOPICS = 250

SERVICES = (SERVICE_SERVER, SERVICE_CLIENT)


class Endpoint(NamedTuple):
    """A topic or service of a board.

    :param kind: PUBLISHER, SUBSCRIBER, SERVICE_SERVER or SERVICE_CLIENT, from the board's view
    :param name: of the topic or service
    :param type: of the message or service
    :param incoming: info of the messages from the board; None for a subscriber
    :param outgoing: info of the messages to the board; None for a publisher
    """

    kind: int
    name: str
    type: str
    incoming: Optional[TopicInfo]
    outgoing: Optional[TopicInfo]

    @property
    def is_service(self) -> bool:
        """Whether it is a service, whose messages must not be lost."""
        return self.kind in SERVICES


class TopicTable:
    """Table of a board's topics, as far as announced.

    On each request a board announces all of its topics: a round. A topic that two undamaged rounds
    in succession lack is removed: over Wi-Fi, a round may seem to end before its last announcement,
    also that of a restarted board. After a damaged round all known topics are kept, and another
    round fills the gaps. On a line that damages one byte in a hundred, one announcement in
    900 is wrong despite valid checksums. So once any damage has occurred, each topic needs two
    equal announcements, and only two equal ones replace it. The same holds for an invalid topic,
    because a single announcement may be damaged. Time is an argument [s].

    :param frame_s: time on the line of a frame that announces a topic [s]
    """

    def __init__(self, frame_s: float = 0.0) -> None:
        self._settled_s = SETTLED_S + frame_s
        #: By direction (0: from the board) and topic id: the announcing id, and the info.
        self._infos: Dict[Tuple[int, int], Tuple[int, TopicInfo]] = {}
        #: Cache of :meth:`incoming`: topics and services of the board by topic id.
        self._incoming: Dict[int, Endpoint] = {}
        self._seen: Set[Tuple[int, int]] = set()
        #: Announced only once.
        self._unconfirmed: Set[Tuple[int, int]] = set()
        #: Announced only once, and either invalid or different from a known topic.
        self._suspects: Dict[Tuple[int, int], Tuple[int, TopicInfo]] = {}
        #: Announced in the last complete round, perhaps before a restart; and lacking since.
        self._last: Set[Tuple[int, int]] = set()
        self._lacking: Set[Tuple[int, int]] = set()
        self._ends_at: Optional[float] = None
        self._is_damaged = self._is_noisy = self._is_final = False
        #: Damaged and aborted rounds since the last complete round.
        self._rounds = 0
        #: Whether the board has announced all topics since its start, in an undamaged round.
        self.is_complete = False

    def reset(self) -> None:
        """Clear the topics: the board was restarted, perhaps with another sketch."""
        self._infos, self.is_complete = {}, False
        self._incoming.clear()
        self._unconfirmed.clear()
        self._suspects.clear()
        self._rounds, self._is_final = 0, False

    @property
    def is_settled(self) -> bool:
        """Whether no round is in progress."""
        return self._ends_at is None

    def begin_round(self, now: float, is_answering: bool = True, patience: float = 0.0) -> None:
        """Begin a round, after a topic request.

        :param now: the time [s]
        :param is_answering: whether the board has answered since its start; before, no round counts
            as a repetition
        :param patience: time the board may take to answer [s]
        """
        goes_on = is_answering and not self._is_final
        self._rounds = self._rounds + 1 if goes_on else 1
        self._is_final = False
        self._seen.clear()
        self._ends_at, self._is_damaged = now + max(self._settled_s, patience), False

    def add(self, now: float, info_id: int, info: TopicInfo) -> bool:
        """Add an announcement of a topic, or of half of a service.

        :param now: the time [s]
        :param info_id: the id of the announcing frame
        :param info: its content
        :returns: False if the table is full
        """
        self._incoming.clear()
        key = (info_id % 2, info.topic_id)
        if key not in self._infos and len(self._infos) >= MOST_TOPICS:
            return False
        entry = self._infos.get(key)
        if entry == (info_id, info):
            self._unconfirmed.discard(key)
            self._suspects.pop(key, None)
        elif problem_of(info) or (entry is not None and self._is_noisy):
            self._add_suspect(key, (info_id, info))
        else:
            self._infos[key] = (info_id, info)
            self._unconfirmed.add(key)
        self._seen.add(key)
        self._ends_at = now + self._settled_s
        return True

    def _add_suspect(self, key: Tuple[int, int], entry: Tuple[int, TopicInfo]) -> None:
        if self._suspects.get(key) == entry:
            self._infos[key] = self._suspects.pop(key)
            self._unconfirmed.discard(key)
        else:
            self._suspects[key] = entry
            self.mark_damaged()

    def mark_damaged(self) -> None:
        """Mark the round as damaged: a topic may have been lost."""
        self._is_damaged = self._is_noisy = True

    def end_round(self, now: float) -> Optional[bool]:
        """End the round if its time is over.

        :param now: the time [s]
        :returns: None if it is still in progress, or ended before; else whether all topics are
            known, or another round is needed
        """
        if self._ends_at is None or now < self._ends_at:
            return None
        self._ends_at = None
        self._incoming.clear()
        if self._seen and not self._is_damaged:
            before, self._lacking = self._lacking, self._last - self._seen
            if self._lacking <= before:
                self._complete()
            else:
                self._is_damaged = True
        is_good = not (self._is_damaged or self._is_noisy and self._unconfirmed)
        self._is_final = is_good or self._rounds >= MOST_ROUNDS
        return self._is_final

    def _complete(self) -> None:
        self._infos = {key: entry for key, entry in self._infos.items() if key in self._seen}
        self._unconfirmed &= self._seen
        self._last, self._lacking = set(self._seen), set()
        self.is_complete = True

    def incoming(self, topic_id: int) -> Optional[Endpoint]:
        """Return the topic or service of a frame from the board; None if unknown.

        :param topic_id: of the frame
        """
        found = self._incoming.get(topic_id)
        if found is None:
            entry = self._infos.get((PUBLISHER, topic_id))
            found = self._endpoint(*entry) if entry else None
            if found is not None:
                self._incoming[topic_id] = found
        return found

    def accepts(self, info: TopicInfo) -> bool:
        """Return whether the board has announced this info since its last start.

        :param info: of a topic to the board
        """
        entry = self._infos.get((SUBSCRIBER, info.topic_id))
        return entry is not None and entry[1] == info

    def endpoints(self) -> List[Endpoint]:
        """Return the topics, and the services of which both halves are known."""
        found = {self._endpoint(*entry): None for entry in self._infos.values()}
        return [one for one in found if one is not None]

    @property
    def longest(self) -> int:
        """Longest message that the board can send, by its announcements [bytes]; 0 if unknown."""
        sizes = [
            info.buffer_size for (way, _), (_, info) in self._infos.items() if way == PUBLISHER
        ]
        return max(sizes, default=0)

    def _endpoint(self, info_id: int, info: TopicInfo) -> Optional[Endpoint]:
        if info_id == PUBLISHER:
            return Endpoint(PUBLISHER, info.name, info.type, info, None)
        if info_id == SUBSCRIBER:
            return Endpoint(SUBSCRIBER, info.name, info.type, None, info)
        if info_id in SERVICES:
            for other, half in self._infos.values():
                is_other_half = other == info_id + SUBSCRIBER and half.name == info.name
                if is_other_half and half.type == info.type:
                    return Endpoint(info_id, info.name, info.type, info, half)
        return None
