"""Tests of the reconciliation of a namespace that several programs write to."""

from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.parameters.declaration import (
    FloatParameter,
    ListParameter,
    ParameterError,
    ParameterErrors,
    ParameterSet,
    StringParameter,
    rule,
)
from nodekit.parameters.errors import RuleError
from nodekit.parameters.parameter_types import MISSING, UNREADABLE
from nodekit.parameters.reconciler import (
    BURST,
    HALF_DONE_S,
    OVERLAP_S,
    REFILL_S,
    Decision,
    Observation,
    Reconciler,
    TokenBucket,
)
from nodekit.parameters.validation import corrections, on_wire


class Gauge(ParameterSet):
    """Two parameters that go with anything, and two that go with each other."""

    level = FloatParameter(1.0, minimum=0.0, help="a level")
    title = StringParameter("gauge", help="a title")
    low = FloatParameter(0.0, help="lower limit")
    high = FloatParameter(9.0, help="upper limit")

    @rule("low", "high")
    def ordered(self) -> None:
        """Keep the limits in order."""
        if self.low > self.high:
            raise ValueError("low must be at most high")


IN_FORCE = Gauge(level=2.0, title="old")
HELD = on_wire(IN_FORCE)
LATE = -1.0


class Seeing(NamedTuple):
    """Changes since the last step, and the expected result.

    :param sets: set on the server by name; MISSING deletes, an empty name replaces all
    :param pushed: notifications
    :param pause: time since the last step, s
    :param forgotten: the master was restarted
    :param fails: whether writes fail
    :param early: the server was read before the last write
    :param values: values in force that differ from IN_FORCE
    :param writes: written values
    :param refused: names in the warnings
    :param unknown: the names that are warned of
    :param again: whether the step is undecided
    :param news: whether the server is worth a step at all
    """

    sets: Dict[str, Any] = {}
    pushed: Sequence[Tuple[str, Any]] = ()
    pause: float = 0.1
    forgotten: bool = False
    fails: bool = False
    early: bool = False
    values: Dict[str, Any] = {}
    writes: Dict[str, Any] = {}
    refused: Sequence[str] = ()
    unknown: Dict[str, Any] = {}
    again: bool = False
    news: bool = True


class Update(NamedTuple):
    """A change from within the node, between two steps."""

    changes: Dict[str, Any]


def bad(value: Any, **more: Any) -> Seeing:
    """Set a bad level, which is put back."""
    row = Seeing({"level": value}, [("level", value)], writes={"level": 2.0}, refused=["level"])
    return row._replace(**more)


def pushed_late(*values: Any, **more: Any) -> Seeing:
    """Be notified of levels that a write has replaced already."""
    return Seeing({}, [("level", value) for value in values], news=False)._replace(**more)


FIVE: Dict[str, Any] = {"values": {"level": 5.0}, "writes": {"level": 5.0}}
BROKEN = {"low": 20.0}

