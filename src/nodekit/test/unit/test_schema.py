"""Tests of descriptions of parameters: readable, and exact enough to validate values."""

import copy
import functools
import json
import math
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from nodekit.commands.parameter_table import as_table
from nodekit.parameters.declaration import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    Parameter,
    ParameterError,
    ParameterSet,
    RateParameter,
    StringParameter,
    read_once,
)
from nodekit.parameters.schema import (
    DescriptionError,
    as_yaml,
    describe,
    description_in,
    parameter_of,
)


class FileParameter(StringParameter):
    """Parameter with a check that its schema cannot express."""

    def coerce(self, raw: Any) -> str:
        if raw == "missing":
            raise self.refuse(raw)
        return super().coerce(raw)


class Gauge(ParameterSet):
    """A parameter of every type, and every type of limit."""

    angle = FloatParameter(
        0.1, minimum=-2 * math.pi, below=1 / 3, unit="rad", help="an angle: from -2 pi"
    )
    level = FloatParameter(0.25, above=0.0, maximum=1e10, step=0.25, help="a level")
    free = FloatParameter(0.1 + 0.2, help="any number")
    count = IntParameter(3, minimum=0, help="a count")
    even = IntParameter(4, above=0, below=100, step=2, help="counted in steps")
    rate = RateParameter(10.0, help="a rate")
    on = BoolParameter(False, help="a switch")
    title = StringParameter("gauge", help="a title")
    shape = EnumParameter("a, b", choices=("a, b", "on", "1e3", "}", "\u00e5"), help="a shape")
    marks = ListParameter(
        [1.0],
        element=FloatParameter(-1.0, above=0.1, unit="V", help=""),
        max_length=3,
        help="marks",
    )
    words = ListParameter(
        ["x, y"], element=EnumParameter("", choices=("x, y", "z"), help=""), min_length=1, help=""
    )
    file = FileParameter("", help="a file")
    files = ListParameter([], element=FileParameter("", help=""), help="files")


class Port(ParameterSet):
    """Parameters of which one is read once."""

    device = read_once(StringParameter("/dev/motor", help="the port"))
    gain = FloatParameter(1.0, help="a gain")


def test_read_once_parameter_states_when_a_change_takes_effect() -> None:
    assert Port(device="/dev/other").device == "/dev/other"
    when = "at the next configure"
    for description, expected in (
        (describe(Port()), "at the next start"),
        (describe(Port(), when), when),
    ):
        device, gain = yaml.safe_load(as_yaml(description))
        assert device["takes_effect"] == expected
        assert device["help"] == f"the port; takes effect {expected}"
        assert (gain["takes_effect"], gain["help"]) == ("at once", "a gain")
        first, second = as_table(description, 80).splitlines()
        assert first.endswith(f"  the port; takes effect {expected}")
        assert second.endswith("  a gain")


@functools.lru_cache(maxsize=None)  # YAML takes its time, and a hundred examples ask
def described() -> Any:
    """Return all entries as a client gets them."""
    return yaml.safe_load(as_yaml(describe(Gauge())))


def entry(name: str) -> Any:
    """Return an entry as a client gets it."""
    return next(copy.deepcopy(one) for one in described() if one["name"] == name)


def test_entry_has_the_declaration_and_the_value_in_force() -> None:
    first = describe(Gauge(angle=-6.25))[0]
    assert first == {
        "name": "angle",
        "value": -6.25,
        "type": "float",
        "unit": "rad",
        "range": "[-6.28318530718, 0.333333333333)",
        "default": 0.1,
        "help": "an angle: from -2 pi",
        "takes_effect": "at once",
        "minimum": -2 * math.pi,
        "below": 1 / 3,
        "exact": True,
    }
    assert [one["name"] for one in describe(Gauge())] == list(Gauge.declared)


LIMITS = {"minimum", "maximum", "above", "below", "step", "choices", "min_length", "max_length"}


