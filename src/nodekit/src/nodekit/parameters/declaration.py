"""Declaration of a node's parameters: type, default, unit, range and help.

A node lists its parameters as class attributes of a :class:`ParameterSet`::

    class BlinkerParameters(ParameterSet):
        rate = FloatParameter(1.0, above=0.0, maximum=100.0, unit="Hz", help="blinks a second")
        colour = EnumParameter("red", choices=("red", "green"), help="colour of the lamp")

An instance is an immutable snapshot of values that passed validation, so a
callback that holds one never sees half of a change. This module does not depend
on ROS; :mod:`nodekit.parameter_server.live_parameters` keeps a set in step with the
parameter server.
"""

import copy
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

from nodekit.parameters.declaration_checks import check_members, check_rules, checked_default
from nodekit.parameters.errors import ParameterErrors, RuleError
from nodekit.parameters.numeric_types import FloatParameter, IntParameter, RateParameter
from nodekit.parameters.parameter_types import (
    BoolParameter,
    EnumParameter,
    ListParameter,
    Parameter,
    ParameterError,
    StringParameter,
    format_value,
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
    "ParameterErrors",
    "ParameterSet",
    "RateParameter",
    "RuleError",
    "StringParameter",
    "format_value",
    "read_once",
    "rule",
    "to_wire",
]

Snapshot = TypeVar("Snapshot", bound="ParameterSet")
Rule = Callable[[Any], None]
Method = TypeVar("Method", bound=Callable[..., None])
Kind = TypeVar("Kind", bound=Parameter[Any])

#: Names that no class may declare; see :class:`OwnParameters`.
_of_every_node: Collection[str] = ()


def read_once(parameter: Kind) -> Kind:
    """Mark a parameter that a node reads only when it is created.

    A change is validated like any other, and takes effect at the next start or, for objects that a
    managed node creates, at the next configure or activate. Descriptions show that.

    :param parameter: the parameter
    :returns: the same parameter
    :raises TypeError: if the argument is not a parameter
    """
    if not isinstance(parameter, Parameter):
        raise TypeError(f"read_once: refused {parameter!r:.80}: must be a parameter")
    parameter.read_once = True
    return parameter


def rule(*names: str) -> Callable[[Method], Method]:
    """Mark a method of a :class:`ParameterSet` as a rule across parameters.

    A method of the node's class, passed to :meth:`.NodeScope.declare_parameters`, may be a rule
    too: it is called with the snapshot, for rules that need the node, such as those about names.
    It must be quick, make no request and take no lock: the lock of the parameters is held.

    If the values are inconsistent, the method raises :class:`ValueError`
    with the condition as a clause, such as "low must be at most high":
    it follows the names and the rejected values in the message.

    :param names: the parameters of the rule
    :returns: the decorator
    :raises TypeError: if no names are given
    """
    if not names or not all(isinstance(name, str) for name in names):
        raise TypeError("rule: names of its parameters missing; write @rule('low', 'high')")

    def mark(method: Method) -> Method:
        setattr(method, "parameters", names)
        return method

    return mark


class ParameterSet:
    """Snapshot of validated values; subclasses declare the parameters.

    :param values: values by name; defaults for missing names
    :raises ParameterError: if a value or a combination is not allowed
    :raises TypeError: if a name is not declared
    """

    declared: ClassVar[Dict[str, Parameter[Any]]] = {}
    rules: ClassVar[List[Rule]] = []
    _as_declared: ClassVar[Any] = None

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        check_members(cls, dir(ParameterSet), _of_every_node)
        members: Dict[str, Any] = {}
        for base in reversed(cls.__mro__):
            members.update(vars(base))
        cls.declared = {key: item for key, item in members.items() if isinstance(item, Parameter)}
        for parameter in cls.declared.values():
            parameter.default = checked_default(cls.__name__, parameter)
        cls.rules = [item for item in members.values() if hasattr(item, "parameters")]
        check_rules(cls.__name__, cls.rules, cls.declared)

    def __init__(self, **values: Any) -> None:
        unknown = sorted(set(values) - set(self.declared))
        if unknown:
            raise TypeError("undeclared parameters: " + ", ".join(unknown))
        for name, parameter in self.declared.items():
            self.__dict__[name] = (
                parameter.accept(values[name]) if name in values else parameter.default
            )
        broken = self.broken_rule(self.declared)
        if broken is not None:
            raise broken

    @classmethod
    def from_coerced(cls: Type[Snapshot], values: Mapping[str, Any]) -> Snapshot:
        """Return a snapshot of coerced values that no rule has validated yet.

        :param values: one coerced value for each declared name
        """
        snapshot = cls.__new__(cls)
        snapshot.__dict__.update(values)
        return snapshot

    @classmethod
    def as_declared(cls: Type[Snapshot]) -> Snapshot:
        """Return the snapshot of all defaults, shared by all nodes that use it.

        No rule has validated it yet: if one rejects the defaults, a value must be set.
        """
        if type(cls._as_declared) is not cls:  # may be the base class's snapshot
            defaults = {name: item.default for name, item in cls.declared.items()}
            cls._as_declared = cls.from_coerced(defaults)
        snapshot: Snapshot = cls._as_declared
        return snapshot

    @classmethod
    def with_defaults(cls: Type[Snapshot], **defaults: Any) -> Type[Snapshot]:
        """Return the same declaration with other defaults, for hosted nodes.

        :param defaults: by name
        :raises ParameterError: if a default is not allowed
        :raises TypeError: if a name is not declared
        """
        validated = cls(**defaults)
        members = {}
        for name in defaults:
            members[name] = copy.copy(cls.declared[name])
            members[name].default = validated.__dict__[name]
        return type(cls.__name__, (cls,), members)

    def broken_rule(
        self, names: Collection[str], more: Collection[Rule] = ()
    ) -> Optional[RuleError]:
        """Return the error of the first broken rule, None if all rules hold.

        :param names: parameters whose rules are checked
        :param more: rules in addition to those of the class
        """
        for method in (*self.rules, *more):
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
        settings = ", ".join(f"{k}={format_value(v)}" for k, v in self.__dict__.items())
        return f"{type(self).__name__}({settings})"

    def as_dict(self) -> Dict[str, Any]:
        """Return the values by name, in the order of declaration."""
        return dict(self.__dict__)

    def replace(self: Snapshot, **changes: Any) -> Snapshot:
        """Return a snapshot with some values changed.

        :param changes: new values by name
        :raises ParameterError: if a value or a combination is not allowed
        """
        return type(self)(**{**self.__dict__, **changes})


class OwnParameters(ParameterSet):
    """Private parameters of every node; read once, before its class is instantiated."""

    managed = BoolParameter(False, help="wait until others configure and activate the node")
    transport = EnumParameter(
        "auto",
        choices=("auto", "tcp"),
        help="how the process sends and receives large messages: by shared memory where it can, or "
        "by TCP only",
    )


_of_every_node = OwnParameters.declared
