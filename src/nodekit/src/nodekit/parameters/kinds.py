"""The kinds of parameter a node can declare, and what each of them takes.

Coercion follows what users of ``rosparam`` expect: an integer serves as a
float, and so does text such as ``1e3``, which YAML does not read as a number;
a truth value is never a number, and nothing that is not finite gets through.
"""

import math
import numbers
from typing import Any, ClassVar, Generic, Optional, Sequence, Tuple, TypeVar, Union, overload

#: XML-RPC, and so the parameter server, carries integers of 32 bits.
INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1

Value = TypeVar("Value")


class ParameterError(ValueError):
    """A value that a parameter does not allow.

    :param name: name of the parameter, resolved or as declared
    :param value: the value that was refused, as it came
    :param allowed: what is allowed, worded to follow "allowed is"
    :param reason: more about this value, where what is allowed does not say it
    """

    def __init__(self, name: str, value: Any, allowed: str, reason: str = "") -> None:
        super().__init__(name, value, allowed, reason)
        self.name = name
        self.value = value
        self.allowed = allowed
        self.reason = reason

    def __str__(self) -> str:
        text = "parameter %s: %s is refused, allowed is %s"
        text %= (self.name, shown(self.value), self.allowed)
        return "%s (%s)" % (text, self.reason) if self.reason else text


class Parameter(Generic[Value]):
    """One declared parameter; the base of all kinds.

    :param default: value in force where none is set, in ``unit``
    :param unit: unit of the value, empty where it has none
    :param help: one sentence for docs and descriptions
    """

    #: Name of the kind as shown to users.
    type_name: ClassVar[str] = ""

    def __init__(self, default: Value, *, unit: str = "", help: str) -> None:
        self.name = ""
        self.unit = unit
        self.help = help
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name
        self.default = self.coerce(self.default)

    @overload
    def __get__(self, instance: None, owner: type) -> "Parameter[Value]":
        ...

    @overload
    def __get__(self, instance: object, owner: type) -> Value:
        ...

    def __get__(self, instance: Optional[object], owner: type) -> Union["Parameter[Value]", Value]:
        # Only reached on the class: an instance's own __dict__ comes first, so
        # that reading a value in a callback costs no more than any attribute.
        return self

    @property
    def allowed(self) -> str:
        """What is allowed, worded to follow "allowed is"."""
        raise NotImplementedError

    @property
    def range(self) -> str:
        """The allowed values in interval or set notation, empty where all are."""
        return ""

    def coerce(self, raw: Any) -> Value:
        """Turn a value of the parameter server into one of this kind.

        :param raw: the value as YAML or XML-RPC delivered it
        :returns: the value in the declared kind and ``unit``
        :raises ParameterError: if the value is not allowed
        """
        raise NotImplementedError

    def refuse(self, raw: Any) -> ParameterError:
        """Return the error that says why a value is refused.

        :param raw: the refused value
        :returns: the error, to be raised by the caller
        """
        return ParameterError(self.name, raw, self.allowed)


class BoolParameter(Parameter[bool]):
    """True or false; no number or text stands for either."""

    type_name = "bool"

    @property
    def allowed(self) -> str:
        return "true or false"

    def coerce(self, raw: Any) -> bool:
        if not isinstance(raw, bool):
            raise self.refuse(raw)
        return raw


class _NumberParameter(Parameter[Value]):
    """A finite number in a range whose ends are closed or open.

    :param minimum: smallest allowed value (closed end)
    :param maximum: largest allowed value (closed end)
    :param above: bound below the allowed values (open end)
    :param below: bound above the allowed values (open end)
    :param step: distance of the allowed values from each other, counted from
        the lower bound, or from 0 where there is none
    """

    noun: ClassVar[str] = ""

    def __init__(
        self,
        default: Value,
        *,
        minimum: Optional[float] = None,
        maximum: Optional[float] = None,
        above: Optional[float] = None,
        below: Optional[float] = None,
        step: Optional[float] = None,
        unit: str = "",
        help: str,
    ) -> None:
        super().__init__(default, unit=unit, help=help)
        self.minimum, self.maximum = minimum, maximum
        self.above, self.below = above, below
        self.step = step

    @property
    def allowed(self) -> str:
        text = "%s in %s" % (self.noun, self.range) if self.range else self.noun
        if self.step is not None:
            text += " in steps of %s" % shown(self.step)
        return text + " (%s)" % self.unit if self.unit else text

    @property
    def range(self) -> str:
        if (self.minimum, self.maximum, self.above, self.below) == (None,) * 4:
            return ""
        low = "[%s" % shown(self.minimum) if self.minimum is not None else "(-inf"
        high = "%s]" % shown(self.maximum) if self.maximum is not None else "inf)"
        if self.above is not None:
            low = "(%s" % shown(self.above)
        if self.below is not None:
            high = "%s)" % shown(self.below)
        return "%s, %s" % (low, high)

    def _in_range(self, number: float) -> bool:
        return (
            (self.minimum is None or number >= self.minimum)
            and (self.maximum is None or number <= self.maximum)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
            and (self.step is None or self._on_step(number, self.step))
        )

    def _on_step(self, number: float, step: float) -> bool:
        start = self.minimum if self.minimum is not None else self.above or 0.0
        steps = (number - start) / step
        # As much as rounding explains, also where the step is small against the number.
        return math.isclose(steps, round(steps), rel_tol=1e-13, abs_tol=1e-9)


