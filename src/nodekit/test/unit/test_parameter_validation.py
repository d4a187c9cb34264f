"""Tests of raw values that are accepted, rejected, or corrected on the server."""

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
)
from nodekit.parameters.parameter_types import MISSING
from nodekit.parameters.validation import (
    apply_rules,
    corrections,
    last_valid,
    on_wire,
    unknown_names,
    validate_each,
)


class Gauge(ParameterSet):
    """One parameter of each type, and two rules that share a parameter."""

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
            raise ValueError("low must be at most high")

    @rule("high", "top")
    def on_scale(self) -> None:
        """Keep the upper limit on the scale."""
        if self.high > self.top:
            raise ValueError("high must be at most top")


DEFAULTS = Gauge()

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
    """Return a snapshot that keeps the rules."""
    low, high, top = sorted(draw(st.tuples(*[st.floats(-2.0, 5.0)] * 3)))
    marks = draw(st.lists(st.floats(-9.0, 9.0), max_size=3))
    return Gauge(low=low, high=high, top=top, count=draw(st.integers(0, 9)), marks=marks)


def validate(in_force, raw):
    """Validate a namespace; return values, errors and the values to write."""
    coerced, refused = validate_each(in_force, raw, missing=DEFAULTS.as_dict())
    values, broken = apply_rules(in_force, coerced)
    return values, [*refused, *broken], corrections(values, raw)


def validate_changes(in_force, **raw):
    """Validate the current values with some changes."""
    return validate(in_force, {**on_wire(in_force), **raw})


def test_correct_server_needs_no_write():
    assert validate(DEFAULTS, on_wire(DEFAULTS)) == (DEFAULTS, [], {})


def test_unset_values_are_missing_and_corrected():
    in_force = Gauge(low=0.5, high=1.5, marks=[4, 5])
    assert validate(in_force, {}) == (DEFAULTS, [], on_wire(DEFAULTS))
    coerced, refused = validate_each(in_force, {"low": 0.75}, missing=in_force.as_dict())
    assert (coerced, refused) == ({**in_force.as_dict(), "low": 0.75}, [])


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
def test_the_server_is_corrected_only_where_it_holds_something_else(raw, value, written):
    values, _, writes = validate_changes(Gauge(top=50.0), top=raw, high=-1.0, low=-1.0)
    assert values.top == value
    assert writes == ({"top": value} if written else {})


def test_lists_with_text_for_a_number_are_corrected():
    assert validate_changes(DEFAULTS, marks=[1, 2.5])[2] == {}
    assert validate_changes(DEFAULTS, marks=[1, "1e3"])[2] == {"marks": [1.0, 1000.0]}


def test_truth_value_in_place_of_an_equal_number_is_refused_and_corrected():
    values, errors, writes = validate_changes(Gauge(high=1.0, count=1), high=True, count=True)
    assert values == Gauge(count=1)
    assert writes == {"high": 1.0, "count": 1}
    assert [error.value for error in errors] == [True, True]
    assert [type(value) for value in writes.values()] == [float, int]
    assert validate_changes(Gauge(on=True), on=1)[2] == {"on": True}


@pytest.mark.parametrize("raw", ["x", "", True, float("nan"), {"a": 1}, [1.0], 101.0])
def test_refused_value_keeps_the_value_in_force_and_gives_the_reason(raw):
    in_force = Gauge(top=7.0)
    values, (error,), writes = validate_changes(in_force, top=raw, count=5)
    assert values == in_force.replace(count=5)
    assert writes == {"top": 7.0}
    assert error.name == "top"
    assert "(-inf, 100]" in error.allowed


def test_rule_is_checked_when_all_values_are_known():
    values, errors, writes = validate_changes(DEFAULTS, low=50.0, high=60.0, top=70.0)
    assert values == Gauge(low=50.0, high=60.0, top=70.0)
    assert (errors, writes) == ([], {})


def test_broken_rule_reverts_only_its_own_parameters():
    values, (error,), writes = validate_changes(DEFAULTS, low=5.0, count=7, title="new")
    assert values == Gauge(count=7, title="new")
    assert writes == {"low": 0.0}
    assert isinstance(error, RuleError)
    assert error.names == ("low", "high")
    assert error.value == [5.0, 1.0]


def test_reverting_a_value_reverts_the_values_of_its_rules():
    # high=0.5 goes with top=0.7 but not with low=0.8; the old high=1 not with top=0.7.
    values, errors, writes = validate_changes(Gauge(low=0.2), low=0.8, high=0.5, top=0.7)
    assert values == Gauge(low=0.2)
    assert [error.names for error in errors] == [("low", "high"), ("high", "top")]
    assert writes == {"low": 0.2, "high": 1.0, "top": 2.0}


