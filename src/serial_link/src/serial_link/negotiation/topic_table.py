"""Table of a board's topics and services, filled round by round."""

from typing import Dict, List, NamedTuple, Optional, Set, Tuple

from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    TopicInfo,
    problem_of,
)

#: A round is over when nothing has been told for this long [s].
SETTLED_S = 0.2
#: A damaged round is followed by another, but by no more than this many.
MOST_ROUNDS = 20
#: Most topics and halves of services of a board: rosserial has 25 of either direction, and boards
#: with more memory may have more.
MOST_TOPICS = 250

SERVICES = (SERVICE_SERVER, SERVICE_CLIENT)


class Endpoint(NamedTuple):
    """A topic or a service that a board has.

    :param kind: PUBLISHER, SUBSCRIBER, SERVICE_SERVER or SERVICE_CLIENT, as seen from the board
    :param name: of the topic or the service
    :param type: of the message or the service
    :param incoming: what the board sends; None of a subscriber
    :param outgoing: what the board receives; None of a publisher
    """

    kind: int
    name: str
    type: str
    incoming: Optional[TopicInfo]
    outgoing: Optional[TopicInfo]

    @property
    def is_service(self) -> bool:
        """Whether it is a service, none of whose messages may be lost."""
        return self.kind in SERVICES


class TopicTable:
    """The topics of a board, as far as it has told of them.

    A board tells of all of them each time that it is asked: that is a round. In a round without any
    damage, what it does not tell of is gone. Where something was damaged, what is known stays, and
    another round fills the gaps. On a line that damages one byte in a hundred, one topic in 900 is
    told wrong by a frame whose sums hold. So where anything was damaged ever, each has to be told
    twice alike, and is not replaced by what is told once. So has a topic that ROS cannot have: told
    once, it may be damage. Time is an argument [s].

    :param frame_s: how long the frame that tells of a topic is on the line [s]
    """

    def __init__(self, frame_s: float = 0.0) -> None:
        self._settled_s = SETTLED_S + frame_s
        #: By direction (0 for what the board sends) and id; the id that tells of it, and its info.
        self._infos: Dict[Tuple[int, int], Tuple[int, TopicInfo]] = {}
        self._seen: Set[Tuple[int, int]] = set()
        #: What was told once, or otherwise the last time.
        self._unconfirmed: Set[Tuple[int, int]] = set()
        #: Told once, and invalid.
        self._suspects: Dict[Tuple[int, int], Tuple[int, TopicInfo]] = {}
        self._ends_at: Optional[float] = None
        self._is_damaged = self._is_noisy = self._is_final = False
        #: Since a round that was complete: damaged ones, and those that were broken off.
        self._rounds = 0
        #: Whether the board has told of all since it was started, in a round without any damage.
        self.is_complete = False

    def reset(self) -> None:
        """Forget the topics: the board was restarted, perhaps with another sketch."""
        self._infos, self.is_complete = {}, False
        self._unconfirmed.clear()
        self._suspects.clear()
        self._rounds, self._is_final = 0, False

    @property
    def is_settled(self) -> bool:
        """Whether no round is under way."""
        return self._ends_at is None

    def begin_round(self, now: float, is_answering: bool = True, patience: float = 0.0) -> None:
        """Begin a round, as the board was asked.

        :param now: the time [s]
        :param is_answering: whether the board has answered since it was started; no round counts
            before, however many a line of noise has damaged
        :param patience: how long the board may take to answer [s]
        """
        goes_on = is_answering and not self._is_final
        self._rounds = self._rounds + 1 if goes_on else 1
        self._is_final = False
        self._seen.clear()
        self._ends_at, self._is_damaged = now + max(self._settled_s, patience), False

    def add(self, now: float, info_id: int, info: TopicInfo) -> bool:
        """Add what was told of one topic, or of one half of a service.

        :param now: the time [s]
        :param info_id: the id of the frame that told
        :param info: what it told
        :returns: whether there was room for it
        """
        key = (info_id % 2, info.topic_id)
        if key not in self._infos and len(self._infos) >= MOST_TOPICS:
            return False
        told = self._infos.get(key)
        if told == (info_id, info):
            self._unconfirmed.discard(key)
        elif problem_of(info):
            self._add_suspect(key, (info_id, info))
        else:
            if told is None or key in self._unconfirmed or not self._is_noisy:
                self._infos[key] = (info_id, info)
            self._unconfirmed.add(key)
        self._seen.add(key)
        self._ends_at = now + self._settled_s
        return True

    def _add_suspect(self, key: Tuple[int, int], told: Tuple[int, TopicInfo]) -> None:
        if self._suspects.get(key) == told:
            self._infos[key] = self._suspects.pop(key)
        else:
            self._suspects[key] = told
            self.mark_damaged()

    def mark_damaged(self) -> None:
        """Mark the round as damaged: a topic may have been lost."""
        self._is_damaged = self._is_noisy = True

    def end_round(self, now: float) -> Optional[bool]:
        """End the round, if it is over.

        :param now: the time [s]
        :returns: None if it is not over, or ended before; else whether all is known now, or another
            round is needed
        """
        if self._ends_at is None or now < self._ends_at:
            return None
        self._ends_at = None
        if self._seen and not self._is_damaged:
            self._infos = {key: told for key, told in self._infos.items() if key in self._seen}
            self._unconfirmed &= self._seen
            self.is_complete = True
        is_good = not (self._is_damaged or self._is_noisy and self._unconfirmed)
        self._is_final = is_good or self._rounds >= MOST_ROUNDS
        return self._is_final

    def incoming(self, topic_id: int) -> Optional[Endpoint]:
        """Return what a frame from the board is about, None if that is not known.

        :param topic_id: of the frame
        """
        told = self._infos.get((PUBLISHER, topic_id))
        return self._endpoint(*told) if told else None

    def accepts(self, info: TopicInfo) -> bool:
        """Tell whether the board takes messages by that info: now, not before it was restarted.

        :param info: as it was told
        """
        told = self._infos.get((SUBSCRIBER, info.topic_id))
        return told is not None and told[1] == info

    def endpoints(self) -> List[Endpoint]:
        """Return the topics, and those services of which both halves are known."""
        found = {self._endpoint(*told): None for told in self._infos.values()}
        return [one for one in found if one is not None]

    @property
    def longest(self) -> int:
        """The longest message that the board can send, as it tells itself [bytes]; 0 if unknown."""
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
