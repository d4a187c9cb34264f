"""Backoff for traces without a measurable frequency."""

import math
from typing import Dict, Optional, Tuple

from topic_scope.analysis.measurement import Measurement
from topic_scope.analysis.periods import NO_PERIOD

#: It is looked for in one of so many rounds.
ROUNDS = 4


class FrequencyBackoff:
    """Record of the traces of a page that had no frequency in recent rounds.

    To refuse a frequency takes several times as long as to measure one, as all ways to find it have
    to fail. So it is looked for less often while a page goes with the time, and in other rounds for
    other traces.
    """

    def __init__(self) -> None:
        self._round = 0
        self._span = (math.nan, math.nan)
        #: When it is their turn, by name.
        self._turns: Dict[str, int] = {}

    def begin(self, span: Tuple[float, float], now: float) -> None:
        """Start a round; measure all traces again if the span is another one or stands still.

        :param span: begin and end of what is measured [s]
        :param now: the time [s]
        """
        self._round += 1
        ago = round(now - span[0], 3), round(now - span[1], 3)
        if ago != self._span:
            self._turns.clear()
        self._span = ago

    def known(self, name: str) -> Optional[Measurement]:
        """Return the frequency of a trace if it is not looked for in this round.

        :param name: of the trace
        """
        turn = self._turns.get(name, self._round)
        return None if (self._round - turn) % ROUNDS == 0 else NO_PERIOD

    def keep(self, name: str, frequency: Measurement) -> None:
        """Store whether a trace has a frequency.

        :param name: of the trace
        :param frequency: what was measured
        """
        if frequency == NO_PERIOD:
            self._turns.setdefault(name, len(self._turns))
        else:
            self._turns.pop(name, None)