TABLE: Dict[str, List[Any]] = {
    "nothing new": [Seeing(news=False), Seeing(news=False)],
    "good value": [Seeing({"level": 5}, [("level", 5)], values={"level": 5.0})],
    "good value without a notification": [Seeing({"level": 5}, values={"level": 5.0})],
    "text for a number is replaced by the number": [Seeing({"level": "5"}, **FIVE)],
    "deleted value": [
        Seeing({"level": MISSING}, values={"level": 1.0}, writes={"level": 1.0}),
        Seeing(news=False, values={"level": 1.0}),
    ],
    "deleted namespace": [Seeing({"": MISSING}, values=Gauge().as_dict(), writes=on_wire(Gauge()))],
    "bad value is put back": [bad(-1), Seeing(news=False)],
    "same bad value once more is refused once more": [bad(-1), bad(-1), bad(-1)],
    "same bad value without a notification": [bad(-1, pushed=()), bad(-1, pushed=())],
    "value that the master cannot send": [bad(UNREADABLE, pushed=())],
    "what was replaced by other users is history": [
        Seeing({"level": 5}, [("level", 3), ("level", 4), ("level", 5)], values={"level": 5.0}),
        Seeing({"level": 6}, values={"level": 6.0}),
        pushed_late(7, 6, values={"level": 6.0}),
    ],
    "last good value before a bad one wins": [
        bad(-1, pushed=[("level", 4), ("level", 5), ("level", -2), ("level", -1)], **FIVE),
        Seeing(news=False, values={"level": 5.0}),
    ],
    "good value that is hit by a put-back wins": [bad(-1), pushed_late(5, **FIVE)],
    "of what is hit by a put-back the last good one wins": [
        bad(-1),
        pushed_late(4, "5", -3, **FIVE),
    ],
    "good value that is hit by two put-backs wins": [
        bad(-1),
        pushed_late(4, values={"level": 4.0}, writes={"level": 4.0}),
        pushed_late(5, **FIVE),
    ],
    "deletion that is hit by a put-back wins": [
        bad(-1),
        pushed_late(MISSING, values={"level": 1.0}, writes={"level": 1.0}),
    ],
    "deletion of the namespace that is hit by a put-back wins": [
        bad(-1),
        Seeing(
            {"": {"level": 2.0}},
            [("", MISSING)],
            values=Gauge().as_dict(),
            writes=on_wire(Gauge()),
        ),
    ],
    "namespace that is replaced before a put-back": [
        bad(-1),
        Seeing(
            {"": {"level": 2.0, "title": "new"}},
            [("", {"title": "new"})],
            values={"level": 1.0, "title": "new"},
            writes={"level": 1.0, "low": 0.0, "high": 9.0},
        ),
    ],
    "scalar over the namespace is replaced by the namespace": [
        Seeing({"other": 5}, unknown={"other": None}),
        Seeing({"": 7}, [("", 7)], writes={"": {**HELD, "other": 5}}, refused=[""]),
        Seeing(news=False),
        Seeing({"": 7}, [("", 7)], writes={"": {**HELD, "other": 5}}, refused=[""]),
    ],
    "good value before a scalar over the namespace wins": [
        Seeing(
            {"": 7},
            [("level", 5), ("", 7)],
            values={"level": 5.0},
            writes={"": {**HELD, "level": 5.0}},
            refused=[""],
        ),
    ],
    "good value that is hit by the namespace that is put back wins": [
        Seeing({"": 7}, [("", 7)], writes={"": HELD}, refused=[""]),
        pushed_late(5, **FIVE),
    ],
    "scalar that is replaced during a put-back": [
        bad(-1),
        Seeing({"": {"level": 2.0}}, [("", 7)])._replace(
            values={"title": "gauge"}, writes={"title": "gauge", "low": 0.0, "high": 9.0}
        ),
    ],
    "what cannot be sent is not written back": [
        Seeing({"other": UNREADABLE}, unknown={"other": None}),
        Seeing({"": 7}, writes={"": HELD}, refused=[""]),
    ],
    "bad value that is hit by a put-back changes nothing": [bad(-1), pushed_late("x")],
    "own write that was replaced has hit nothing": [
        bad(-1),
        Seeing({"level": 7.0}, [("level", 5.0), ("level", 7.0)], values={"level": 7.0}),
        # A user sets the same value that was written before.
        Seeing({"level": 2.0}, [("level", 2.0)]),
        pushed_late(5.0),
    ],
    "own write is told from an equal value of another kind": [
        bad(-1),
        Seeing({"level": 2}, [("level", 5.0), ("level", 2)]),
    ],
    "notification of old times is no news": [bad(-1), pushed_late(5.0, pause=OVERLAP_S)],
    "notification of nearly old times is news": [
        bad(-1),
        pushed_late(5.0, pause=OVERLAP_S - 0.1, **FIVE),
    ],
    "each parameter is validated individually": [
        Seeing({"title": 7}, [("title", 7)], writes={"title": "old"}, refused=["title"]),
        Seeing(
            {"level": 3.0},
            [("level", 9.0), ("title", "new"), ("other", 2), ("level", 3.0), ("title", 8)],
            values={"level": 3.0, "title": "new"},
            writes={"title": "new"},
        ),
    ],
    "update is not taken back by a notification": [
        bad(-1),
        Update({"level": 4.0}),
        pushed_late(5.0, values={"level": 4.0}),
    ],
    "update to what a put-back has written is not taken back by a notification": [
        bad(-1),
        Update({"level": 4.0}),
        Update({"level": 2.0}),
        pushed_late(5.0),
    ],
    "update is not taken back by what was read before it": [
        Seeing({"level": 5.0}, values={"level": 5.0}),
        Update({"title": "new"}),
        Seeing(
            {"title": "old"},
            early=True,
            again=True,
            values={"level": 5.0, "title": "new"},
        ),
        Seeing({"title": "new"}, values={"level": 5.0, "title": "new"}),
        Seeing(news=False, values={"level": 5.0, "title": "new"}),
    ],
    "what was read before a put-back says nothing": [
        bad(-1),
        Seeing({"level": -1}, early=True, again=True),
        bad(-1),
    ],
    "values that do not go together are given time": [
        Seeing(BROKEN, [("low", 20.0)], again=True),
        Seeing(again=True, pause=HALF_DONE_S / 2),
        Seeing({"high": 30.0}, pause=HALF_DONE_S, values={"low": 20.0, "high": 30.0}),
        Seeing(news=False, values={"low": 20.0, "high": 30.0}),
    ],
    "values that do not go together are refused in the end": [
        Seeing({**BROKEN, "level": 5.0}, again=True),
        Seeing(
            pause=HALF_DONE_S,
            values={"level": 5.0},
            writes={"low": 0.0},
            refused=["low, high"],
        ),
        Seeing(news=False, values={"level": 5.0}),
        # And the next ones are given time again.
        Seeing(BROKEN, again=True, values={"level": 5.0}),
    ],
    "time starts again after values were consistent": [
        Seeing(BROKEN, again=True),
        Seeing({"low": 0.0}, pause=HALF_DONE_S),
        Seeing(BROKEN, again=True),
    ],
    "put-back that fails is done later and warned of once": [
        bad(-1, pushed=[("level", 5), ("level", -1)], fails=True, **FIVE),
        Seeing({}, [("level", 5), ("level", -1)], **FIVE),
        Seeing(news=False, values={"level": 5.0}),
    ],
    "put-back that fails although it has arrived": [
        bad(-1, fails=True),
        Seeing({"level": 2.0}, [("level", -1), ("level", 5)], **FIVE),
    ],
    "good value that is hit by a put-back wins though it cannot be written at first": [
        bad(-1),
        pushed_late(5, fails=True, **FIVE),
        pushed_late(5, news=True, **FIVE),
    ],
    "what a restarted master lost is kept and written": [
        Seeing({"": MISSING}, forgotten=True, writes=HELD),
        Seeing(news=False),
    ],
    "what is set on a restarted master comes into force": [
        Seeing(
            {"": {"high": 7.0}},
            forgotten=True,
            values={"high": 7.0},
            writes={"level": 2.0, "title": "old", "low": 0.0},
        ),
    ],
    "values are kept though writing them to a new master fails at first": [
        Seeing({"": MISSING}, forgotten=True, fails=True, writes=HELD),
        Seeing(forgotten=True, writes=HELD),
    ],
    "namespace of another node below this one's name is no misspelt parameter": [
        Seeing({"levels": {"level": 1.0}, "deep": {}}),
        Seeing({"levels": 1.0}, unknown={"levels": "level"}),
    ],
    "unknown names are warned of once, those that are exempt never": [
        Seeing({"levle": 1, "Message": 2}, unknown={"levle": "level"}),
        Seeing({"levle": MISSING}),
        Seeing({"levle": 1}),
    ],
    "writer that insists is answered only now and then": [
        *[bad(-1, pause=0.0)] * BURST,
        Seeing({"level": -1}, pause=0.0, refused=["level"]),
        Seeing({"title": "through"}, pause=0.0, values={"title": "through"}),
        Seeing(pause=REFILL_S, writes={"level": 2.0}, values={"title": "through"}),
        Seeing(news=False, values={"title": "through"}),
    ],
    "what a restarted master lost is written at once": [
        *[bad(-1, pause=0.0)] * BURST,
        Seeing({"": MISSING}, pause=0.0, forgotten=True, writes=HELD),
    ],
    "scalar over the namespace is put back only now and then": [
        *[Seeing({"": 7}, pause=0.0, writes={"": HELD}, refused=[""])] * BURST,
        Seeing({"": 7}, pause=0.0, refused=[""]),
        Seeing(pause=REFILL_S, writes={"": HELD}),
    ],
}


