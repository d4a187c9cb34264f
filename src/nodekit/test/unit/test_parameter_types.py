"""Tests of accepted and rejected values of each parameter type, and of the messages."""

import copy
import datetime
import enum
import math
import xml.parsers.expat
import xmlrpc.client

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.parameters.numeric_types import (
    INT32_MAX,
    INT32_MIN,
    FloatParameter,
    IntParameter,
    RateParameter,
)
from nodekit.parameters.parameter_types import (
    BoolParameter,
    BytesParameter,
    EnumParameter,
    ListParameter,
    ParameterError,
    StringParameter,
    format_value,
    is_same,
    to_wire,
)

BOOL = BoolParameter(False, help="a switch")
FLOAT = FloatParameter(0.0, help="any number")
INT = IntParameter(0, help="any whole number")
TEXT = StringParameter("", help="any text")
ENUM = EnumParameter("off", choices=("off", "sine", "square"), help="a shape")
BYTES = BytesParameter(b"", help="any bytes")
FLOATS = ListParameter([], element=FLOAT, max_length=3, help="up to three numbers")
KINDS = [BOOL, FLOAT, INT, TEXT, ENUM, FLOATS]

NAN, INF = float("nan"), float("inf")
NOBODY_TAKES = [
    None,
    {},
    {"a": 1},
    b"bytes",
    xmlrpc.client.Binary(b"bytes"),
    datetime.datetime(2024, 1, 1),
    NAN,
    INF,
    1j,
]

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6)
RAW = SCALARS | st.lists(SCALARS, max_size=4) | st.dictionaries(st.text(max_size=2), SCALARS)


def assert_taken(parameter, raw, expected):
    value = parameter.coerce(raw)
    assert value == expected
    assert type(value) is type(expected)


def assert_refused(parameter, raw):
    with pytest.raises(ParameterError) as caught:
        parameter.coerce(raw)
    return caught.value


@pytest.mark.parametrize("raw", [True, False])
def test_bool_accepts_truth_values(raw):
    assert_taken(BOOL, raw, raw)


@pytest.mark.parametrize("raw", [0, 1, 1.0, "true", "True", "off", "", [True]])
def test_bool_refuses_substitutes(raw):
    assert_refused(BOOL, raw)


@pytest.mark.parametrize(
    "raw, expected",
    [
        (2.5, 2.5),
        (5, 5.0),
        (-3, -3.0),
        ("1e3", 1000.0),
        ("-2.5E-3", -0.0025),
        (" 7 ", 7.0),
        ("5", 5.0),
        ("2147483648", 2147483648.0),
        (1.7e308, 1.7e308),
    ],
)
def test_float_accepts_numbers_and_numeric_text(raw, expected):
    assert_taken(FLOAT, raw, expected)


NOT_NUMBERS = [True, False, "", " ", "abc", "1,5", "1e", "0x10", "--1", "nan", "inf", "-inf"]
NOT_NUMBERS += [".nan", ".inf", "1e999", "Infinity", -INF, [1.0], [], 10**400]


@pytest.mark.parametrize("raw", NOT_NUMBERS)
@pytest.mark.parametrize("parameter", [FLOAT, INT])
def test_numbers_are_finite_and_never_truth_values(parameter, raw):
    assert_refused(parameter, raw)


@pytest.mark.parametrize(
    "raw, expected",
    [
        (5, 5),
        (5.0, 5),
        ("1e3", 1000),
        ("-7", -7),
        (INT32_MAX, 2147483647),
        (INT32_MIN, -2147483648),
        (2147483647.0, 2147483647),
    ],
)
def test_int_accepts_whole_numbers(raw, expected):
    assert_taken(INT, raw, expected)


@pytest.mark.parametrize("raw", [0.5, "0.5", 2147483648, -2147483649, 2147483648.0, "2147483648"])
def test_int_refuses_fractions_and_more_than_32_bits(raw):
    assert_refused(INT, raw)


