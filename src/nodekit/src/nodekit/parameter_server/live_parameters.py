"""Live parameters: a declared set that stays consistent with the parameter server."""

import contextlib
import threading
import time
from typing import Any, Callable, Collection, Dict, Generic, List, Mapping, Sequence, Tuple, Type

import rospy

from nodekit.argument_checks import check_function
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.parameter_server.watched_key import WatchedKey, call_listener
from nodekit.parameter_server.watcher import Watcher
from nodekit.parameters.declaration import ParameterSet, Rule, Snapshot
from nodekit.parameters.parameter_types import MISSING, ParameterError, format_value
from nodekit.parameters.reconciler import Decision, Observation, Reconciler
from nodekit.parameters.schema import AT_START
from nodekit.parameters.validation import on_wire

Listener = Callable[[], None]
#: Most namespaces that are opened at a time, to bound the memory of their values.
_OPENED_TOGETHER = 50
#: From this number of namespaces on, missing values are written before the subscription. For each
#: value written, the master searches all parameter subscriptions: 17 000 values of 500 groups took
#: 11 s, and 1.6 s before the subscription. With fewer, no value set meanwhile is lost.
WRITTEN_FIRST = 100
#: Most namespaces that are read before each of these writes, so that the write follows soon.
_WRITTEN_TOGETHER = 20


