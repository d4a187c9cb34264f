"""Publishers under one name: a robot that was restarted, or two at once."""

from typing import Dict, List

#: Most publishers that are remembered.
_MOST = 8


class Publishers:
    """The publishers of messages that carry one name.

    A robot that is restarted has a new publisher, and its old one falls silent. Two are rivals
    when a message of the one follows one of the other, and then the other way round.

    :ivar has_rivals: whether several publish now
    """

    def __init__(self) -> None:
        self.has_rivals = False
        self._current = ""
        self._heard_at: Dict[str, float] = {}

    def add_message(self, publisher: str, now: float, memory_s: float) -> None:
        """Record a message.

        :param publisher: name of the node that sent it
        :param now: time, s
        :param memory_s: for how long who is silent is remembered, s
        """
        if publisher != self._current:
            self.forget(now, memory_s)
            self._current = publisher
            if publisher in self._heard_at or len(self._heard_at) >= _MOST:
                self.has_rivals = True
            # The latest one last: what has to go is the first.
            self._heard_at.pop(publisher, None)
            if len(self._heard_at) >= _MOST:
                del self._heard_at[next(iter(self._heard_at))]
        self._heard_at[publisher] = now

    def forget(self, now: float, memory_s: float) -> None:
        """Forget who has been silent; who is then alone has no rivals.

        :param now: time, s
        :param memory_s: for how long, s
        """
        if len(self._heard_at) > 1:
            self._heard_at = {
                name: heard_at
                for name, heard_at in self._heard_at.items()
                if now - heard_at <= memory_s or name == self._current
            }
            self.has_rivals = self.has_rivals and len(self._heard_at) > 1

    def names(self) -> List[str]:
        """Return the names of the publishers that are remembered, sorted."""
        return sorted(self._heard_at)
