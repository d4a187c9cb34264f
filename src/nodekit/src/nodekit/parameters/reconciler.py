"""Reconciler: decides which server values a node adopts, and which values it writes back.

Users write valid values, invalid values, and parts of a consistent set. The server has no
compare-and-set: a write that resets an invalid value may overwrite a newer, valid value, which only
a notification reveals. :class:`Reconciler` gets the read and the notified values, and returns the
current values, the values to write and the errors to report. It has no access to the server or a
clock: its owner reads, writes and locks.
"""

import math
from typing import (
    Any,
    Collection,
    Dict,
    Generic,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
    Type,
)

from nodekit.parameters.declaration import ParameterSet, Rule, Snapshot
from nodekit.parameters.errors import RuleError, raise_all
from nodekit.parameters.parameter_types import MISSING, UNREADABLE, NoValue, ParameterError, is_same
from nodekit.parameters.validation import (
    apply_rules,
    corrections,
    last_valid,
    leaf_names,
    on_wire,
    unknown_name_errors,
    unknown_names,
    validate_each,
)

#: Time until inconsistent values are rejected [s]: on a busy machine "rosparam load" may pause
#: between two leaves.
HALF_DONE_S = 0.2
#: Time after a write in which a notification of an overwritten value may arrive [s].
OVERLAP_S = 5.0
#: Most writes of one parameter in a burst.
BURST = 20
#: Time until another write is allowed [s].
REFILL_S = 1.0
_UNKNOWN = NoValue("UNKNOWN")


class TokenBucket:
    """Token bucket for each name.

    It slows down two programs that correct each other in an endless loop.
    """

    def __init__(self) -> None:
        #: Remaining tokens by name, and their time [s].
        self._left: Dict[str, Tuple[float, float]] = {}

    def allow(self, name: str, now: float) -> bool:
        """Return whether a write is allowed now, and count it.

        :param name: name of the parameter
        :param now: the time [s]
        """
        left, since = self._left.get(name, (float(BURST), now))
        left = min(float(BURST), left + (now - since) / REFILL_S)
        allowed = left >= 1.0
        self._left[name] = (left - 1.0 if allowed else left, now)
        return allowed


class Observation(NamedTuple):
    """Observed state of a namespace on the server.

    :param raw: the namespace on the server, MISSING if it is not set
    :param pushed: notifications since the last completed step, oldest first: name
        below the namespace, empty for the namespace itself, and raw value or MISSING
    :param forgotten: whether the master was restarted and has lost its values
    :param read_at: start of the read on the monotonic clock [s]
    """

    raw: Any
    pushed: Sequence[Tuple[str, Any]] = ()
    forgotten: bool = False
    read_at: float = math.inf


class Decision(NamedTuple):
    """Result of a step of the reconciler: the values to adopt, to write, and to report.

    :param values: new current values
    :param writes: values to write now by name; an empty name replaces the whole namespace
    :param errors: errors to report, without those reported before
    :param unknown: unreported undeclared names, each with the nearest known name or None
    :param again: whether the step is undecided: read again soon, and pass the same notifications
    """

    values: ParameterSet
    writes: Dict[str, Any]
    errors: List[ParameterError]
    unknown: Dict[str, Optional[str]]
    again: bool = False


