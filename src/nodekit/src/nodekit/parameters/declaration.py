"""Declare a node's parameters once: kind, default, unit, range and help.

A node lists its parameters as class attributes of a :class:`ParameterSet`::

    class BlinkerParameters(ParameterSet):
        rate = FloatParameter(1.0, above=0.0, maximum=100.0, unit="Hz", help="blinks a second")
        colour = EnumParameter("red", choices=("red", "green"), help="colour of the lamp")

An instance is an immutable snapshot of values that passed validation, so a
callback that holds one never sees half of a change. This module knows nothing
of ROS; :mod:`nodekit.live.live_parameters` keeps a set in step with the
parameter server.
"""

from typing import (
    Any,
    Callable,
    ClassVar,
    Collection,
    Dict,
    List,
    Mapping,
    Optional,
    Tuple,
    Type,
    TypeVar,
)

from nodekit.parameters.kinds import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    Parameter,
    ParameterError,
    StringParameter,
    shown,
    to_wire,
)

__all__ = [
    "BoolParameter",
    "EnumParameter",
    "FloatParameter",
    "IntParameter",
    "ListParameter",
    "Parameter",
    "ParameterError",
    "ParameterSet",
    "RuleError",
    "StringParameter",
    "describe",
    "rule",
    "shown",
    "to_wire",
]

Snapshot = TypeVar("Snapshot", bound="ParameterSet")
Rule = Callable[[Any], None]


def rule(*names: str) -> Callable[[Rule], Rule]:
    """Mark a method of a :class:`ParameterSet` as a rule across parameters.

    The method raises :class:`ValueError` with the allowed combination, worded
    to follow "allowed is", where the values do not go together.

    :param names: the parameters that the rule is about
    :returns: the decorator
    """

    def mark(method: Rule) -> Rule:
        setattr(method, "parameters", names)
        return method

    return mark


class RuleError(ParameterError):
    """Values that are each allowed but do not go together.

    :param names: names of the parameters
    :param values: their values, in the same order
    :param allowed: the allowed combination, worded to follow "allowed is"
    """

    def __init__(self, names: Tuple[str, ...], values: List[Any], allowed: str) -> None:
        super().__init__(", ".join(names), values, allowed)
        self.names = names


class ParameterSet:
    """A snapshot of validated values; subclasses declare the parameters.

    :param values: values by name; the default stands where one is left out
    :raises ParameterError: if a value or a combination is not allowed
    :raises TypeError: if a name is not declared
    """

    declared: ClassVar[Dict[str, Parameter[Any]]] = {}
    rules: ClassVar[List[Rule]] = []

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        members: Dict[str, Any] = {}
        for base in reversed(cls.__mro__):
            members.update(vars(base))
        cls.declared = {key: item for key, item in members.items() if isinstance(item, Parameter)}
        cls.rules = [item for item in members.values() if hasattr(item, "parameters")]

    def __init__(self, **values: Any) -> None:
        unknown = sorted(set(values) - set(self.declared))
        if unknown:
            raise TypeError("undeclared parameters: " + ", ".join(unknown))
        for name, parameter in self.declared.items():
            self.__dict__[name] = (
                parameter.coerce(values[name]) if name in values else parameter.default
            )
        broken = self.broken_rule(self.declared)
        if broken is not None:
            raise broken

    @classmethod
    def unjudged(cls: Type[Snapshot], values: Mapping[str, Any]) -> Snapshot:
        """Return a snapshot of coerced values that no rule has judged yet.

        :param values: one coerced value for each declared name
        """
        snapshot = cls.__new__(cls)
        snapshot.__dict__.update(values)
        return snapshot

    def broken_rule(self, names: Collection[str]) -> Optional[RuleError]:
        """Return the error of the first broken rule, None if all are kept.

        :param names: judge by the rules that are about one of these parameters
        """
        for method in self.rules:
            about: Tuple[str, ...] = getattr(method, "parameters")
            if not set(about).isdisjoint(names):
                try:
                    method(self)
                except ValueError as error:
                    return RuleError(about, [self.__dict__[key] for key in about], str(error))
        return None

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a snapshot does not change: use replace()")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a snapshot does not change: use replace()")

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.items()))

    def __repr__(self) -> str:
        settings = ", ".join("%s=%s" % (k, shown(v)) for k, v in self.__dict__.items())
        return "%s(%s)" % (type(self).__name__, settings)

    def as_dict(self) -> Dict[str, Any]:
        """Return the values by name, in the order of declaration."""
        return dict(self.__dict__)

    def replace(self: Snapshot, **changes: Any) -> Snapshot:
        """Return a snapshot with some values changed.

        :param changes: new values by name
        :raises ParameterError: if a value or a combination is not allowed
        """
        return type(self)(**{**self.__dict__, **changes})


def describe(values: ParameterSet) -> List[Dict[str, Any]]:
    """Describe each parameter of a set with its value in force.

    :param values: the snapshot to describe
    :returns: for each parameter its name, value, type, unit, range, default and help
    """
    return [
        {
            "name": name,
            "value": to_wire(values.__dict__[name]),
            "type": parameter.type_name,
            "unit": parameter.unit,
            "range": parameter.range,
            "default": to_wire(parameter.default),
            "help": parameter.help,
        }
        for name, parameter in values.declared.items()
    ]
