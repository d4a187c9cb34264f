"""Tests of declared parameters: immutable snapshots, rules across parameters, inheritance."""

import pytest

from nodekit.parameters.declaration import (
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterErrors,
    ParameterSet,
    RuleError,
    rule,
)


class Limits(ParameterSet):
    """Two values with a rule, and one without."""

    low = FloatParameter(0.0, unit="V", help="lower limit")
    high = FloatParameter(1.0, unit="V", help="upper limit")
    count = IntParameter(3, minimum=0, maximum=9, help="how many")

    @rule("low", "high")
    def ordered(self) -> None:
        """Keep the limits in order."""
        if self.low > self.high:
            raise ValueError("low must be at most high")


class Tones(ParameterSet):
    """A list and a choice."""

    shape = EnumParameter("sine", choices=("sine", "square"), help="shape")
    gains = ListParameter([1, 2], element=FloatParameter(0.0, help=""), unit="V", help="gains")


def test_defaults_are_used_for_omitted_arguments():
    assert Limits().as_dict() == {"low": 0.0, "high": 1.0, "count": 3}
    assert list(Limits().as_dict()) == ["low", "high", "count"]


def test_values_are_coerced():
    limits = Limits(low="-1e1", high=5, count=4.0)
    assert limits.as_dict() == {"low": -10.0, "high": 5.0, "count": 4}
    assert (limits.low, type(limits.high), type(limits.count)) == (-10.0, float, int)


def test_values_that_are_not_allowed_are_refused_by_name():
    with pytest.raises(ParameterError, match="count: refused 10: must be"):
        Limits(count=10)


def test_the_same_declaration_may_have_other_defaults():
    other = Limits.with_defaults(high="7", count=4)
    assert other().as_dict() == {"low": 0.0, "high": 7.0, "count": 4}
    assert list(other.declared) == list(Limits.declared)
    assert isinstance(other(), Limits) and other.__name__ == "Limits"
    assert Limits().count == 3
    with pytest.raises(RuleError, match="low must be at most high"):
        other(low=8.0)
    with pytest.raises(RuleError, match="low must be at most high"):
        Limits.with_defaults(low=2.0)
    with pytest.raises(ParameterError, match="count: refused 10"):
        Limits.with_defaults(count=10)
    with pytest.raises(TypeError, match="hihg"):
        Limits.with_defaults(hihg=2.0)


def test_defaults_share_one_snapshot():
    assert Limits.as_declared() is Limits.as_declared() == Limits()
    other = Limits.with_defaults(count=4)  # derived from the first, which has a snapshot already
    assert other.as_declared() is other.as_declared() == other()


def test_undeclared_names_are_a_programming_error():
    with pytest.raises(TypeError, match="hihg"):
        Limits(hihg=2.0)


def test_a_snapshot_does_not_change():
    limits = Limits()
    with pytest.raises(AttributeError):
        limits.low = 0.5
    with pytest.raises(AttributeError):
        limits.unheard_of = 0.5
    with pytest.raises(AttributeError):
        del limits.low
    limits.as_dict()["low"] = 0.5
    assert limits == Limits()
    assert isinstance(Tones(gains=[3, 4]).gains, tuple)


def test_a_list_given_to_a_snapshot_may_change_afterwards():
    gains = [3.0, 4.0]
    tones = Tones(gains=gains)
    gains.append(5.0)
    assert tones.gains == (3.0, 4.0)


def test_replace_returns_another_snapshot():
    old = Limits(low=0.25)
    new = old.replace(high="2", count=1)
    assert new == Limits(low=0.25, high=2.0, count=1)
    assert old == Limits(low=0.25)
    with pytest.raises(ParameterError):
        old.replace(count=-1)
    with pytest.raises(RuleError):
        old.replace(high=0.1)


def test_snapshots_are_equal_by_type_and_values():
    class Other(Limits):
        """The same parameters under another name."""

    assert Limits(low=0.5) == Limits(low=0.5)
    assert hash(Tones()) == hash(Tones(gains=[1.0, 2.0]))
    assert Limits() != Limits(count=4)
    assert Limits() != Other()
    assert Limits() != Limits().as_dict()


def test_a_snapshot_shows_its_values():
    assert repr(Limits(low=0.5)) == "Limits(low=0.5, high=1, count=3)"


