"""Random access to the messages of a recording, for those that the player has passed."""

from typing import List, Optional

import numpy

from topic_scope.bag.opening import open_bag
from topic_scope.bag.player import distinct_times
from topic_scope.bag.recording import ConnectionMessages, Recording
from topic_scope.timing.nanoseconds import NS

#: Messages recorded within this time before a message may have delayed it: the player spreads
#: messages with equal times [ns].
_BEFORE_NS = NS // 1000


class MessageFinder:
    """Finder of single messages, with its own access to the recording; for use by one thread.

    :param path: the recording
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._bag: Optional[Recording] = None

    def find(self, topic: str, time: int) -> Optional[bytes]:
        """Return the message that the player outputs at a time.

        :param topic: global name
        :param time: as in the player's batches [ns]
        :returns: the serialized message; None if not found
        :raises BagError: if the recording is damaged
        """
        if self._bag is None:
            self._bag = open_bag(self._path)
        bag = self._bag
        parts: List[ConnectionMessages] = []
        numbers, starts = bag.chunks_after(time - _BEFORE_NS)
        for number, start in zip(numbers, starts):
            if start <= time:
                found = bag.read(number, bag.numbers_of([topic]))
                parts += [part.between(time - _BEFORE_NS, time + 1) for part in found]
        parts = [part for part in parts if part.messages]
        if not parts:
            return None
        output = numpy.concatenate(distinct_times([part.times for part in parts], 0))
        messages = [message for part in parts for message in part.messages]
        place = int(numpy.where(output <= time, output, 0).argmax())
        return messages[place]