def set_on(server: Any, changes: Dict[str, Any]) -> Any:
    """Return the server's content after changes, MISSING if empty."""
    for name, value in changes.items():
        if not name:
            server = dict(value) if isinstance(value, dict) else value
            continue
        server = dict(server) if isinstance(server, dict) else {}
        server[name] = value
        if value is MISSING:
            del server[name]
    return MISSING if server == {} else server


@pytest.mark.parametrize("name", TABLE)
def test_step_by_step(name: str) -> None:
    reconciler, server, now = Reconciler(Gauge, exempt=["Message"]), HELD, 100.0
    assert reconciler.start(server, now).values == IN_FORCE
    for number, row in enumerate(TABLE[name]):
        where = f"step {number + 1}: {row}"
        if isinstance(row, Update):
            decision = reconciler.validate(row.changes)
            server = set_on(server, decision.writes)
            reconciler.adopt(decision, now)
            continue
        now += row.pause
        server = set_on(server, row.sets)
        assert reconciler.is_news(server) == row.news, where
        if not (row.news or row.pushed):
            assert reconciler.values == IN_FORCE.replace(**row.values), where
            continue
        read_at = LATE if row.early else now
        decision = reconciler.step(Observation(server, row.pushed, row.forgotten, read_at), now)
        assert decision.values == reconciler.values == IN_FORCE.replace(**row.values), where
        assert decision.writes == row.writes, where
        assert [error.name for error in decision.errors] == list(row.refused), where
        assert (decision.unknown, decision.again) == (row.unknown, row.again), where
        if row.fails:
            reconciler.failed()
        elif decision.writes:
            server = set_on(server, decision.writes)
            reconciler.written(now)