@pytest.mark.parametrize(
    "name, limits",
    [
        ("level", {"above": 0.0, "maximum": 1e10, "step": 0.25}),
        ("free", {}),
        ("count", {"minimum": 0, "maximum": 2**31 - 1}),
        ("even", {"above": 0, "below": 100, "step": 2}),
        ("rate", {"minimum": 1e-6, "maximum": 10000.0}),
        ("on", {}),
        ("title", {}),
        ("shape", {"choices": ["a, b", "on", "1e3", "}", "\u00e5"]}),
        ("marks", {"min_length": 0, "max_length": 3}),
        ("file", {}),
    ],
)
def test_limits_are_exact_and_listed_only_if_declared(name: str, limits: Any) -> None:
    described = entry(name)
    assert {key: described[key] for key in LIMITS & described.keys()} == limits


def test_infinite_limit_is_omitted() -> None:
    class Endless(ParameterSet):
        """Goes on for ever."""

        up = FloatParameter(1.0, minimum=0.0, maximum=math.inf, help="")
        down = FloatParameter(1.0, minimum=-math.inf, maximum=9.0, help="")

    up, down = describe(Endless())
    assert (LIMITS & up.keys(), LIMITS & down.keys()) == ({"minimum"}, {"maximum"})


def test_an_element_is_described_as_its_list_is() -> None:
    assert entry("marks")["element"] == {
        "type": "float",
        "unit": "V",
        "range": "(0.1, inf)",
        "above": 0.1,
        "exact": True,
    }
    assert entry("words")["element"]["choices"] == ["x, y", "z"]


def test_parameter_with_further_checks_is_not_exact() -> None:
    inexact = [one["name"] for one in describe(Gauge()) if not one["exact"]]
    assert inexact == ["file", "files"]


RAW = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(-5, 105)
    | st.floats()
    | st.floats(-7.0, 1.0)
    | st.sampled_from(["a, b", "on", "1e3", "0.75", "\u00e5", "gauge", -2 * math.pi, 1 / 3, 0.75])
)
RAW |= st.lists(RAW | st.sampled_from(["x, y", "z", 0.1]), max_size=4)


def outcome(parameter: Parameter[Any], raw: Any) -> Any:
    try:
        value = parameter.coerce(raw)
    except ParameterError as error:
        return str(error)
    return value, type(value)


@given(st.sampled_from([one["name"] for one in describe(Gauge()) if one["exact"]]), RAW)
def test_client_validates_like_the_node(name: str, raw: Any) -> None:
    assert outcome(parameter_of(entry(name)), raw) == outcome(Gauge.declared[name], raw)


@given(*[st.floats(allow_nan=False, allow_infinity=False)] * 2)
def test_numbers_round_trip(one: float, other: float) -> None:
    ends = {"minimum": min(one, other), "maximum": max(one, other)}

    class Bounded(ParameterSet):
        """One parameter between any two numbers."""

        gauge = FloatParameter(min(one, other), step=abs(other) or 1.0, help="any", **ends)

    described = describe(Bounded.from_coerced({"gauge": other}))
    for restored in (yaml.safe_load(as_yaml(described)), json.loads(json.dumps(described))):
        assert restored == described
        assert vars(parameter_of(restored[0])) == vars(Bounded.gauge)


def test_client_validates_inexact_parameter_less_strictly() -> None:
    assert parameter_of(entry("file")).coerce("missing") == "missing"
    assert parameter_of(entry("files")).coerce(["missing"]) == ("missing",)


@pytest.mark.parametrize(
    "change",
    [
        {"type": "complex"},
        {"type": None},
        {"type": ["int"]},
        {"type": "bool", "minimum": 1},
        {"minimum": "low"},
        {"minimum": True},
        {"maximum": None},
        {"maximum": math.inf},
        {"maximum": math.nan},
        {"type": "enum"},
        {"type": "enum", "choices": 5},
        {"type": "list"},
        {"type": "list", "element": "float"},
        {"type": "list", "element": {"type": "complex"}},
        {"type": "list", "default": 5, "element": {"type": "int"}},
    ],
)
def test_an_entry_that_makes_no_sense_is_refused(change: Any) -> None:
    good = {"name": "a", "type": "int", "unit": "", "default": 3, "help": "", "minimum": 0}
    assert parameter_of(good).coerce(5) == 5
    if "type" in change:
        del good["minimum"]
    with pytest.raises(ValueError):
        parameter_of({**good, **change})