def test_rule_is_checked_with_current_value_of_rejected_one():
    values, errors, _ = validate_changes(Gauge(low=0.2), low=5.0, high="x")
    assert values == Gauge(low=0.2)
    assert [error.name for error in errors] == ["high", "low, high"]


def test_default_of_a_deleted_value_is_reverted_if_it_breaks_a_rule():
    in_force = Gauge(low=1.5, high=1.8)
    values, _, writes = validate(
        in_force, {k: v for k, v in on_wire(in_force).items() if k != "high"}
    )
    assert values == in_force
    assert writes == {"high": 1.8}


class Fresh(StringParameter):
    """Text that is allowed when it is new, such as the name of a file that is read then."""

    allowed = "anything new"

    def coerce(self, raw):
        if raw == "stale":
            raise self.refuse(raw)
        return super().coerce(raw)


class Reader(ParameterSet):
    """A set with such a parameter."""

    file = Fresh("", help="file")


def test_current_value_is_not_validated_again():
    in_force = Reader.from_coerced({"file": "stale"})
    assert validate_each(in_force, {"file": "stale"}, {}) == ({"file": "stale"}, [])
    assert last_valid(in_force, ["file"], [("file", "new"), ("file", "stale")]) == {"file": "stale"}
    assert len(validate_each(Reader(), {"file": "stale"}, {})[1]) == 1


def test_undeclared_values_are_left_alone():
    raw = {"unheard_of": float("nan"), "sub": {"a": 1}}
    assert validate_changes(DEFAULTS, **raw) == (DEFAULTS, [], {})


@given(gauges(), RAW)
def test_written_corrections_settle_everything(in_force, raw):
    values, _, writes = validate(in_force, raw)
    Gauge(**values.as_dict())
    assert validate(values, {**raw, **writes}) == (values, [], {})
    for name, value in writes.items():
        assert name not in raw or repr(raw[name]) != repr(value), "written though it was there"


@given(gauges(), RAW)
def test_value_in_force_is_the_servers_or_the_default_or_stays(in_force, raw):
    values, errors, _ = validate(in_force, raw)
    refused = {name for error in errors for name in error.names}
    for name, parameter in Gauge.declared.items():
        value, old = getattr(values, name), getattr(in_force, name)
        if name in refused:
            assert value == old
        elif name in raw:
            assert value == parameter.coerce(raw[name])
        else:
            assert value == parameter.default


@given(gauges(), gauges(), st.sets(st.sampled_from(sorted(Gauge.declared))))
def test_combination_that_is_allowed_is_never_refused(in_force, wanted, unset):
    raw = {name: value for name, value in on_wire(wanted).items() if name not in unset}
    try:
        expected = Gauge(**raw)
    except RuleError:
        assume(False)
    assert validate(in_force, raw)[:2] == (expected, [])


@pytest.mark.parametrize(
    "pushed, expected",
    [
        ([("count", -1), ("count", 4), ("count", "5"), ("count", 99)], {"count": 5}),
        ([("on", 1), ("title", "a"), ("title", "b"), ("top", 5.0)], {"title": "b"}),
        ([("count", 4), ("count", MISSING), ("count", -1)], {"count": 3}),
        ([("", {"count": 4}), ("other", 1)], {"count": 4, "on": False, "title": "gauge"}),
        (
            [("count", 4), ("", {"count": -1, "title": "b"})],
            {"count": 4, "on": False, "title": "b"},
        ),
        ([("count", 4), ("", MISSING)], {"count": 3, "on": False, "title": "gauge"}),
        ([("count", 4), ("", 7)], {"count": 4}),
    ],
)
def test_last_good_of_pushed_values_is_picked(pushed, expected):
    assert last_valid(DEFAULTS, ["count", "on", "title"], pushed) == expected


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
    raw = {**on_wire(DEFAULTS), name: 1, "Message": "hello"}
    assert unknown_names(Gauge.declared, raw, ["Message"]) == {name: nearest}


def test_only_a_probably_misspelt_name_is_unknown_where_all_others_are_exempt():
    raw = {**on_wire(DEFAULTS), "COUNT": 1, "hihg": 1, "highway": 1, "xylophone": 1, "*": 1}
    assert unknown_names(Gauge.declared, raw, ["*"]) == {"COUNT": "count", "hihg": "high"}


def test_no_name_is_unknown_where_all_are_declared():
    assert unknown_names(Gauge.declared, on_wire(DEFAULTS)) == {}