class Reconciler(Generic[Snapshot]):
    """State machine that keeps declared values and the server consistent; pure.

    Each decision of :meth:`start` and :meth:`step` is written, and then
    :meth:`written` or :meth:`failed` is called, before the next step.

    :param declaration: the class that declares the parameters
    :param exempt: names in the namespace that are used but not declared; with ``*`` all names but
        probable misspellings
    :param rules: rules in addition to those of the class

    :ivar values: the current snapshot
    """

    values: Snapshot

    def __init__(
        self,
        declaration: Type[Snapshot],
        exempt: Collection[str] = (),
        rules: Collection[Rule] = (),
    ) -> None:
        self.values = declaration.as_declared()
        self._exempt, self._rules = exempt, rules
        self._bucket = TokenBucket()
        #: Expected values on the server that differ from the current ones.
        self._odd: Dict[str, Any] = dict.fromkeys(declaration.declared, _UNKNOWN)
        #: Time of the last write [s]: older reads are outdated.
        self._last_write = -math.inf
        #: Recent writes with name and time [s]; each may have overwritten a newer value, with the
        #: notification still under way.
        self._own: List[Tuple[str, Any, float]] = []
        #: Time since which values on the server are inconsistent [s]; None if they are consistent.
        self._broken_since: Optional[float] = None
        #: Reported errors, until the values are reset, and reported unknown names; () for none.
        self._reported_errors: Collection[str] = ()
        self._reported_unknown: Collection[str] = ()

    def is_news(self, raw: Any) -> bool:
        """Return whether the server differs from the expected values.

        :param raw: the namespace on the server, MISSING if it is not set
        """
        return not is_same({} if raw is MISSING else raw, {**on_wire(self.values), **self._odd})

    def start(self, raw: Any, now: float) -> Decision:
        """Adopt the values at the start, or reject all of them.

        :param raw: the namespace on the server, MISSING if it is not set
        :param now: the time on the monotonic clock [s]
        :raises ParameterError: if values are invalid; names all of them
        """
        # As after a restart: the server has no values of this node.
        seen = Observation(raw, forgotten=True)
        values, errors = self._validate(seen, now)
        raise_all(errors)
        broken = values.broken_rule(values.declared, self._rules)  # the defaults may break one
        raise_all([broken] if broken is not None else [])
        return self._decide(seen, values, [], now)

    def step(self, seen: Observation, now: float) -> Decision:
        """Validate the values on the server, and adopt the valid ones.

        :param seen: observed state of the namespace
        :param now: the time on the monotonic clock [s]
        """
        if seen.read_at >= self._last_write:
            values, errors = self._validate(seen, now)
            if not self._may_be_half_done(errors, now):
                return self._decide(seen, values, errors, now)
        self.failed()  # the next read counts as a change
        return Decision(self.values, {}, [], {}, again=True)

    def validate(self, changes: Mapping[str, Any]) -> Decision:
        """Validate a change from within the node, without adopting it.

        :param changes: new values by name
        :raises ParameterError: if values are invalid; names all of them
        """
        coerced, errors = validate_each(self.values, changes, missing=self.values.as_dict())
        values, broken = apply_rules(self.values, coerced, self._rules)
        raise_all([*unknown_name_errors(self.values.declared, changes), *errors, *broken])
        wire = on_wire(values)
        # Unchanged values too: other programs may have set values that are not read yet.
        return Decision(values, {name: wire[name] for name in changes}, [], {})

    def adopt(self, decision: Decision, now: float) -> None:
        """Adopt a validated change that has been written.

        It is newer than pending notifications, which must not revert it.

        :param decision: result of :meth:`validate`
        :param now: the time on the monotonic clock [s]
        """
        self.values = decision.values  # type: ignore[assignment]
        self._odd = {n: value for n, value in self._odd.items() if n not in decision.writes}
        self._own = [own for own in self._own if own[0] not in decision.writes]
        self._last_write = now

    def written(self, now: float) -> None:
        """Confirm the writes of the latest start or step.

        :param now: the time on the monotonic clock [s]
        """
        self._last_write = now
        self._broken_since = None
        if all(value is not _UNKNOWN for value in self._odd.values()):  # all values are reset
            self._reported_errors = ()

    def failed(self) -> None:
        """Mark the values on the server as unknown, after failed writes."""
        self._odd.update(dict.fromkeys(self.values.declared, _UNKNOWN))

    def _tree(self, raw: Any) -> Dict[str, Any]:
        """Return the namespace by name; any other value is an invalid value of each parameter."""
        if _is_namespace(raw):
            return raw if raw is not MISSING else {}
        return {**self._odd, **dict.fromkeys(self.values.declared, UNREADABLE)}

    def _validate(self, seen: Observation, now: float) -> Tuple[Snapshot, List[ParameterError]]:
        """Return the values to adopt, and the errors."""
        tree = self._tree(seen.raw)
        defaults = {name: item.default for name, item in self.values.declared.items()}
        missing = self.values.as_dict() if seen.forgotten else defaults
        coerced, errors = validate_each(self.values, tree, missing)
        bad = {error.name for error in errors}
        coerced.update(last_valid(self.values, bad | self._still_own(tree, now), seen.pushed))
        if not _is_namespace(seen.raw):
            errors = [ParameterError("", seen.raw, "a namespace with the node's parameters")]
        values, broken = apply_rules(self.values, coerced, self._rules)
        return values, [*errors, *broken]

    def _still_own(self, tree: Mapping[str, Any], now: float) -> Set[str]:
        """Return the parameters whose value was written recently by a step."""
        self._own = [
            (name, value, at)
            for name, value, at in self._own
            if is_same(tree.get(name), value) and now - at < OVERLAP_S
        ]
        return {name for name, _, _ in self._own}

    def _may_be_half_done(self, errors: Sequence[ParameterError], now: float) -> bool:
        """Return whether inconsistent values may be part of an incomplete change."""
        if not any(isinstance(error, RuleError) for error in errors):
            self._broken_since = None
        elif self._broken_since is None:
            self._broken_since = now
        return self._broken_since is not None and now - self._broken_since < HALF_DONE_S

    def _decide(
        self, seen: Observation, values: Snapshot, errors: Sequence[ParameterError], now: float
    ) -> Decision:
        """Adopt values; return the values to write, and the errors to report."""
        tree = self._tree(seen.raw)
        wire, wanted = on_wire(values), corrections(values, tree)
        self.values, held = values, {**tree, **wanted}
        self._odd = {n: v for n, v in held.items() if not is_same(v, wire.get(n, MISSING))}
        if not _is_namespace(seen.raw):
            wanted = {"": {n: value for n, value in held.items() if value is not UNREADABLE}}
        writes = {n: v for n, v in wanted.items() if seen.forgotten or self._bucket.allow(n, now)}
        for name in wanted:
            names = [name] if name else list(values.declared)
            if name in writes:
                self._own += [(each, held[each], now) for each in names]
            else:
                self._odd.update(dict.fromkeys(names, _UNKNOWN))
        reported, self._reported_errors = self._reported_errors, tuple(map(str, errors))
        names = [name for name in leaf_names(tree) if name not in self._reported_unknown]
        unknown = unknown_names(values.declared, names, self._exempt)
        self._reported_unknown = {*self._reported_unknown, *unknown} or ()
        return Decision(values, writes, [e for e in errors if str(e) not in reported], unknown)


def _is_namespace(raw: Any) -> bool:
    return raw is MISSING or isinstance(raw, dict)
