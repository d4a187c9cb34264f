"""Keep a declared set of parameters in step with the parameter server.

A node in a few lines::

    parameters = LiveParameters(BlinkerParameters)
    parameters.start(on_change=lambda new, old: timer.set_rate(new.rate))
    ...
    parameters.values.rate  # a plain attribute: no call to the master
"""

import threading
import time
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    Generic,
    List,
    Mapping,
    Optional,
    Sequence,
    Set,
    Tuple,
    Type,
    TypeVar,
)

import rospy

from nodekit.live import reconfigure
from nodekit.live.description import offer_description
from nodekit.live.watcher import Observation, ParameterWatcher, Watch, get_watcher
from nodekit.parameters.contention import Contention
from nodekit.parameters.declaration import ParameterError, ParameterSet, RuleError, shown, to_wire
from nodekit.parameters.no_value import MISSING, UNREADABLE
from nodekit.parameters.settling import Settled, settle, unknown_names

Snapshot = TypeVar("Snapshot", bound=ParameterSet)
Listener = Callable[[Snapshot, Snapshot], None]

#: How long values that do not go together may stand before they are refused, s:
#: on a busy machine "rosparam load" may pause between one leaf and the next.
PATIENCE_S = 0.2


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
        self._listeners: List[Listener[Snapshot]] = []
        self._lock = threading.RLock()
        self._warned: Set[str] = set()
        self._refused: Set[str] = set()
        self._contention = Contention()
        self._last_raw: Dict[str, Any] = {}
        self._written_at = 0.0
        self._broken_since: Optional[float] = None
        self._telling = False
        # Subscribed before it is read: a change in between is not missed.
        self._watcher.subscribe(self)
        try:
            self.values = self._told = self._read_at_start(declaration)
        except Exception:
            self._watcher.remove(self)
            raise

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
        self._write(raw, settled.writes, at_once=True)
        return settled.values  # type: ignore[return-value]

    def start(self, on_change: Optional[Listener[Snapshot]] = None) -> None:
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

    def add_listener(self, on_change: Listener[Snapshot]) -> None:
        """Have one more function called with each change.

        :param on_change: as in :meth:`start`
        """
        self._listeners.append(on_change)

    def update(self, **changes: Any) -> None:
        """Change values from within the node, on the server too.

        :param changes: new values by name
        :raises ParameterError: if a value or a combination is not allowed;
            nothing is changed then
        :raises UNREACHABLE: if the master does not answer; nothing is changed then
        """
        with self._lock:
            old = self.values
            try:
                new = old.replace(**changes)
            except ParameterError as error:
                raise self._named(error) from None
            changed = {k: to_wire(v) for k, v in new.as_dict().items() if getattr(old, k) != v}
            self._send(changed)
            # Newer than what is on its way: no notification may take it back.
            self._contention.forget(changed)
            if isinstance(self.known, dict):
                self.known = {**self.known, **changed}
            self._bring_into_force(new)

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
            settled = settle(
                self.values,
                raw,
                missing=self.values if seen.forgotten else None,
                overwritten=self._contention.overwritten(
                    self.values, raw, self._by_name(seen.pushed), time.monotonic()
                ),
            )
            if self._may_be_half_done(settled):
                self._watcher.ring()
                return False
            self._warn_of_refused(settled)
            self._warn_of_unknown(self.values.declared, raw)
            try:
                # Before any listener may write something newer.
                self._write(raw, settled.writes, at_once=seen.forgotten)
            finally:
                self._bring_into_force(settled.values)  # type: ignore[arg-type]
            self._broken_since = None
            return True

    def _may_be_half_done(self, settled: Settled) -> bool:
        """Tell whether values that do not go together may yet be followed by others that do."""
        now = time.monotonic()
        if not any(isinstance(error, RuleError) for error in settled.refusals):
            self._broken_since = None
        elif self._broken_since is None:
            self._broken_since = now
        return self._broken_since is not None and now - self._broken_since < PATIENCE_S

    def _by_name(self, pushed: Sequence[Tuple[str, Any]]) -> List[Tuple[str, Any]]:
        """Take notifications of the namespace apart into those of its parameters."""
        parts: List[Tuple[str, Any]] = []
        for key, value in pushed:
            if key != self.key:
                parts.append((key[len(self.key) + 1 :], value))
            elif isinstance(value, dict) or value is MISSING:
                tree = value if value is not MISSING else {}
                parts += [(name, tree.get(name, MISSING)) for name in self.values.declared]
        return parts

    def _bring_into_force(self, new: Snapshot) -> None:
        before, self.values = self.values.as_dict(), new
        for name, value in new.as_dict().items():
            if value != before[name]:
                text = "%s/%s: %s -> %s"
                rospy.loginfo(text, self.key, name, shown(before[name]), shown(value))
        if self._telling:
            return  # a listener has changed values: the loop below tells of it
        self._telling = True
        while self.values != self._told:
            old, self._told = self._told, self.values
            for listener in list(self._listeners):
                self._tell(listener, self._told, old)
        self._telling = False

    def _tell(self, listener: Listener[Snapshot], new: Snapshot, old: Snapshot) -> None:
        try:
            listener(new, old)
        except Exception:  # a listener's defect must not end the watcher for all
            rospy.logerr("%s: a listener failed", self.key, exc_info=True)

    def _write(self, raw: Mapping[str, Any], writes: Mapping[str, Any], at_once: bool) -> None:
        """Make the server tell the truth, or later what would be written too often."""
        now = time.monotonic()
        allowed = {k: v for k, v in writes.items() if at_once or self._contention.allow(k, now)}
        for name, value in allowed.items():
            self._contention.note(name, value, now)
        self._send(allowed)
        self.known = self._last_raw = {**raw, **writes}
        if len(allowed) == len(writes):
            self._refused.clear()

    def _send(self, values: Mapping[str, Any]) -> None:
        if not values:
            return
        self._server.write({"%s/%s" % (self.key, name): value for name, value in values.items()})
        self._written_at = time.monotonic()

    def _restore_namespace(self, raw: Any) -> None:
        rospy.logwarn("%s; all values stay in force", self._not_a_namespace(raw))
        values = {name: to_wire(value) for name, value in self.values.as_dict().items()}
        rest = {k: value for k, value in self._last_raw.items() if value is not UNREADABLE}
        self.known = {**rest, **values}
        self._server.write({self.key: self.known})
        self._written_at = time.monotonic()

    def _not_a_namespace(self, raw: Any) -> ParameterError:
        return ParameterError(self.key, raw, "a namespace with the node's parameters")

    def _named(self, error: ParameterError) -> ParameterError:
        names = ", ".join("%s/%s" % (self.key, name) for name in error.name.split(", "))
        return ParameterError(names, error.value, error.allowed, error.reason)

    def _warn_of_refused(self, settled: Settled) -> None:
        """Warn of what is refused, once also if it is put back only later."""
        refused = {str(error): error for error in settled.refusals}
        for text, error in refused.items():
            if text not in self._refused:
                kept = {name: getattr(settled.values, name) for name in error.name.split(", ")}
                rospy.logwarn("%s; in force is %s", self._named(error), _settings(kept))
        self._refused = set(refused)  # until it is put back

    def _warn_of_unknown(self, declared: Collection[str], raw: Mapping[str, Any]) -> None:
        for name, nearest in unknown_names(declared, raw, self._exempt).items():
            if name not in self._warned:
                self._warned.add(name)
                hint = "; did you mean %s?" % nearest if nearest else ""
                rospy.logwarn("parameter %s/%s is not used by this node%s", self.key, name, hint)


def _settings(values: Mapping[str, Any]) -> str:
    return ", ".join("%s=%s" % (name, shown(value)) for name, value in values.items())
