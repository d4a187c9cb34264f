"""Channels: numeric message fields over time, and detection of the one that carries the signal."""

import math
from typing import List, NamedTuple, Optional, Sequence

from pid_control.signal_judging.sine_fit import is_constant

#: Parts of names of a signal, the most specific first.
_NAMES = ("signal", "proc", "sin", "output", "value", "data", "y")

#: Share of the intervals of a loop that are equal, and how much longer than the median they may be.
_MOST, _LONGER = 0.9, 1.5


class Channel(NamedTuple):
    """A numeric field of the messages of a topic, over time.

    :ivar topic: global name of the topic
    :ivar field: name of the field; empty for all of them
    :ivar times: time of arrival of each message [s]
    :ivar values: value in each message
    """

    topic: str
    field: str
    times: Sequence[float]
    values: Sequence[float]

    @property
    def name(self) -> str:
        """Topic and field."""
        return f"{self.topic}/{self.field}" if self.field else self.topic

    def between(self, begin: float, end: float = math.inf) -> "Channel":
        """Return the part from one time up to, and excluding, another [s]."""
        chosen = [index for index, time in enumerate(self.times) if begin <= time < end]
        times = [self.times[index] for index in chosen]
        return self._replace(times=times, values=[self.values[index] for index in chosen])

    def finite(self) -> "Channel":
        """Return the part with finite values."""
        chosen = [index for index, value in enumerate(self.values) if math.isfinite(value)]
        times = [self.times[index] for index in chosen]
        return self._replace(times=times, values=[self.values[index] for index in chosen])

    def rate(self) -> Optional[float]:
        """Return the number of messages per second; None for fewer than three."""
        if len(self.times) < 3 or self.times[-1] <= self.times[0]:
            return None
        return (len(self.times) - 1) / (self.times[-1] - self.times[0])

    def is_regular(self) -> bool:
        """Return True if nearly all of several messages come at the same interval."""
        steps = sorted(after - before for before, after in zip(self.times, self.times[1:]))
        return steps[int(_MOST * len(steps))] <= _LONGER * steps[len(steps) // 2]


class AmbiguousChannelsError(Exception):
    """Error of several channels that may be the signal; the text lists them."""


def oscillates(channel: Channel) -> bool:
    """Return True if a channel both rises and falls: a time or a constant does not."""
    values = channel.finite().values
    if len(values) < 3 or is_constant(values):
        return False
    changes = [after - before for before, after in zip(values, values[1:])]
    return any(change > 0.0 for change in changes) and any(change < 0.0 for change in changes)


def signal_of(channels: Sequence[Channel]) -> Optional[Channel]:
    """Return the channel that is a signal; None if none oscillates.

    :param channels: all channels of a node
    :raises AmbiguousChannelsError: if several oscillate, and their names do not decide
    """
    found = [channel for channel in channels if oscillates(channel)]
    if len(found) <= 1:
        return found[0] if found else None
    for name in _NAMES:
        named = _with_name(found, name)
        if len(named) == 1:
            return named[0]
    names = ", ".join(channel.name for channel in found)
    raise AmbiguousChannelsError(names)


def _with_name(channels: Sequence[Channel], name: str) -> List[Channel]:
    if len(name) == 1:
        return [channel for channel in channels if channel.field == name]
    return [channel for channel in channels if name in channel.name.lower()]
