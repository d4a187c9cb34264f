"""Share parameters with other writers, on a server that has no compare-and-set.

A write that puts a bad value back may hit a newer, good one. The notifications
tell of it afterwards. And two programs that correct each other must not do so
in an endless quick loop.
"""

from collections import defaultdict
from typing import Any, DefaultDict, Dict, Iterable, List, Mapping, Sequence, Tuple

from nodekit.parameters.declaration import ParameterSet, to_wire
from nodekit.parameters.kinds import is_same
from nodekit.parameters.no_value import MISSING
from nodekit.parameters.settling import is_allowed, last_allowed

#: How long after a write a notification may still tell of a value that the
#: write has replaced, s.
OVERLAP_S = 5.0
#: Writes of one parameter that may follow each other at once.
BURST = 20
#: Time after which one more of them may follow, s.
REFILL_S = 1.0


class Contention:
    """What one writer wrote lately, and how often it may go on."""

    def __init__(self) -> None:
        self._written: Dict[str, Tuple[Any, float]] = {}
        self._budget: Dict[str, Tuple[float, float]] = {}

    def allow(self, name: str, now: float) -> bool:
        """Tell whether a parameter may be written now, or only later (a token bucket).

        :param name: name of the parameter
        :param now: the time, s
        """
        left, since = self._budget.get(name, (float(BURST), now))
        left = min(float(BURST), left + (now - since) / REFILL_S)
        allowed = left >= 1.0
        self._budget[name] = (left - 1.0 if allowed else left, now)
        return allowed

    def note(self, name: str, value: Any, now: float) -> None:
        """Remember a write.

        :param name: name of the parameter
        :param value: what is written, as the server takes it
        :param now: the time, s
        """
        self._written[name] = (value, now)

    def forget(self, names: Iterable[str]) -> None:
        """Forget writes: what stands there now is newer than any notification.

        :param names: names of the parameters
        """
        for name in names:
            self._written.pop(name, None)

    def overwritten(
        self,
        in_force: ParameterSet,
        raw: Mapping[str, Any],
        pushed: Sequence[Tuple[str, Any]],
        now: float,
    ) -> Dict[str, Any]:
        """Find good values that were replaced before anybody read them.

        Those are the last good ones before a bad one, and what a write of ours
        that still stands has replaced.

        :param in_force: a set that declares the parameters
        :param raw: the namespace as the server holds it, read after the last write
        :param pushed: notified (name, raw value), oldest first
        :param now: the time, s
        :returns: raw values by name
        """
        self._written = {
            name: (value, at)
            for name, (value, at) in self._written.items()
            if name in raw and is_same(raw[name], value) and now - at < OVERLAP_S
        }
        rivals: DefaultDict[str, List[Any]] = defaultdict(list)
        for name, value in pushed:
            declared = in_force.declared.get(name)
            if declared is None:
                continue
            bad = name in raw and not is_allowed(declared, raw[name])
            if bad or name in self._written:
                rivals[name].append(value if value is not MISSING else to_wire(declared.default))
        return last_allowed(in_force, rivals)