def test_start_writes_all_unset_values_together() -> None:
    reconciler = Reconciler(Gauge)
    assert reconciler.is_news(MISSING)
    decision = reconciler.start({"level": "5", "other": 1}, 0.0)
    assert decision == Decision(
        Gauge(level=5.0),
        {"level": 5.0, "title": "gauge", "low": 0.0, "high": 9.0},
        [],
        {"other": None},
    )
    assert reconciler.is_news({"level": "5", "other": 1})
    reconciler.written(0.0)
    assert not reconciler.is_news({**on_wire(Gauge(level=5.0)), "other": 1})
    # A value that arrived when the defaults were written takes precedence.
    late = reconciler.step(
        Observation({**on_wire(Gauge(level=5.0)), "other": 1}, [("level", 7)]), 0.1
    )
    assert (late.values.level, late.writes, late.unknown) == (7.0, {"level": 7.0}, {})


def test_nodes_with_equal_values_share_the_copy() -> None:
    first, second = Reconciler(Gauge), Reconciler(Gauge)
    for reconciler in (first, second):
        reconciler.start({"level": 1}, 0.0)
        reconciler.written(0.0)
        reconciler.step(Observation(on_wire(Gauge()), forgotten=True), 0.1)
        assert not reconciler.is_news(on_wire(Gauge()))
    assert first.values is second.values is Gauge.as_declared()
    assert not first._odd  # the server has the values in force


