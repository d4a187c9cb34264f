"""Tests of checks of parameter declarations at their definition."""

from typing import Any, Dict

import pytest

from nodekit.parameters.declaration import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterSet,
    StringParameter,
    read_once,
    rule,
)
from nodekit.parameters.declaration_checks import check_rules

SHARED = IntParameter(1, help="")


def read(**members: Any) -> type:
    """Read a class with these members."""
    return type("Mine", (ParameterSet,), members)


async def check(_self: object) -> None:
    """Never run."""


@pytest.mark.parametrize(
    "members, error, text",
    [
        ({"a": IntParameter}, TypeError, r"Mine\.a: brackets missing: write IntParameter\("),
        ({"a": 5}, TypeError, r"Mine\.a = 5: not a parameter"),
        ({"a": None}, TypeError, r"Mine\.a = None: not a parameter"),
        ({"__annotations__": {"a": int}}, TypeError, r"Mine\.a: an annotation is not enough"),
        ({"\u00e4": IntParameter(1, help="")}, ValueError, "Mine\\.\u00e4: must be a letter"),
        ({"_a": IntParameter(1, help="")}, ValueError, r"Mine\._a: must be a letter"),
        ({"managed": BoolParameter(True, help="")}, TypeError, "every node has a parameter"),
        ({"a": SHARED, "b": SHARED}, TypeError, r"Mine\.b: is the same object as a"),
        ({"a": SHARED, "check": rule("a")(check)}, TypeError, r"Mine\.check: .* async def"),
        ({"a": IntParameter("5", help="")}, ParameterError, r"Mine/a: refused '5': .*\(text\)"),
        ({"a": FloatParameter("1e3", help="")}, ParameterError, "Mine/a: refused '1e3'"),
        ({"a": FloatParameter(-1.0, minimum=0.0, help="")}, ParameterError, "a: refused -1"),
        ({"a": EnumParameter("a", choices=(), help="")}, ParameterError, "a: refused 'a'"),
        (
            {"a": ListParameter(["5"], element=IntParameter(0, help=""), help="")},
            ParameterError,
            r"Mine/a: refused \['5'\]",
        ),
    ],
)
def test_ignored_or_hidden_members_are_refused(
    members: Dict[str, Any], error: type, text: str
) -> None:
    with pytest.raises(error, match=text):
        read(**members)


@pytest.mark.parametrize("kind", [IntParameter, FloatParameter])
@pytest.mark.parametrize("step", [-1.0, 0, float("nan"), float("inf"), True, "1"])
def test_a_step_is_a_number_above_0(kind: Any, step: Any) -> None:
    with pytest.raises(ValueError, match="step: refused .*: must be a number above 0"):
        kind(1, step=step, help="")


@pytest.mark.parametrize("name", ["minimum", "maximum", "above", "below"])
@pytest.mark.parametrize("bound", [float("nan"), "1", True])
def test_a_bound_is_a_number(name: str, bound: Any) -> None:
    with pytest.raises(ValueError, match=f"{name}: refused .*: must be a number"):
        FloatParameter(1.0, help="", **{name: bound})


@pytest.mark.parametrize("choices", ["red", [1, 2], ["a\r"]])
def test_choices_are_a_list_of_words(choices: Any) -> None:
    with pytest.raises(TypeError, match="choices: refused"):
        EnumParameter("r", choices=choices, help="")


def test_brackets_are_needed_inside_too() -> None:
    with pytest.raises(TypeError, match="element: refused"):
        ListParameter([], element=IntParameter, help="")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="read_once: refused"):
        read_once(IntParameter)  # type: ignore[type-var]
    assert not IntParameter(1, help="").read_once


class Gauge(ParameterSet):
    """Two parameters to be inherited."""

    level = FloatParameter(1.0, help="")
    is_on = BoolParameter(False, help="")


class Mixin:
    """No class of parameters, but it has a value of that name."""

    is_on = True


@pytest.mark.parametrize("value", [True, None, lambda self: True, FloatParameter])
def test_an_inherited_parameter_is_not_hidden_in_silence(value: Any) -> None:
    with pytest.raises(TypeError, match=r"^Mine\.is_on\b"):
        type("Mine", (Gauge,), {"is_on": value})


def test_hidden_parameter_is_named_with_remedies() -> None:
    with pytest.raises(TypeError) as caught:

        class Mine(Mixin, Gauge):
            """The first base class hides a parameter of the second."""

    assert str(caught.value) == (
        "Mine.is_on = True: hides a parameter: write BoolParameter(…) for another default,"
        " or property(lambda self: …) to remove it"
    )


def test_property_removes_an_inherited_parameter() -> None:
    class Without(Gauge):
        """Always on."""

        is_on = property(lambda self: True)

    class Still(Without):
        """A parameter that a base class has removed stays removed."""

    for cls in (Without, Still):
        assert list(cls.declared) == ["level"]
        assert cls(level=2.0).replace(level=3.0).is_on is True
        with pytest.raises(TypeError, match="undeclared parameters: is_on"):
            cls(is_on=False)

    class Again(Without):
        """It is declared once more."""

        is_on = BoolParameter(True, help="")

    assert Again(is_on=False).is_on is False


def test_invalid_rule_is_refused() -> None:
    @rule("other")
    def strange(values: ParameterSet) -> None:
        """Define a rule about something else."""

    for method, why in ((print, "must be marked by @rule"), (strange, "undeclared .*: other")):
        with pytest.raises(TypeError, match=f"Gauge: .*{why}"):
            check_rules("Gauge", [method], ["level"])


def test_valid_class_members_are_accepted() -> None:
    class Rich(ParameterSet):
        """All that a class may have beside its parameters."""

        _MOST = 5
        gain: FloatParameter = FloatParameter(2, help="a whole number is a number")
        names = ListParameter(["5"], element=StringParameter("", help=""), help="text is text")

        class Inner:
            """A separate class."""

        @property
        def double(self) -> float:
            """Twice the gain."""
            return 2.0 * self.gain

        @staticmethod
        def helper() -> int:
            """Help."""
            return 1

        @rule("gain")
        def small(self) -> None:
            """Keep it small."""
            if self.gain > self._MOST:
                raise ValueError("gain must be at most 5")

    assert (Rich().double, Rich.helper(), Rich().names) == (4.0, 1, ("5",))


def test_a_parameter_that_a_class_takes_over_from_another_keeps_its_default() -> None:
    one, other = read(a=SHARED), read(a=SHARED)
    assert one().a == other().a == 1  # type: ignore[attr-defined]