def test_rule_names_parameters_values_and_condition():
    with pytest.raises(RuleError) as caught:
        Limits(low=3.0, high=2.5)
    error = caught.value
    assert error.names == ("low", "high")
    assert str(error) == "parameters low, high: refused 3, 2.5: low must be at most high"
    assert str(error.in_namespace("/n")).startswith("parameters /n/low, /n/high: refused 3, 2.5: ")
    assert error.in_namespace("/n").names == ("/n/low", "/n/high")
    assert str(RuleError(["count"], [4], "count must be odd")).startswith("parameter count: ")


def test_several_errors_have_one_line_each():
    limits = [ParameterError("count", 10, "small"), RuleError(["a", "b"], [1, 2], "a must be b")]
    both = ParameterErrors(limits)
    assert both.names == ("count", "a", "b")
    assert str(both.in_namespace("/n")) == (
        "parameter /n/count: refused 10: must be small; "
        "parameters /n/a, /n/b: refused 1, 2: a must be b"
    )


@pytest.mark.parametrize("name", ["replace", "rules", "declared", "as_dict", "broken_rule"])
def test_parameter_with_a_taken_name_is_refused_immediately(name):
    with pytest.raises(TypeError, match=name):
        type("Taken", (ParameterSet,), {name: IntParameter(1, help="")})


@pytest.mark.parametrize("names", [["hihg"], ["low", "hihg"], ["ordered"]])
def test_rule_about_an_undeclared_parameter_is_refused_immediately(names):
    with pytest.raises(TypeError, match=names[-1]):
        type("Misspelt", (Limits,), {"misspelt": rule(*names)(lambda self: None)})


def test_rule_about_a_parameter_removed_by_a_subclass_is_refused():
    with pytest.raises(TypeError, match="high"):
        type("Less", (Limits,), {"high": 5.0})


def test_rule_without_parameters_is_refused_immediately():
    with pytest.raises(TypeError, match="@rule"):
        rule()
    with pytest.raises(TypeError, match="@rule"):

        @rule
        def forgotten(self):
            """Lacks its names."""


def test_broken_rule_checks_only_rules_of_given_names():
    broken = Limits.from_coerced({"low": 2.0, "high": 1.0, "count": 3})
    assert broken.broken_rule(["count"]) is None
    assert broken.broken_rule([]) is None
    assert broken.broken_rule(["high"]).names == ("low", "high")


def test_defaults_must_keep_the_rules_themselves():
    class Crossed(Limits):
        """The rule of the base holds for defaults of the subclass."""

        low = FloatParameter(2.0, help="above the upper limit")

    with pytest.raises(RuleError):
        Crossed()


def test_subclass_adds_and_redeclares_and_leaves_the_base_alone():
    class More(Limits):
        """One more parameter, one with another default."""

        count = IntParameter(5, help="how many")
        gain = FloatParameter(2.0, help="gain")

    assert More().as_dict() == {"low": 0.0, "high": 1.0, "count": 5, "gain": 2.0}
    assert More(count=100).count == 100
    assert set(Limits.declared) == {"low", "high", "count"}
    with pytest.raises(RuleError):
        More(low=3.0)
    with pytest.raises(TypeError):
        Limits(gain=1.0)


def test_subclass_adds_rules_and_replaces_those_it_overrides():
    class Strict(Limits):
        """Another rule, and a stricter one under the name of the base's."""

        @rule("low", "high")
        def ordered(self) -> None:
            """Replace the rule of the base."""
            if self.low + 1.0 > self.high:
                raise ValueError("low + 1 must be at most high")

        @rule("count")
        def odd(self) -> None:
            """Is a rule about one parameter."""
            if self.count % 2 == 0:
                raise ValueError("count must be odd")

    assert Strict(low=0.0, high=1.0).high == 1.0
    with pytest.raises(RuleError, match=r"low \+ 1 must be"):
        Strict(low=3.0, high=2.0)
    with pytest.raises(RuleError, match="odd"):
        Strict(count=4)
    assert Limits(low=0.5, count=4).count == 4


def test_a_set_may_be_put_together_from_several():
    class Both(Limits, Tones):
        """All parameters and rules of two sets."""

    assert set(Both().as_dict()) == {"low", "high", "count", "shape", "gains"}
    assert Both(shape="square", high=4).high == 4.0
    with pytest.raises(RuleError):
        Both(low=4.0)
    with pytest.raises(ParameterError):
        Both(shape="circle")


def test_parameters_are_reached_on_the_class_for_documentation():
    assert Limits.low.unit == "V"
    assert Limits.count.range == "[0, 9]"
