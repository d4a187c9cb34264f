"""Decide what becomes of values on a parameter server that everybody writes to.

Users write good values, bad ones and half of what belongs together; the server
has no compare-and-set, so that a write that puts a bad value back may hit a
newer, good one, of which only the notifications tell. :class:`Reconciler` is
told what was read and what was notified, and answers with what is in force,
what has to be written and what has to be warned of. It knows neither the server
nor a clock: whoever owns it reads, writes and locks.
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
    leaves,
    on_wire,
    unknown_name_errors,
    unknown_names,
    validate_each,
)

#: How long values that do not go together may stand before they are refused, s:
#: on a busy machine "rosparam load" may pause between one leaf and the next.
HALF_DONE_S = 0.2
#: How long after a write a notification may still tell of a value that the
#: write has replaced, s.
OVERLAP_S = 5.0
#: Writes of one parameter that may follow each other at once.
BURST = 20
#: Time after which one more of them may follow, s.
REFILL_S = 1.0
_UNKNOWN = NoValue("UNKNOWN")


class TokenBucket:
    """A token bucket for each name.

    Two programs that correct each other must not do so in an endless quick loop.
    """

    def __init__(self) -> None:
        #: What was left for a name, and when, s.
        self._left: Dict[str, Tuple[float, float]] = {}

    def allow(self, name: str, now: float) -> bool:
        """Tell whether it may be done now, which is counted then, or only later.

        :param name: what it is done to
        :param now: the time, s
        """
        left, since = self._left.get(name, (float(BURST), now))
        left = min(float(BURST), left + (now - since) / REFILL_S)
        allowed = left >= 1.0
        self._left[name] = (left - 1.0 if allowed else left, now)
        return allowed


class Observation(NamedTuple):
    """What was seen of a namespace on the server.

    :param raw: the namespace as the server holds it, MISSING where nothing is set
    :param pushed: notified since the last step that was done, oldest first: name
        below the namespace, empty for the namespace itself, and raw value or MISSING
    :param forgotten: the master was restarted and lost what it held
    :param read_at: start of the read, s on the monotonic clock
    """

    raw: Any
    pushed: Sequence[Tuple[str, Any]] = ()
    forgotten: bool = False
    read_at: float = math.inf


class Decision(NamedTuple):
    """What a step has come to.

    :param values: in force from now on
    :param writes: by name, what to write now; an empty name means to replace the
        whole namespace
    :param errors: what to warn of, without what was warned of before
    :param unknown: undeclared names that nobody was told of, each with the nearest known or None
    :param again: nothing is decided yet: read again soon and hand over the same
        notifications once more
    """

    values: ParameterSet
    writes: Dict[str, Any]
    errors: List[ParameterError]
    unknown: Dict[str, Optional[str]]
    again: bool = False


class Reconciler(Generic[Snapshot]):
    """Keeps declared values and those on the server in step; pure.

    Each decision of :meth:`start` and :meth:`step` is written, and then
    :meth:`written` or :meth:`failed` is called, before the next step.

    :param declaration: the class that declares the parameters
    :param exempt: names in the namespace that are used but not declared
    :param rules: rules beside those of the class

    :ivar values: the snapshot in force
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
        self._budget = TokenBucket()
        #: What the server is to hold beside what is in force, or in its place; all else is news.
        self._odd: Dict[str, Any] = dict.fromkeys(declaration.declared, _UNKNOWN)
        #: When the server was last written to, s: what was read before says nothing of now.
        self._last_write = -math.inf
        #: What steps have written and may still stand, each with its name and time, s: it
        #: may have replaced a newer value, of which a notification is on its way.
        self._own: List[Tuple[str, Any, float]] = []
        #: Since when values on the server do not go together, s; None if they do.
        self._broken_since: Optional[float] = None
        #: What was warned of, () if nothing: refused values until they are put back, unknown names.
        self._reported_errors: Collection[str] = ()
        self._reported_unknown: Collection[str] = ()

    def is_news(self, raw: Any) -> bool:
        """Tell whether the server holds something else than it is to hold.

        :param raw: the namespace as the server holds it, MISSING where nothing is set
        """
        return not is_same({} if raw is MISSING else raw, {**on_wire(self.values), **self._odd})

    def start(self, raw: Any, now: float) -> Decision:
        """Bring the values at the start into force, or refuse them all.

        :param raw: the namespace as the server holds it, MISSING where nothing is set
        :param now: the time, s on the monotonic clock
        :raises ParameterError: names all that is refused; nothing is in force then
        """
        seen = Observation(
            raw, forgotten=True
        )  # as after a restart: the server holds nothing of ours
        values, errors = self._validate(seen, now)
        raise_all(errors)
        broken = values.broken_rule(values.declared, self._rules)  # the defaults may break one
        raise_all([broken] if broken is not None else [])
        return self._decide(seen, values, [], now)

    def step(self, seen: Observation, now: float) -> Decision:
        """Judge what the server holds now, and adopt what is good.

        :param seen: what was seen of the namespace
        :param now: the time, s on the monotonic clock
        """
        if seen.read_at >= self._last_write:
            values, errors = self._validate(seen, now)
            if not self._may_be_half_done(errors, now):
                return self._decide(seen, values, errors, now)
        self.failed()  # to be asked again, whatever is read
        return Decision(self.values, {}, [], {}, again=True)

    def validate(self, changes: Mapping[str, Any]) -> Decision:
        """Judge a change from within the node; nothing is adopted yet.

        :param changes: new values by name
        :raises ParameterError: names all that is refused
        """
        coerced, refused = validate_each(self.values, changes, missing=self.values.as_dict())
        values, broken = apply_rules(self.values, coerced, self._rules)
        raise_all([*unknown_name_errors(self.values.declared, changes), *refused, *broken])
        wire = on_wire(values)
        # Also what is in force already: others may have set something else that is not read yet.
        return Decision(values, {name: wire[name] for name in changes}, [], {})

    def adopt(self, decision: Decision, now: float) -> None:
        """Bring a judged change into force: it has been written.

        It is newer than what is on its way: no notification may take it back.

        :param decision: what :meth:`validate` returned
        :param now: the time, s on the monotonic clock
        """
        self.values = decision.values  # type: ignore[assignment]
        self._odd = {n: value for n, value in self._odd.items() if n not in decision.writes}
        self._own = [own for own in self._own if own[0] not in decision.writes]
        self._last_write = now

    def written(self, now: float) -> None:
        """Note that the writes of the latest start or step have reached the server.

        :param now: the time, s on the monotonic clock
        """
        self._last_write = now
        self._broken_since = None
        if all(value is not _UNKNOWN for value in self._odd.values()):  # all is put back
            self._reported_errors = ()

    def failed(self) -> None:
        """Note that they may not have reached it: what it holds is not known."""
        self._odd.update(dict.fromkeys(self.values.declared, _UNKNOWN))

    def _tree(self, raw: Any) -> Dict[str, Any]:
        """Return the namespace by name; what stands in its place is a bad value for each."""
        if _is_namespace(raw):
            return raw if raw is not MISSING else {}
        return {**self._odd, **dict.fromkeys(self.values.declared, UNREADABLE)}

    def _validate(self, seen: Observation, now: float) -> Tuple[Snapshot, List[ParameterError]]:
        """Return which values are to come into force, and what is refused."""
        tree = self._tree(seen.raw)
        defaults = {name: item.default for name, item in self.values.declared.items()}
        missing = self.values.as_dict() if seen.forgotten else defaults
        coerced, refused = validate_each(self.values, tree, missing)
        bad = {error.name for error in refused}
        coerced.update(last_valid(self.values, bad | self._still_own(tree, now), seen.pushed))
        if not _is_namespace(seen.raw):
            refused = [ParameterError("", seen.raw, "a namespace with the node's parameters")]
        values, broken = apply_rules(self.values, coerced, self._rules)
        return values, [*refused, *broken]

    def _still_own(self, tree: Mapping[str, Any], now: float) -> Set[str]:
        """Return the parameters whose value is one that a step has written lately."""
        self._own = [
            (name, value, at)
            for name, value, at in self._own
            if is_same(tree.get(name), value) and now - at < OVERLAP_S
        ]
        return {name for name, _, _ in self._own}

    def _may_be_half_done(self, errors: Sequence[ParameterError], now: float) -> bool:
        """Tell whether values that do not go together may yet be followed by others that do."""
        if not any(isinstance(error, RuleError) for error in errors):
            self._broken_since = None
        elif self._broken_since is None:
            self._broken_since = now
        return self._broken_since is not None and now - self._broken_since < HALF_DONE_S

    def _decide(
        self, seen: Observation, values: Snapshot, errors: Sequence[ParameterError], now: float
    ) -> Decision:
        """Adopt values; return what to write now, and what to tell of."""
        tree = self._tree(seen.raw)
        wire, wanted = on_wire(values), corrections(values, tree)
        self.values, held = values, {**tree, **wanted}
        self._odd = {n: v for n, v in held.items() if not is_same(v, wire.get(n, MISSING))}
        if not _is_namespace(seen.raw):
            wanted = {"": {n: value for n, value in held.items() if value is not UNREADABLE}}
        writes = {n: v for n, v in wanted.items() if seen.forgotten or self._budget.allow(n, now)}
        for name in wanted:
            names = [name] if name else list(values.declared)
            if name in writes:
                self._own += [(each, held[each], now) for each in names]
            else:
                self._odd.update(dict.fromkeys(names, _UNKNOWN))
        told, self._reported_errors = self._reported_errors, tuple(map(str, errors))
        names = [name for name in leaves(tree) if name not in self._reported_unknown]
        unknown = unknown_names(values.declared, names, self._exempt)
        self._reported_unknown = {*self._reported_unknown, *unknown} or ()
        return Decision(values, writes, [e for e in errors if str(e) not in told], unknown)


def _is_namespace(raw: Any) -> bool:
    return raw is MISSING or isinstance(raw, dict)