def test_int_with_an_open_end_keeps_the_other_end_within_32_bits():
    positive = IntParameter(1, above=0, help="a count")
    assert_refused(positive, 0)
    assert_refused(positive, 2147483648)
    assert positive.range == "(0, 2147483647]"
    negative = IntParameter(-1, below=0, help="a debt")
    assert_refused(negative, 0)
    assert_refused(negative, -2147483649)
    assert negative.range == "[-2147483648, 0)"


@pytest.mark.parametrize("raw", ["", "hello world", "1e3", "true", "no: yaml", "\u00e5\u4f60"])
def test_text_is_taken_as_it_is(raw):
    assert_taken(TEXT, raw, raw)


@given(st.characters(whitelist_categories=["Cc", "Cs", "Cn"]) | st.characters())
def test_text_is_taken_as_far_as_the_parameter_server_can_carry_it(raw):
    try:
        wire = xmlrpc.client.dumps((raw,)).encode()
        ((arrived,), _) = xmlrpc.client.loads(wire)
    except (UnicodeEncodeError, xml.parsers.expat.ExpatError):
        arrived = None
    if arrived == raw:
        assert_taken(TEXT, raw, raw)
    else:
        assert_refused(TEXT, raw)


@pytest.mark.parametrize("raw", ["\r\n x \r", "\r"])
def test_text_that_would_arrive_as_another_is_refused(raw):
    assert_refused(TEXT, raw)


@pytest.mark.parametrize("raw", [5, 5.0, True, ["a"]])
def test_text_refuses_other_types(raw):
    error = assert_refused(TEXT, raw)
    assert "quote" in str(error)


def test_enum_accepts_only_its_words():
    assert_taken(ENUM, "square", "square")
    for raw in ("Square", "squar", "", False, 0, ["sine"]):
        assert_refused(ENUM, raw)
    assert ENUM.range == "{off, sine, square}"


@pytest.mark.parametrize("raw", NOBODY_TAKES, ids=lambda raw: type(raw).__name__)
@pytest.mark.parametrize("parameter", KINDS, ids=lambda parameter: parameter.type_name)
def test_values_of_no_parameter_type_are_refused(parameter, raw):
    assert_refused(parameter, raw)
    assert_refused(FLOATS, [raw])


@given(raw=RAW, parameter=st.sampled_from(KINDS))
def test_any_raw_value_is_refused_or_becomes_a_finite_value_of_the_type(raw, parameter):
    kind = {BOOL: bool, FLOAT: float, INT: int, TEXT: str, ENUM: str, FLOATS: tuple}[parameter]
    try:
        value = parameter.coerce(raw)
    except ParameterError as error:
        assert str(error)
    else:
        assert type(value) is kind
        assert kind is not float or math.isfinite(value)
        assert parameter.coerce(to_wire(value)) == value


@pytest.mark.parametrize(
    "ends, inside, outside",
    [
        ({"minimum": 0.0}, [0, 1e300], [-1e-300]),
        ({"maximum": 1.0}, [1, -1e300], [1.0000001]),
        ({"above": 0.0}, [5e-324, "1e-9"], [0, -0.0, "0"]),
        ({"below": 1.0}, [0.9999999], [1, 1.0]),
        ({"above": 0.0, "maximum": 2.0}, [2, 1e-9], [0, 2.1]),
        ({"minimum": -1.0, "below": 1.0}, [-1, 0.5], [1, -1.5]),
    ],
)
def test_ends_of_a_range_are_closed_or_open(ends, inside, outside):
    parameter = FloatParameter(0.5, help="a number", **ends)
    assert inside and outside
    for raw in inside:
        parameter.coerce(raw)
    for raw in outside:
        assert_refused(parameter, raw)


@given(st.floats(0.0, 100.0), st.floats(0.0, 100.0), st.floats(allow_nan=False))
def test_range_matches_its_notation(low, width, raw):
    closed = FloatParameter(low, minimum=low, maximum=low + width, help="")
    opened = FloatParameter(low, above=low, below=low + width, help="")
    assert (low <= raw <= low + width) == taken(closed, raw)
    assert (low < raw < low + width) == taken(opened, raw)


def taken(parameter, raw):
    try:
        parameter.coerce(raw)
    except ParameterError:
        return False
    return True