@rule("level")
def above_one(values: Gauge) -> None:
    """Define a further rule, which the defaults break."""
    if values.level <= 1.0:
        raise ValueError("must be above 1")


@pytest.mark.parametrize("raw", [MISSING, {}, {"level": 1.0}, {"low": 1.0}])
def test_start_refuses_values_that_break_a_rule(raw: Any) -> None:
    with pytest.raises(RuleError) as caught:
        Reconciler(Gauge, rules=[above_one]).start(raw, 0.0)
    assert str(caught.value) == "parameter level: refused 1: must be above 1"


def test_rule_of_node_is_checked_at_each_change() -> None:
    reconciler = Reconciler(Gauge, rules=[above_one])
    assert reconciler.start({"level": 5.0}, 0.0).values.level == 5.0
    reconciler.written(0.0)
    with pytest.raises(RuleError, match="level: refused 0.5: must be above 1"):
        reconciler.validate({"level": 0.5})
    for raw in ({**on_wire(Gauge(level=0.5))}, {}):  # set, and deleted, which is the default
        seen = Observation(raw, [("", raw)])
        assert reconciler.step(seen, 1.0).again
        refused = reconciler.step(seen, 2.0)
        assert refused.values.level == refused.writes["level"] == 5.0
        assert [error.names for error in refused.errors] == [("level",)]
        reconciler.written(2.0)


def test_start_reports_all_refused_values_together() -> None:
    with pytest.raises(ParameterErrors) as several:
        Reconciler(Gauge).start({"level": -1, "title": 5, "low": 10.0, "high": 5}, 0.0)
    assert several.value.names == ("level", "title", "low", "high")
    assert [type(error).__name__ for error in several.value.errors] == [
        "ParameterError",
        "ParameterError",
        "RuleError",
    ]
    assert str(several.value.in_namespace("/n")) == (
        "parameter /n/level: refused -1: must be a number in [0, inf); "
        "parameter /n/title: refused 5: must be text without control characters "
        "(quote it if YAML would read something else); "
        "parameters /n/low, /n/high: refused 10, 5: low must be at most high"
    )


@pytest.mark.parametrize(
    "raw, text",
    [
        ({"level": -1}, "parameter /n/level: refused -1: must be a number in [0, inf)"),
        # The rule is broken only because the high of 5 cannot be taken.
        ({"low": 12, "high": "x"}, "parameter /n/high: refused 'x': must be a number"),
        (7, "parameter /n: refused 7: must be a namespace with the node's parameters"),
    ],
)
def test_single_refused_value_raises_its_own_error(raw: Any, text: str) -> None:
    with pytest.raises(ParameterError) as caught:
        Reconciler(Gauge).start(raw, 0.0)
    assert not isinstance(caught.value, ParameterErrors)
    assert str(caught.value.in_namespace("/n")) == text


def test_validated_change_is_adopted_only_on_request() -> None:
    reconciler = Reconciler(Gauge)
    reconciler.start(HELD, 0.0)
    decision = reconciler.validate({"level": "5", "title": "old"})
    # Unchanged values too: the server may have another title, which is not read yet.
    writes = {"level": 5.0, "title": "old"}
    assert decision == Decision(IN_FORCE.replace(level=5.0), writes, [], {})
    assert reconciler.values == IN_FORCE
    reconciler.adopt(decision, 1.0)
    assert reconciler.values.level == 5.0
    assert not reconciler.is_news({**HELD, "level": 5.0})