class LiveParameters(Generic[Snapshot]):
    """Validated, live parameters of a node.

    The constructor reads and validates the namespace. From :func:`open_all` on changes are
    followed: a valid one takes effect at once, an invalid one is rejected with one
    warning and reset.

    :param declaration: the class that declares the parameters
    :param namespace: global name of the parameters' namespace
    :param watcher: the process's watcher
    :param exempt: names in the namespace that are used but not declared; with ``*`` all names but
        probable misspellings
    :param takes_effect: when changes of parameters that are read once take effect
    :param rules: rules in addition to those of the class
    :raises ParameterError: if values on the server are not allowed; names all of them
    :raises MasterUnreachable: if the master does not answer

    :ivar values: the current snapshot; immutable, replaced by each change
    :ivar is_closed: whether it has stopped following the server
    """

    values: Snapshot

    def __init__(
        self,
        declaration: Type[Snapshot],
        namespace: str,
        watcher: Watcher,
        exempt: Collection[str] = (),
        takes_effect: str = AT_START,
        rules: Collection[Rule] = (),
    ) -> None:
        self.declaration = declaration
        self.namespace = namespace.rstrip("/")
        self.takes_effect = takes_effect
        self._watcher = watcher
        self._reconciler = Reconciler(declaration, exempt, rules)
        self._watched = WatchedKey(self.namespace, self._is_news, self._on_reading)
        self._lock = threading.Lock()
        self._is_open = self.is_closed = False
        #: Values that :meth:`change` has to write on opening, by name.
        self._unwritten: Dict[str, Any] = {}
        #: Replaced and never changed, since several threads iterate over it.
        self._listeners: Tuple[Listener, ...] = ()
        #: Decisions that are not logged yet, each with the values before it.
        self._unreported: List[Tuple[Snapshot, Decision]] = []
        raw = watcher.first_reading(self.namespace)
        try:
            decision = self._reconciler.start(raw, time.monotonic())
        except ParameterError as error:
            raise error.in_namespace(self.namespace) from None
        self.values = self._reconciler.values
        self._adopt(decision)
        self._report_changes()

    def update(self, **changes: Any) -> None:
        """Change values from within the node, on the server too: all or, if one is rejected, none.

        :param changes: new values by name
        :raises ParameterError: if values are not allowed; names all of them
        :raises MasterUnreachable: if the master does not answer; nothing is changed then
        """
        self.change(changes)

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change values like :meth:`update`, given as a mapping.

        :param changes: new values by name
        """
        with self._lock:
            try:
                decision = self._reconciler.validate(changes)
            except ParameterError as error:
                raise error.in_namespace(self.namespace) from None
            if self._is_open:
                self._watcher.client.write(self._resolved(decision.writes))
            else:
                self._unwritten.update(decision.writes)
            self._reconciler.adopt(decision, time.monotonic())
            self._adopt(decision)
        self._report_changes()

    def add_listener(self, listener: Listener) -> Callable[[], None]:
        """Call a function after each change, in the thread that makes the change.

        :param listener: the function; must not block: other changes wait for it
        :returns: a function that removes the listener
        :raises TypeError: if the listener is not a function, or async
        """
        check_function(listener, f"{self.namespace}: add_listener", 0)
        with self._lock:
            self._listeners += (listener,)

        def remove() -> None:
            with self._lock:
                self._listeners = tuple(other for other in self._listeners if other is not listener)

        return remove

    def close(self) -> None:
        """Stop following the server; later changes stay within the node."""
        close_all([self])

    def _is_news(self, raw: Any) -> bool:
        with self._lock:
            return self._reconciler.is_news(raw)

    def _on_reading(self, seen: Observation) -> bool:
        try:
            with self._lock:
                if not self._is_open:
                    return False  # not yet open
                decision = self._step(seen)
                if not decision.again:
                    _write([self], self._resolved(decision.writes))
                return not decision.again
        finally:
            self._report_changes()

    def _begin(self, raw: Any, read_at: float) -> Dict[str, Any]:
        """Follow the server from now on; return the values to write, by global name.

        :param raw: the namespace on the server; missing values keep their current value
        """
        if self._unwritten and (raw is MISSING or isinstance(raw, dict)):
            raw = {**(raw if raw is not MISSING else {}), **self._unwritten}
        decision = self._step(Observation(raw, forgotten=True, read_at=read_at))
        unwritten, self._unwritten = self._unwritten, {}
        self._is_open = True
        return self._resolved({**unwritten, **decision.writes})

    def _step(self, seen: Observation) -> Decision:
        decision = self._reconciler.step(seen, time.monotonic())
        self._adopt(decision)
        return decision

    def _adopt(self, decision: Decision) -> None:
        """Adopt a decision of the reconciler, and store it for the log."""
        self._unreported.append((self.values, decision))
        self.values = self._reconciler.values

    def _resolved(self, values: Mapping[str, Any]) -> Dict[str, Any]:
        """Return values by global name; an empty name is the namespace."""
        return {f"{self.namespace}/{n}".rstrip("/"): value for n, value in values.items()}

    def _report_changes(self) -> None:
        """Log decisions, and call the listeners if values have changed. Not under the lock."""
        with self._lock:
            unreported, self._unreported = self._unreported, []
        for old, decision in unreported:
            self._log(old, decision)
        if any(old != decision.values for old, decision in unreported):
            for listener in self._listeners:
                call_listener(listener, self.namespace)

    def _log(self, old: Snapshot, decision: Decision) -> None:
        before, in_force = old.as_dict(), decision.values.as_dict()
        # Changes first: an error after them names the values that stay.
        for name, value in in_force.items():
            if value != before[name]:
                texts = format_value(before[name]), format_value(value)
                late = f", takes effect {self.takes_effect}" if old.declared[name].read_once else ""
                rospy.loginfo("%s/%s: %s -> %s%s", self.namespace, name, *texts, late)
        for error in decision.errors:
            kept = {name: in_force[name] for name in error.names if name in in_force}
            result = "in force is " + _settings(kept) if kept else "all values stay in force"
            rospy.logwarn("%s; %s", error.in_namespace(self.namespace), result)
        for name, nearest in decision.unknown.items():
            hint = f"; did you mean {nearest}?" if nearest else ""
            rospy.logwarn("parameter %s/%s is not used by this node%s", self.namespace, name, hint)


def open_all(parameters: Sequence[LiveParameters[Any]]) -> None:
    """Follow changes from now on, and write missing values, in few requests.

    No change since the creation of the parameters is missed.

    :param parameters: live parameters with the same watcher
    :raises MasterUnreachable: if the master does not answer; nothing is followed then
    """
    if len(parameters) >= WRITTEN_FIRST:
        in_force = {one.namespace: one.values for one in parameters}
        write_missing(parameters[0]._watcher.client, in_force)
    try:
        for start in range(0, len(parameters), _OPENED_TOGETHER):
            _open(parameters[start : start + _OPENED_TOGETHER])
    except MasterUnreachable:
        close_all(parameters)
        raise
    for one in parameters:
        rospy.loginfo("%s: %s", one.namespace, _settings(one.values.as_dict()))
        one._report_changes()


def write_missing(client: MasterClient, in_force: Mapping[str, ParameterSet]) -> None:
    """Write the values that are missing on the server, and no others.

    :param client: client of the master
    :param in_force: values by namespace
    :raises MasterUnreachable: if the master does not answer
    """
    namespaces = list(in_force)
    for start in range(0, len(namespaces), _WRITTEN_TOGETHER):
        held = client.read(namespaces[start : start + _WRITTEN_TOGETHER]).values
        writes: Dict[str, Any] = {}
        for namespace, raw in held.items():
            tree = {} if raw is MISSING else raw
            if isinstance(tree, dict):
                for name, value in on_wire(in_force[namespace]).items():
                    if name not in tree:
                        writes[f"{namespace}/{name}"] = value
        client.write(writes)


def _open(parameters: Sequence[LiveParameters[Any]]) -> None:
    watcher = parameters[0]._watcher
    watcher.watch([one._watched for one in parameters])
    with contextlib.ExitStack() as locks:
        for one in parameters:
            locks.enter_context(one._lock)
        read_at = time.monotonic()
        held = watcher.client.read([one.namespace for one in parameters]).values
        writes = [one._begin(held[one.namespace], read_at) for one in parameters]
        _write(parameters, {key: value for each in writes for key, value in each.items()})


def close_all(parameters: Sequence[LiveParameters[Any]]) -> None:
    """Stop following the server; later changes stay within the nodes.

    :param parameters: live parameters with the same watcher, at least one
    """
    for one in parameters:
        with one._lock:
            one._is_open, one.is_closed = False, True
    parameters[0]._watcher.close(*(one._watched for one in parameters))


def _write(parameters: Sequence[LiveParameters[Any]], writes: Mapping[str, Any]) -> None:
    """Write the values of the latest steps; the caller holds their locks."""
    try:
        parameters[0]._watcher.client.write(writes)
    except BaseException:
        for one in parameters:
            one._reconciler.failed()
        raise
    for one in parameters:
        one._reconciler.written(time.monotonic())


def _settings(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={format_value(value)}" for name, value in values.items())