@pytest.mark.parametrize(
    "options, text",
    [
        ({}, ""),
        ({"minimum": 0.0}, "[0, inf)"),
        ({"maximum": 2.5}, "(-inf, 2.5]"),
        ({"above": 0.0, "below": 1e9}, "(0, 1e9)"),
        ({"above": 0.0, "maximum": 10000.0}, "(0, 10000]"),
    ],
)
def test_range_in_interval_notation(options, text):
    assert FloatParameter(1.0, help="", **options).range == text


@given(st.integers(-1000, 1000), st.sampled_from([0.1, 0.25, 0.3, 2.0]), st.floats(0.01, 0.99))
def test_steps_count_from_the_lower_bound(count, step, fraction):
    free = FloatParameter(0.0, step=step, help="")
    bound = FloatParameter(0.05, minimum=0.05, step=step, help="")
    assert taken(free, count * step)
    assert not taken(free, (count + fraction) * step)
    assert taken(bound, 0.05 + abs(count) * step)
    assert not taken(bound, 0.05 + (abs(count) + fraction) * step)


def test_steps_hold_over_the_whole_range_of_an_int():
    even = IntParameter(0, minimum=0, step=2, help="")
    assert_taken(even, 2147483646, 2147483646)
    assert_refused(even, 2147483647)


def test_rate_is_valid_for_a_timer():
    rate = RateParameter(10.0, help="how often")
    assert (rate.range, rate.unit, rate.type_name) == ("[1e-06, 10000]", "Hz", "float")
    assert_taken(rate, 1e-6, 1e-6)
    for raw in (0, -1, 10001.0):
        assert_refused(rate, raw)
    assert_refused(RateParameter(10.0, maximum=100.0, help=""), 101)


def test_a_rate_may_be_pausable():
    rate = RateParameter(0.0, pausable=True, help="how often")
    assert_taken(rate, 0, 0.0)
    assert_refused(rate, -1e-9)


def test_list_accepts_elements_of_one_type_and_coerces_each():
    assert_taken(FLOATS, [1, "1e3", 2.5], (1.0, 1000.0, 2.5))
    assert_taken(FLOATS, (), ())
    for raw in ([1, True], [NAN], ["a"], [[1.0]], [1, 2, 3, 4], "123", {"0": 1.0}, 1.0):
        error = assert_refused(FLOATS, raw)
        assert error.value is raw


def test_list_keeps_to_its_lengths():
    pair = ListParameter([1, 2], element=INT, min_length=2, max_length=2, help="a pair")
    assert_taken(pair, [3, 4.0], (3, 4))
    for raw in ([], [1], [1, 2, 3]):
        assert_refused(pair, raw)


def test_list_accepts_a_thousand_elements_by_default():
    many = ListParameter([], element=INT, help="many")
    assert_taken(many, [7] * 1000, (7,) * 1000)
    assert_refused(many, [7] * 1001)


def test_range_of_a_list_describes_its_elements():
    assert FLOATS.range == "0 to 3 of float"
    assert ListParameter([], element=ENUM, help="").range == "0 to 1000 of {off, sine, square}"


def test_list_of_words_of_an_enum():
    shapes = ListParameter(["sine"], element=ENUM, help="shapes")
    assert_taken(shapes, ["off", "square"], ("off", "square"))
    assert "off, sine, square" in str(assert_refused(shapes, ["cosine"]))


@pytest.mark.parametrize(
    "parameter, raw, words",
    [
        (FloatParameter(1.0, above=0, maximum=9, unit="Hz", help=""), -1.5, "-1.5|(0, 9]|Hz"),
        (IntParameter(0, minimum=0, maximum=8, step=2, help=""), 3, "3|whole|[0, 8]|steps of 2"),
        (BOOL, 1, "1|true or false"),
        (FLOAT, "abc", "'abc'|a number"),
        (FLOAT, NAN, "nan|a number"),
        (FLOAT, {"a": 1}, "{'a': 1}|a number"),
        (FLOAT, "", "''|a number"),
        (INT, 2147483648, "2147483648|2147483647]"),
        (ENUM, "cosine", "'cosine'|one of off, sine, square"),
        (FLOATS, [1, "x"], "[1, 'x']|0 to 3|a number"),
    ],
)
def test_refusal_names_parameter_value_and_rule(parameter, raw, words):
    owner = type("Owner", (), {"gauge": parameter})
    text = str(assert_refused(owner.gauge, raw))
    for word in ["parameter gauge: refused ", ": must be ", *words.split("|")]:
        assert word in text, text