@pytest.mark.parametrize(
    "changes, text",
    [
        ({"level": -1, "title": "new"}, "level: refused -1: must be a number in [0, inf)"),
        ({"low": 10.0}, "low, high: refused 10, 9: low must be at most high"),
        (
            {"levle": 5},
            "levle: refused 5: must be one that this node declares (did you mean level?",
        ),
        ({"xyz": "a", "level": True}, "xyz: refused 'a': must be one that this node declares; "),
        ({"xyz": "a", "level": True}, "parameter level: refused True: must be a number"),
        ({"low": "x", "high": -1}, "low: refused 'x': must be a number"),
    ],
)
def test_refused_change_has_no_effect(changes: Dict[str, Any], text: str) -> None:
    reconciler = Reconciler(Gauge)
    reconciler.start(HELD, 0.0)
    with pytest.raises(ParameterError) as caught:
        reconciler.validate(changes)
    assert text in str(caught.value)
    assert reconciler.values == IN_FORCE


def test_where_defaults_do_not_go_together_a_value_must_be_set() -> None:
    class Crossed(Gauge):
        """Defaults that break the rule."""

        low = FloatParameter(10.0, help="above high")

    for raw in (MISSING, {}, {"low": 10.0}, {"high": 9.5}):
        with pytest.raises(RuleError, match="low must be at most high"):
            Reconciler(Crossed).start(raw, 0.0)
    assert Reconciler(Crossed).start({"low": 1.0}, 0.0).values == Crossed(low=1.0)


class Free(ParameterSet):
    """Parameters that go with anything."""

    level = FloatParameter(1.0, minimum=0.0, help="a level")
    marks = ListParameter([], element=FloatParameter(0.0, help=""), help="marks")


class World:
    """A server, its users, and a node that follows it; notifications may come late."""

    def __init__(self, declaration: Any, raw: Any) -> None:
        self.now = 100.0
        self.server = set_on(MISSING, {"": raw})
        self.underway: List[Tuple[str, Any]] = []
        self.pushed: List[Tuple[str, Any]] = []
        self.wanted = declaration().as_dict()
        self.reconciler = Reconciler(declaration)
        decision = self.reconciler.start(self.server, self.now)
        self.wanted = decision.values.as_dict()
        self.server = set_on(self.server, decision.writes)
        self.reconciler.written(self.now)

    def use(self, name: str, value: Any) -> None:
        """Set or delete a value as a user, and record the expected final values."""
        self.server = set_on(self.server, {name: value})
        self.underway.append((name, value))
        tree = value if isinstance(value, dict) else {}
        for each, parameter in self.reconciler.values.declared.items():
            raw = value if name == each else tree.get(each, MISSING)
            if each == name or (not name and (isinstance(value, dict) or value is MISSING)):
                try:
                    self.wanted[each] = (
                        parameter.default if raw is MISSING else parameter.coerce(raw)
                    )
                except ParameterError:
                    pass

    def deliver(self, count: int) -> None:
        self.pushed += self.underway[:count]
        del self.underway[:count]

    def reconcile(self, meddle: Callable[[], None], reaches: bool, works: bool) -> None:
        """Read and step; another program may write just before the result is written."""
        raw = self.server
        if not (self.pushed or self.reconciler.is_news(raw)):
            return
        decision = self.reconciler.step(
            Observation(raw, list(self.pushed), read_at=self.now), self.now
        )
        type(decision.values)(**decision.values.as_dict())
        for name, value in decision.writes.items():
            in_force = on_wire(decision.values)
            part = value if name == "" else {name: value}
            assert {k: v for k, v in part.items() if k in in_force}.items() <= in_force.items()
        if decision.again:
            assert not decision.writes and not decision.errors
            return
        meddle()
        if reaches:
            self.server = set_on(self.server, decision.writes)
        if decision.writes and not (reaches and works):
            self.reconciler.failed()
            return
        if decision.writes:
            self.reconciler.written(self.now)
        self.pushed.clear()

    def come_to_rest(self) -> None:
        self.deliver(len(self.underway))
        for _ in range(100):
            self.reconcile(lambda: None, reaches=True, works=True)
            self.now += 0.1
            if not self.pushed and not self.reconciler.is_news(self.server):
                return
        raise AssertionError(f"no rest: {self.server} {self.reconciler.values}")