def test_yaml_is_readable() -> None:
    lines = as_yaml(describe(Gauge())).split("\n")
    assert lines[:3] == ["- name: angle", "  value: 0.1", "  type: float"]
    assert "  - \u00e5" in lines


def test_a_table_has_a_row_for_each_parameter() -> None:
    lines = as_table(describe(Gauge()), 200).split("\n")
    rows = [line for line in lines if "= " in line]
    assert len(rows) == len(Gauge.declared)
    assert rows[1].split() == "level = 0.25 float (0, 1e+10] step 0.25 a level".split()
    marks = rows[list(Gauge.declared).index("marks")]
    assert marks.split() == "marks = [1.0] list 0 to 3 of (0.1, inf) marks".split()
    assert len({row.index("= ") for row in rows}) == 1
    assert as_table([], 80) == ""


WAVES = tuple(f"{letter}_wave" for letter in "abcdefghijklmnopqrstuvwxyz")


class Generator(ParameterSet):
    """A long list of choices between short parameters."""

    rate = FloatParameter(10.0, minimum=0.0, maximum=1e4, unit="Hz", help="samples per second")
    wave = EnumParameter("a_wave", choices=WAVES, help="its form, which may change while it runs")
    gain = FloatParameter(1.0, help="how much " * 12)


def test_a_long_list_of_choices_sets_no_width() -> None:
    lines = as_table(describe(Generator()), 80).split("\n")
    assert max(map(len, lines)) <= 80
    rate, wave, gain = (
        next(number for number, line in enumerate(lines) if line.startswith(f"  {name} "))
        for name in Generator.declared
    )
    first = lines[rate]
    assert first.split() == "rate = 10.0 float [0, 10000] Hz samples per second".split()
    # Continued text is in its own column.
    second, third = first.index("float"), first.index("samples")
    assert all(line[:second].strip() == "" for line in lines[wave + 1 : gain])
    told = " ".join(line[second:third] for line in lines[wave:gain])
    assert told.split() == ("enum {" + ", ".join(WAVES) + "}").split()
    helped = " ".join(line[third:] for line in lines[gain:])
    assert helped.split() == ["how", "much"] * 12


def test_long_help_is_on_the_next_line() -> None:
    lines = as_table(describe(Generator()), 50).split("\n")
    assert max(map(len, lines)) <= 50
    assert lines[0].split() == "rate = 10.0 float [0, 10000] Hz".split()
    assert lines[1] == "      samples per second"
    assert lines[2].startswith("  wave  = a_wave  enum {")


@pytest.mark.parametrize("width", [20, 62, 66, 80, 120, 1000])
def test_a_table_says_the_same_in_any_width(width: int) -> None:
    def signs(text: str) -> str:
        return "".join(sorted(text.replace(" ", "").replace("\n", "")))

    for values in (Gauge(), Generator()):
        wide, table = as_table(describe(values), 10000), as_table(describe(values), width)
        assert signs(table) == signs(wide)
        # The longest name, the widest value and type, and the separators.
        least = max(map(len, values.declared)) + 2 * 24 + 3 * 2 + 2
        assert max(map(len, table.split("\n"))) <= max(width, least)


def test_a_table_shows_values_whole() -> None:
    class Long(ParameterSet):
        text = StringParameter("one\ntwo", help="")
        numbers = ListParameter([1.5] * 40, element=FloatParameter(0.0, help=""), help="")

    text, *numbers = as_table(describe(Long()), 1000).split("\n")
    assert text.split() == ["text", "=", '"one\\ntwo"', "str"]
    assert " ".join(numbers).count("1.5") == 40


def test_a_description_is_read_as_it_was_sent() -> None:
    class Gauge(ParameterSet):
        level = FloatParameter(0.1, above=0.0, unit="V", help="ä")

    description = describe(Gauge())
    assert description_in(as_yaml(description)) == description
    assert description_in("[]") == []


@pytest.mark.parametrize(
    "text",
    ["", "{", "all is well", "a: 1", "[1]", "[{name: a}]", "[" * 5000]
    + ["[!!python/object/new:os.system [id]]", "[{name: a, type: int}]"],
)
def test_malformed_description_is_refused(text: str) -> None:
    with pytest.raises(DescriptionError, match="the description"):
        description_in(text)