@pytest.mark.parametrize(
    "error, text",
    [
        (
            FloatParameter(1.0, minimum=0, maximum=1e9, unit="Hz", help="").refuse(-1),
            "parameter /n: refused -1: must be a number in [0, 1e9] (Hz)",
        ),
        (ParameterError("a", 5, "b", "c"), "parameter /n/a: refused 5: must be b (c)"),
    ],
)
def test_refusal_is_a_plain_sentence_with_the_resolved_name(error, text):
    assert str(error.in_namespace("/n")) == text
    assert error.in_namespace("/n").names == (text.split()[1].rstrip(":"),)


def test_refusal_of_a_long_value_stays_short():
    assert len(str(assert_refused(FLOAT, "x" * 10000))) < 300
    assert len(str(assert_refused(FLOAT, list(range(10000))))) < 300


class Letter(str, enum.Enum):
    """A text that is shown as something else."""

    A = "a"


@pytest.mark.parametrize(
    "parameter, raw, expected",
    [
        (BOOL, numpy.bool_(True), True),
        (FLOAT, numpy.float32(0.5), 0.5),
        (FLOAT, numpy.int64(3), 3.0),
        (INT, numpy.int8(3), 3),
        (TEXT, numpy.str_("a"), "a"),
        (TEXT, Letter.A, "a"),
        (ENUM, numpy.str_("sine"), "sine"),
        (FLOATS, numpy.array([1.0, 2.0], numpy.float32), (1.0, 2.0)),
        (FLOATS, [numpy.float32(1.0), 2], (1.0, 2.0)),
        (BYTES, numpy.array([1, 2], numpy.uint8), b"\x01\x02"),
        (BYTES, numpy.bytes_(b"a"), b"a"),
    ],
)
def test_numpy_values_become_python_values(parameter, raw, expected):
    value = parameter.accept(raw)
    assert value == expected and type(value) is type(expected)
    assert {type(item) for item in value} <= {float} if parameter is FLOATS else True


@pytest.mark.parametrize(
    "parameter, raw, shown",
    [
        (FLOAT, numpy.bool_(True), "refused True"),
        (BOOL, numpy.array([True]), "refused [True]"),
        (INT, numpy.str_("x"), "refused 'x'"),
    ],
)
def test_refused_numpy_values_are_shown_as_python_values(parameter, raw, shown):
    with pytest.raises(ParameterError) as caught:
        parameter.accept(raw)
    assert shown in str(caught.value)


@pytest.mark.parametrize(
    "value, text",
    [
        (2.0, "2"),
        (0.1 + 0.2, "0.3"),
        (1e-7, "1e-07"),
        (NAN, "nan"),
        (True, "True"),
        ("", "''"),
        ("a b", "'a b'"),
        ((1, 2), "[1, 2]"),
        ({}, "{}"),
        (xmlrpc.client.Binary(b"hi"), "b'hi'"),
    ],
)
def test_values_are_formatted_briefly(value, text):
    assert format_value(value) == text


def test_values_are_cut_at_80_characters():
    assert format_value("x" * 78) == f"'{'x' * 78}'"
    assert format_value("x" * 79) == f"'{'x' * 76}..."


@pytest.mark.parametrize(
    "value, other",
    [(1, 1.0), (1, True), (0.0, False), ("1", 1), (1.0, 1.5), ([1], [1.0]), ([1], [1, 1])]
    + [({"a": 1}, {"a": True}), ({"a": 1}, {"b": 1}), ({}, []), (NAN, 0.0), (None, {})],
)
def test_values_of_different_types_are_not_the_same(value, other):
    assert not is_same(value, other)
    assert not is_same({"a": [value]}, {"a": [other]})


@given(RAW)
def test_any_value_is_the_same_as_its_copy(raw):
    assert is_same(raw, copy.deepcopy(raw))