LEVELS = st.sampled_from([-1, 0, 1.0, 2, 2.0, 5, "5", "x", True, UNREADABLE, MISSING, 7.5])
MARKS = st.sampled_from([[], [1], ["1"], [1.0, 2.0], ["x"], 5, MISSING])
USES = (
    st.tuples(st.just("level"), LEVELS)
    | st.tuples(st.just("marks"), MARKS)
    | st.tuples(st.just("other"), st.integers(0, 1))
    | st.tuples(
        st.just(""), st.just(MISSING) | st.fixed_dictionaries({}, optional={"level": st.just(3)})
    )
)
LOOKS = st.tuples(st.none() | USES, st.booleans(), st.booleans())
MOVES = st.lists(USES | LOOKS | st.integers(1, 3), max_size=12)


def play(world: World, moves: List[Any]) -> None:
    for move in moves:
        world.now += 0.01
        if isinstance(move, int):
            world.deliver(move)
        elif len(move) == 2:
            world.use(*move)
        else:
            meddling, reaches, works = move
            meddle = (lambda: world.use(*meddling)) if meddling else (lambda: None)
            world.reconcile(meddle, reaches, works)
    world.come_to_rest()


@given(st.sampled_from([{}, {"level": 4.0}, {"level": "4", "marks": [1]}]), MOVES)
def test_last_good_value_of_each_parameter_is_in_force_in_the_end(raw: Any, moves: Any) -> None:
    world = World(Free, raw)
    play(world, moves)
    assert world.reconciler.values.as_dict() == world.wanted
    assert corrections(world.reconciler.values, world.server) == {}


ANY = st.sampled_from([-1, 0, 2.0, 20, "x", [], {}, {"a": 1}, MISSING, float("nan")])
ANY_USES = st.tuples(st.sampled_from(["level", "title", "low", "high", "other"]), ANY) | st.tuples(
    st.just(""), ANY | st.dictionaries(st.sampled_from(["level", "low", "high"]), ANY, max_size=2)
)
ANY_LOOKS = st.tuples(st.none() | ANY_USES, st.booleans(), st.booleans())


@given(st.lists(ANY_USES | ANY_LOOKS | st.integers(1, 3), max_size=12))
def test_server_has_valid_values_after_any_changes(moves: Any) -> None:
    world = World(Gauge, {})
    play(world, moves)
    assert corrections(world.reconciler.values, world.server) == {}


# Writers that correct each other must not hurry.


def test_burst_is_allowed_immediately_then_one_per_refill():
    bucket = TokenBucket()
    assert [bucket.allow("level", 0.0) for _ in range(BURST)] == [True] * BURST
    assert not bucket.allow("level", 0.5 * REFILL_S)
    assert bucket.allow("title", 0.5 * REFILL_S)
    assert bucket.allow("level", 1.1 * REFILL_S)
    assert not bucket.allow("level", 1.9 * REFILL_S)


def test_one_write_per_refill_period_is_always_allowed():
    bucket = TokenBucket()
    for _ in range(BURST):
        bucket.allow("level", 0.0)
    assert all(bucket.allow("level", number * REFILL_S) for number in range(1, 1000))


@given(st.lists(st.floats(0.0, 3.0 * REFILL_S), max_size=200))
def test_at_most_the_burst_and_one_per_period_is_allowed(pauses):
    bucket, now, allowed = TokenBucket(), 0.0, 0
    for pause in pauses:
        now += pause
        allowed += bucket.allow("level", now)
        assert allowed <= BURST + now / REFILL_S + 1e-6


@pytest.mark.parametrize("rest", [BURST * REFILL_S, 1e6])
def test_the_burst_is_back_after_a_rest(rest):
    bucket = TokenBucket()
    for _ in range(2 * BURST):
        bucket.allow("level", 0.0)
    assert [bucket.allow("level", rest) for _ in range(BURST + 1)].count(True) == BURST
