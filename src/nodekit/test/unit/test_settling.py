"""What of the parameter server's values comes into force, is refused, or is written back."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from nodekit.parameters.declaration import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterSet,
    RuleError,
    StringParameter,
    rule,
    to_wire,
)
from nodekit.parameters.settling import is_allowed, last_allowed, settle, unknown_names


class Gauge(ParameterSet):
    """One parameter of each kind, and two rules that share a parameter."""

    low = FloatParameter(0.0, help="lower limit")
    high = FloatParameter(1.0, help="upper limit")
    top = FloatParameter(2.0, maximum=100.0, help="end of the scale")
    count = IntParameter(3, minimum=0, maximum=9, help="how many")
    on = BoolParameter(False, help="switch")
    title = StringParameter("gauge", help="title")
    shape = EnumParameter("round", choices=("round", "flat"), help="shape")
    marks = ListParameter([1.0], element=FloatParameter(0.0, help=""), max_length=3, help="marks")

    @rule("low", "high")
    def ordered(self) -> None:
        """Keep the limits in order."""
        if self.low > self.high:
            raise ValueError("low <= high")

    @rule("high", "top")
    def on_scale(self) -> None:
        """Keep the upper limit on the scale."""
        if self.high > self.top:
            raise ValueError("high <= top")


DEFAULTS = Gauge()
ALL_SET = {name: to_wire(value) for name, value in DEFAULTS.as_dict().items()}

SMALL = st.integers(-2, 5) | st.floats(-2.0, 5.0) | st.sampled_from(["1e0", "3", "x", "", "1e3"])
NONSENSE = st.sampled_from([None, {}, {"a": 1}, True, False, [], float("nan"), float("inf"), "off"])
BY_NAME = {name: SMALL | NONSENSE for name in ("low", "high", "top", "count")}
BY_NAME["on"] = st.booleans() | NONSENSE
BY_NAME["title"] = st.text(max_size=3) | NONSENSE
BY_NAME["shape"] = st.sampled_from(["round", "flat", "odd"]) | NONSENSE
BY_NAME["marks"] = st.lists(SMALL, max_size=4) | NONSENSE
RAW = st.fixed_dictionaries({}, optional={**BY_NAME, "unheard_of": NONSENSE})


@st.composite
def gauges(draw):
    """A snapshot that keeps the rules."""
    low, high, top = sorted(draw(st.tuples(*[st.floats(-2.0, 5.0)] * 3)))
    marks = draw(st.lists(st.floats(-9.0, 9.0), max_size=3))
    return Gauge(low=low, high=high, top=top, count=draw(st.integers(0, 9)), marks=marks)


def settle_all(in_force, **raw):
    """Settle with the values in force on the server, apart from some."""
    full = {name: to_wire(value) for name, value in in_force.as_dict().items()}
    full.update(raw)
    return settle(in_force, {name: value for name, value in full.items() if value is not None})


def test_nothing_to_do_where_the_server_tells_the_truth():
    assert settle(DEFAULTS, ALL_SET) == (DEFAULTS, [], {})


def test_what_is_unset_gets_its_default_and_is_written():
    in_force = Gauge(low=0.5, high=1.5, marks=[4, 5])
    assert settle(in_force, {}) == (DEFAULTS, [], ALL_SET)
    values, refusals, writes = settle_all(in_force, marks=None)
    assert values == in_force.replace(marks=[1.0])
    assert (refusals, writes) == ([], {"marks": [1.0]})


def test_what_a_restarted_master_lost_is_kept_and_written():
    in_force = Gauge(low=0.5, high=1.5, marks=[4, 5])
    values, refusals, writes = settle(in_force, {"high": 1.75}, missing=in_force)
    assert values == in_force.replace(high=1.75)
    assert refusals == []
    assert writes["low"] == 0.5
    assert writes["marks"] == [4.0, 5.0]
    assert set(writes) == set(Gauge.declared) - {"high"}


@pytest.mark.parametrize(
    "raw, value, written",
    [
        (5, 5.0, False),
        (5.5, 5.5, False),
        ("1e1", 10.0, True),
        ("5", 5.0, True),
        (-0.0, 0.0, False),
    ],
)
def test_the_server_is_written_only_where_it_holds_something_else(raw, value, written):
    settled = settle_all(Gauge(top=50.0), top=raw, high=-1.0, low=-1.0)
    assert settled.values.top == value
    assert settled.writes == ({"top": value} if written else {})


def test_elements_of_lists_are_written_where_text_stands_for_a_number():
    assert settle_all(DEFAULTS, marks=[1, 2.5]).writes == {}
    assert settle_all(DEFAULTS, marks=[1, "1e3"]).writes == {"marks": [1.0, 1000.0]}


def test_truth_value_in_place_of_an_equal_number_is_refused_and_put_back():
    settled = settle_all(Gauge(high=1.0, count=1), high=True, count=True)
    assert settled.values == Gauge(count=1)
    assert settled.writes == {"high": 1.0, "count": 1}
    assert [error.value for error in settled.refusals] == [True, True]
    assert [type(value) for value in settled.writes.values()] == [float, int]
    assert settle_all(Gauge(on=True), on=1).writes == {"on": True}


@pytest.mark.parametrize("raw", ["x", "", True, float("nan"), {"a": 1}, [1.0], 101.0])
def test_refused_value_leaves_the_one_in_force_and_says_why(raw):
    in_force = Gauge(top=7.0)
    settled = settle_all(in_force, top=raw, count=5)
    assert settled.values == in_force.replace(count=5)
    assert settled.writes == {"top": 7.0}
    (error,) = settled.refusals
    assert error.name == "top"
    assert "(-inf, 100]" in error.allowed


def test_rule_is_judged_when_all_values_are_known():
    in_force = Gauge(low=0.0, high=1.0, top=2.0)
    settled = settle_all(in_force, low=50.0, high=60.0, top=70.0)
    assert settled.values == Gauge(low=50.0, high=60.0, top=70.0)
    assert (settled.refusals, settled.writes) == ([], {})


def test_broken_rule_takes_back_only_the_changes_that_it_is_about():
    settled = settle_all(DEFAULTS, low=5.0, count=7, title="new")
    assert settled.values == Gauge(count=7, title="new")
    assert settled.writes == {"low": 0.0}
    (error,) = settled.refusals
    assert isinstance(error, RuleError)
    assert error.names == ("low", "high")
    assert error.value == [5.0, 1.0]


def test_taking_back_goes_on_to_a_rule_that_is_broken_by_it():
    # high=0.5 goes with top=0.7 but not with low=0.8; the old high=1 not with top=0.7.
    settled = settle_all(Gauge(low=0.2), low=0.8, high=0.5, top=0.7)
    assert settled.values == Gauge(low=0.2)
    assert [error.names for error in settled.refusals] == [("low", "high"), ("high", "top")]
    assert settled.writes == {"low": 0.2, "high": 1.0, "top": 2.0}


def test_rule_is_judged_with_the_value_in_force_where_one_was_refused():
    settled = settle_all(Gauge(low=0.2), low=5.0, high="x")
    assert settled.values == Gauge(low=0.2)
    assert [error.name for error in settled.refusals] == ["high", "low, high"]


def test_default_of_a_deleted_value_is_taken_back_where_it_breaks_a_rule():
    in_force = Gauge(low=1.5, high=1.8)
    settled = settle_all(in_force, high=None)
    assert settled.values == in_force
    assert settled.writes == {"high": 1.8}


def test_newer_value_that_was_overwritten_wins_and_is_written():
    full = {**ALL_SET, "count": -1, "title": "old"}
    settled = settle(DEFAULTS, full, overwritten={"count": "4", "title": "new"})
    assert settled.values == Gauge(count=4, title="new")
    assert settled.writes == {"count": 4, "title": "new"}
    assert [error.name for error in settled.refusals] == ["count"]


def test_newer_value_that_was_overwritten_is_subject_to_the_rules():
    settled = settle(DEFAULTS, {**ALL_SET, "low": "x"}, overwritten={"low": 50.0})
    assert settled.values == DEFAULTS
    assert settled.writes == {"low": 0.0}
    assert [error.name for error in settled.refusals] == ["low", "low, high"]


def test_value_in_force_is_not_judged_again():
    class Once(StringParameter):
        """Text that is allowed when it is new, such as the name of a file that is read then."""

        allowed = "anything new"

        def coerce(self, raw):
            if raw == "stale":
                raise self.refuse(raw)
            return super().coerce(raw)

    class Reader(ParameterSet):
        """A set with such a parameter."""

        file = Once("", help="file")

    in_force = Reader.unjudged({"file": "stale"})
    assert settle(in_force, {"file": "stale"}) == (in_force, [], {})
    assert len(settle(Reader(), {"file": "stale"}).refusals) == 1


def test_values_that_nobody_declared_are_left_alone():
    assert settle_all(DEFAULTS, unheard_of=float("nan"), sub={"a": 1}) == (DEFAULTS, [], {})


@given(gauges(), RAW, st.booleans(), st.none() | RAW)
def test_what_is_written_settles_everything(in_force, raw, forgotten, pushed):
    pushed = {name: value for name, value in (pushed or {}).items() if name in Gauge.declared}
    overwritten = last_allowed(in_force, {name: [value] for name, value in pushed.items()})
    settled = settle(in_force, raw, in_force if forgotten else None, overwritten)
    Gauge(**settled.values.as_dict())
    server = {**raw, **settled.writes}
    again = settle(settled.values, server)
    assert again.values == settled.values
    assert (again.refusals, again.writes) == ([], {})
    for name, value in settled.writes.items():
        assert name not in raw or repr(raw[name]) != repr(value), "written though it was there"


@given(gauges(), RAW)
def test_value_in_force_is_the_servers_or_the_default_or_stays(in_force, raw):
    settled = settle(in_force, raw)
    refused = {name for error in settled.refusals for name in error.name.split(", ")}
    for name, parameter in Gauge.declared.items():
        value, old = getattr(settled.values, name), getattr(in_force, name)
        if name in refused:
            assert value == old
        elif name in raw:
            assert value == parameter.coerce(raw[name])
        else:
            assert value == parameter.default
        if not is_allowed(parameter, raw.get(name, parameter.default)):
            assert name in refused


@given(gauges(), gauges(), st.sets(st.sampled_from(sorted(Gauge.declared))))
def test_combination_that_is_allowed_is_never_refused(in_force, wanted, unset):
    raw = {name: to_wire(value) for name, value in wanted.as_dict().items() if name not in unset}
    try:
        expected = Gauge(**raw)
    except RuleError:
        assume(False)
    assert settle(in_force, raw)[:2] == (expected, [])


def test_last_allowed_of_pushed_values_is_picked():
    pushed = {"count": [-1, 4, "5", 99], "on": [1, 0], "title": ["a", "b"], "shape": []}
    assert last_allowed(DEFAULTS, pushed) == {"count": "5", "title": "b"}


@pytest.mark.parametrize(
    "name, nearest",
    [
        ("hihg", "high"),
        ("Low", "low"),
        ("COUNT", "count"),
        ("Mesage", "Message"),
        ("message", "Message"),
        ("xylophone", None),
    ],
)
def test_unknown_name_comes_with_the_nearest_known_one(name, nearest):
    raw = {**ALL_SET, name: 1, "Message": "hello"}
    assert unknown_names(Gauge.declared, raw, ["Message"]) == {name: nearest}


def test_no_name_is_unknown_where_all_are_declared():
    assert unknown_names(Gauge.declared, ALL_SET) == {}
