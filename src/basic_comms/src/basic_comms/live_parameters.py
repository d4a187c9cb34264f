"""Keep a declared set of parameters in step with the parameter server.

A node in a few lines::

    parameters = LiveParameters(BlinkerParameters)
    parameters.start(on_change=lambda new, old: timer.set_rate(new.rate))
    ...
    parameters.values.rate  # a plain attribute: no call to the master
"""

import threading
import time
from collections import defaultdict, deque
from typing import Any, Callable, Collection, DefaultDict, Deque, Dict, Generic, List, Mapping
from typing import Optional, Sequence, Set, Tuple, Type, TypeVar

import rospy

from basic_comms import reconfigure
from basic_comms.description import offer_description
from basic_comms.parameter_server import MISSING
from basic_comms.parameter_watch import Observation, ParameterWatcher, Watch, get_watcher
from basic_comms.parameters import ParameterError, ParameterSet, shown, to_wire
from basic_comms.settling import Settled, is_allowed, last_allowed, settle, unknown_names

Snapshot = TypeVar("Snapshot", bound=ParameterSet)

#: How long after a write of ours a notification may still tell of a value that
#: the write has replaced, s.
_OVERLAP_S = 5.0


class LiveParameters(Watch, Generic[Snapshot]):
    """The parameters of one node, or of one part of it, validated and live.

    Reads and validates the namespace, and writes the defaults of what is unset
    to the server. From :meth:`start` on it follows changes: a good one comes
    into force at once, a bad one is refused with one warning and put back.

    :param declaration: the class that declares the parameters
    :param namespace: where they stand; the node's private namespace by default
    :param exempt: names in the namespace that are used but not declared
    :param watcher: who reads the server; one for the process by default
    :raises ParameterError: if a value on the server is not allowed

    :ivar values: the snapshot in force; never changes itself, is replaced
    """

    values: Snapshot

    def __init__(
        self,
        declaration: Type[Snapshot],
        namespace: str = "~",
        exempt: Collection[str] = (),
        watcher: Optional[ParameterWatcher] = None,
    ) -> None:
        name = rospy.get_name() if namespace == "~" else rospy.resolve_name(namespace)
        super().__init__(name.rstrip("/"))
        self._watcher = watcher if watcher is not None else get_watcher()
        self._server = self._watcher.server
        self._exempt = exempt
        self._listeners: List[Callable[[Snapshot, Snapshot], None]] = []
        self._lock = threading.RLock()
        self._warned: Set[str] = set()
        self._put_back = _Writes()
        self._last_raw: Dict[str, Any] = {}
        self._written_at = 0.0
        # Subscribed before it is read: a change in between rings the bell.
        self._server.subscribe([self.key])
        self.values = self._read_at_start(declaration)

    def _read_at_start(self, declaration: Type[Snapshot]) -> Snapshot:
        raw = self._server.read([self.key]).values[self.key]
        if raw is MISSING:
            raw = {}
        if not isinstance(raw, dict):
            raise self._not_a_namespace(raw)
        settled = settle(declaration(), raw)
        if settled.refusals:
            raise self._named(settled.refusals[0])
        self._warn_of_unknown(declaration.declared, raw)
        self._write(raw, settled.writes, time.monotonic())
        return settled.values  # type: ignore[return-value]

    def start(self, on_change: Optional[Callable[[Snapshot, Snapshot], None]] = None) -> None:
        """Follow changes from now on, and describe the parameters when asked.

        :param on_change: called with the new and the old snapshot, once for
            each change; must be short, other changes wait for it
        """
        if on_change is not None:
            self.add_listener(on_change)
        rospy.loginfo("%s: %s", self.key, _settings(self.values.as_dict()))
        self._watcher.add(self)
        offer_description(self.key, lambda: self.values)
        if reconfigure.AVAILABLE:
            reconfigure.ReconfigureInterface(self)

    def add_listener(self, on_change: Callable[[Snapshot, Snapshot], None]) -> None:
        """Have one more function called with each change.

        :param on_change: as in :meth:`start`
        """
        self._listeners.append(on_change)

    def update(self, **changes: Any) -> None:
        """Change values from within the node, on the server too.

        :param changes: new values by name
        :raises ParameterError: if a value or a combination is not allowed;
            nothing is changed then
        :raises UNREACHABLE: if the master does not answer; the change is in
            force all the same and is written once it answers
        """
        with self._lock:
            old = self.values
            try:
                new = old.replace(**changes)
            except ParameterError as error:
                raise self._named(error) from None
            self._bring_into_force(new)
            changed = {k: to_wire(v) for k, v in new.as_dict().items() if getattr(old, k) != v}
            self._send(changed)

    def observe(self, seen: Observation) -> bool:
        """Judge what the server holds now; see :class:`parameter_watch.Watch`."""
        with self._lock:
            if seen.read_at < self._written_at:
                self._watcher.ring()  # read before our last write: says nothing of now
                return False
            raw = seen.value if seen.value is not MISSING else {}
            if not isinstance(raw, dict):
                self._restore_namespace(raw)
                return True
            now = time.monotonic()
            settled = settle(
                self.values,
                raw,
                missing=self.values if seen.forgotten else None,
                overwritten=self._overwritten(raw, seen.pushed, now),
            )
            for error in settled.refusals:
                self._warn(error, settled)
            self._warn_of_unknown(self.values.declared, raw)
            self._bring_into_force(settled.values)  # type: ignore[arg-type]
            return self._write(raw, settled.writes, now)

    def _overwritten(
        self, raw: Mapping[str, Any], pushed: Sequence[Tuple[str, Any]], now: float
    ) -> Dict[str, Any]:
        """Find good values that bad ones, or our own writes, have just replaced.

        The server has no compare-and-set, so a write of ours can hit a value
        that is newer than the one it is about. The notifications tell.
        """
        rivals: DefaultDict[str, List[Any]] = defaultdict(list)
        for name, value in self._by_name(pushed):
            if name not in self.values.declared:
                continue
            declared = self.values.declared[name]
            bad = name in raw and not is_allowed(declared, raw[name])
            if bad or self._put_back.stands(name, raw.get(name, MISSING), now):
                rivals[name].append(value if value is not MISSING else to_wire(declared.default))
        return last_allowed(self.values, rivals)

    def _by_name(self, pushed: Sequence[Tuple[str, Any]]) -> List[Tuple[str, Any]]:
        """Take notifications of the namespace apart into those of its parameters."""
        parts: List[Tuple[str, Any]] = []
        for key, value in pushed:
            if key != self.key:
                parts.append((key[len(self.key) + 1 :], value))
            elif isinstance(value, dict):
                parts += value.items()
        return parts

    def _bring_into_force(self, new: Snapshot) -> None:
        old = self.values
        if new == old:
            return
        self.values = new
        before = old.as_dict()
        for name, value in new.as_dict().items():
            if value != before[name]:
                text = "%s/%s: %s -> %s"
                rospy.loginfo(text, self.key, name, shown(before[name]), shown(value))
        for listener in list(self._listeners):
            try:
                listener(new, old)
            except Exception:  # a listener's defect must not end the watcher for all
                rospy.logerr("%s: a listener failed", self.key, exc_info=True)

    def _write(self, raw: Mapping[str, Any], writes: Mapping[str, Any], now: float) -> bool:
        """Make the server tell the truth; return False if some of it has to wait."""
        allowed: Dict[str, Any] = {}
        for name, value in writes.items():
            replaced = raw.get(name, MISSING)
            if self._put_back.may_write(name, replaced, now):
                self._put_back.note(name, replaced, value, now)
                allowed[name] = value
        self._last_raw = {**raw, **allowed}
        self._send(allowed)
        return len(allowed) == len(writes)

    def _send(self, values: Mapping[str, Any]) -> None:
        self._server.write({"%s/%s" % (self.key, name): value for name, value in values.items()})
        self._written_at = time.monotonic()

    def _restore_namespace(self, raw: Any) -> None:
        rospy.logwarn("%s; all values stay in force", self._not_a_namespace(raw))
        values = {name: to_wire(value) for name, value in self.values.as_dict().items()}
        self._server.write({self.key: {**self._last_raw, **values}})
        self._written_at = time.monotonic()

    def _not_a_namespace(self, raw: Any) -> ParameterError:
        return ParameterError(self.key, raw, "a namespace with the node's parameters")

    def _named(self, error: ParameterError) -> ParameterError:
        names = ", ".join("%s/%s" % (self.key, name) for name in error.name.split(", "))
        return ParameterError(names, error.value, error.allowed, error.reason)

    def _warn(self, error: ParameterError, settled: Settled) -> None:
        kept = {name: getattr(settled.values, name) for name in error.name.split(", ")}
        rospy.logwarn("%s; in force is %s", self._named(error), _settings(kept))

    def _warn_of_unknown(self, declared: Collection[str], raw: Mapping[str, Any]) -> None:
        for name, nearest in unknown_names(declared, raw, self._exempt).items():
            if name not in self._warned:
                self._warned.add(name)
                hint = "; did you mean %s?" % nearest if nearest else ""
                rospy.logwarn("parameter %s/%s is not used by this node%s", self.key, name, hint)