class FloatParameter(_NumberParameter[float]):
    """A finite number; integers and numeric text such as ``1e3`` are taken too."""

    type_name = "float"
    noun = "a number"

    def coerce(self, raw: Any) -> float:
        number = _finite_number(raw)
        if number is None or not self._in_range(number):
            raise self.refuse(raw)
        return number


class IntParameter(_NumberParameter[int]):
    """A whole number of 32 bits; ``5.0`` and numeric text are taken too."""

    type_name = "int"
    noun = "a whole number"

    def __init__(self, default: int, **options: Any) -> None:
        if "above" not in options:
            options.setdefault("minimum", INT32_MIN)
        if "below" not in options:
            options.setdefault("maximum", INT32_MAX)
        super().__init__(default, **options)

    def coerce(self, raw: Any) -> int:
        number = _finite_number(raw)
        if number is None or not number.is_integer() or not self._in_range(number):
            raise self.refuse(raw)
        return int(number)


class StringParameter(Parameter[str]):
    """Text. A number is refused: YAML would have needed quotes around it."""

    type_name = "str"

    @property
    def allowed(self) -> str:
        return "text (quote it where YAML would read a number or a truth value)"

    def coerce(self, raw: Any) -> str:
        if not isinstance(raw, str):
            raise self.refuse(raw)
        return raw


class EnumParameter(Parameter[str]):
    """One of a few words.

    :param choices: the allowed words
    """

    type_name = "enum"

    def __init__(self, default: str, *, choices: Sequence[str], unit: str = "", help: str) -> None:
        super().__init__(default, unit=unit, help=help)
        self.choices = tuple(choices)

    @property
    def allowed(self) -> str:
        return "one of " + ", ".join(self.choices)

    @property
    def range(self) -> str:
        return "{%s}" % ", ".join(self.choices)

    def coerce(self, raw: Any) -> str:
        if not isinstance(raw, str) or raw not in self.choices:
            raise self.refuse(raw)
        return raw


class ListParameter(Parameter[Tuple[Any, ...]]):
    """A list whose elements are all of one kind.

    :param default: elements, in the unit of ``element``
    :param element: declaration of each element (its default, unit and help are not used)
    :param min_length: smallest allowed number of elements
    :param max_length: largest allowed number of elements
    """

    type_name = "list"

    def __init__(
        self,
        default: Sequence[Any],
        *,
        element: Parameter[Any],
        min_length: int = 0,
        max_length: int = 1000,
        unit: str = "",
        help: str,
    ) -> None:
        super().__init__(tuple(default), unit=unit, help=help)
        self.element = element
        self.min_length, self.max_length = min_length, max_length

    @property
    def allowed(self) -> str:
        return "a list of %d to %d elements, each %s" % (
            self.min_length,
            self.max_length,
            self.element.allowed,
        )

    @property
    def range(self) -> str:
        return "%d to %d of %s" % (
            self.min_length,
            self.max_length,
            self.element.range or self.element.type_name,
        )

    def coerce(self, raw: Any) -> Tuple[Any, ...]:
        if not isinstance(raw, (list, tuple)):
            raise self.refuse(raw)
        if not self.min_length <= len(raw) <= self.max_length:
            raise self.refuse(raw)
        try:
            return tuple(self.element.coerce(item) for item in raw)
        except ParameterError:
            raise self.refuse(raw) from None


def to_wire(value: Any) -> Any:
    """Return a value as the parameter server takes it.

    :param value: a coerced value
    :returns: lists for tuples, plain text for what is derived from text
    """
    if isinstance(value, tuple):
        return [to_wire(item) for item in value]
    return str(value) if isinstance(value, str) else value


def _finite_number(raw: Any) -> Optional[float]:
    """Return the number that a raw value stands for, None if it is none."""
    if isinstance(raw, bool) or not isinstance(raw, (numbers.Real, str)):
        return None
    try:
        number = float(raw)
    except (ValueError, OverflowError):
        return None
    return number if math.isfinite(number) else None


def shown(value: Any, limit: int = 80) -> str:
    """Return a value for a message: short, and numbers without needless digits.

    :param value: any raw or coerced value
    :param limit: longest result, characters
    """
    if isinstance(value, float):
        text = "%.6g" % value
        text = (text if float(text) == value else "%.12g" % value).replace("e+0", "e")
    elif isinstance(value, str):
        text = "'%s'" % value
    else:
        text = repr(getattr(value, "data", to_wire(value)))  # base64 arrives wrapped
    return text if len(text) <= limit else text[: limit - 3] + "..."


def is_same(one: Any, other: Any) -> bool:
    """Tell whether two raw values are alike, also in kind: 1, 1.0 and True differ.

    :param one: a value as the parameter server holds it
    :param other: another
    """
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(is_same, one, other))
    both_nan = one != one and other != other
    return type(one) is type(other) and bool(one == other or both_nan)
