"""Backoff of frequency measurements for traces that are not periodic."""

import math
from typing import Dict, Optional, Tuple

from topic_scope.analysis.measurement import Measurement
from topic_scope.analysis.periods import NO_PERIOD

#: The frequency is measured in one of this number of rounds.
ROUNDS = 4


class FrequencyBackoff:
    """Record of the traces of a page without a frequency in recent rounds.

    Rejecting a frequency takes several times as long as measuring one, because all methods must
    fail. So it is measured less often while a page follows the time, in different rounds for
    different traces.
    """

    def __init__(self) -> None:
        self._round = 0
        self._span = (math.nan, math.nan)
        #: Round of each trace, by name.
        self._turns: Dict[str, int] = {}

    def begin(self, span: Tuple[float, float], now: float) -> None:
        """Start a round; measure all traces again if the span changed or does not move.

        :param span: start and end of the measured span [s]
        :param now: the time [s]
        """
        self._round += 1
        ago = round(now - span[0], 3), round(now - span[1], 3)
        if ago != self._span:
            self._turns.clear()
        self._span = ago

    def known(self, name: str) -> Optional[Measurement]:
        """Return the frequency of a trace if it is not measured in this round.

        :param name: name of the trace
        """
        turn = self._turns.get(name, self._round)
        return None if (self._round - turn) % ROUNDS == 0 else NO_PERIOD

    def keep(self, name: str, frequency: Measurement) -> None:
        """Store whether a trace has a frequency.

        :param name: name of the trace
        :param frequency: the measurement
        """
        if frequency == NO_PERIOD:
            self._turns.setdefault(name, len(self._turns))
        else:
            self._turns.pop(name, None)