class _Writes:
    """What we wrote to the server lately, what it replaced, and how often.

    A program that keeps writing the same bad value is answered at once twenty
    times and then every ten seconds, so that two programs never overwrite each
    other in an endless quick loop.
    """

    BURST, WINDOW_S = 20, 10.0

    def __init__(self) -> None:
        self._last: Dict[str, Tuple[Any, float]] = {}
        self._replaced: Dict[str, Any] = {}
        self._times: DefaultDict[str, Deque[float]] = defaultdict(lambda: deque(maxlen=self.BURST))

    def may_write(self, name: str, raw: Any, now: float) -> bool:
        """Tell whether a raw value may be replaced now, or only later."""
        if self._replaced.get(name) != raw:
            self._times[name].clear()
        times = self._times[name]
        return len(times) < self.BURST or now - times[0] > self.WINDOW_S

    def note(self, name: str, raw: Any, value: Any, now: float) -> None:
        """Remember that a value replaces a raw one."""
        self._replaced[name] = raw
        self._last[name] = (value, now)
        self._times[name].append(now)

    def stands(self, name: str, raw: Any, now: float) -> bool:
        """Tell whether the server still holds what we wrote a moment ago."""
        value, at = self._last.get(name, (MISSING, 0.0))
        return value is not MISSING and bool(raw == value) and now - at < _OVERLAP_S


def _settings(values: Mapping[str, Any]) -> str:
    return ", ".join("%s=%s" % (name, shown(value)) for name, value in values.items())
