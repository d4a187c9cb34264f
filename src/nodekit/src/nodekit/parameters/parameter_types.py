"""Base class of parameter types, and the non-numeric types.

Text is not converted to a boolean, nor a number to text. Errors name the parameter, the value and
the allowed values.
"""

import re
from typing import Any, ClassVar, Generic, Optional, Sequence, Tuple, TypeVar, Union, overload

Value = TypeVar("Value")

#: Characters that XML, and so the parameter server, cannot carry, or changes: a carriage return
#: arrives as a line feed.
_NOT_IN_XML = re.compile("[\x00-\x08\x0b-\x1f\ud800-\udfff\ufffe\uffff]")


class ParameterError(ValueError):
    """Error of a value that a parameter does not allow.

    :param name: name of the parameter, empty for the whole namespace
    :param value: the rejected raw value
    :param allowed: the allowed values, worded to follow "must be"
    :param reason: further reason, if ``allowed`` is not sufficient
    """

    def __init__(self, name: str, value: Any, allowed: str, reason: str = "") -> None:
        super().__init__(name, value, allowed, reason)
        self.name = name
        self.value = value
        self.allowed = allowed
        self.reason = reason

    @property
    def names(self) -> Tuple[str, ...]:
        """Names of all parameters concerned."""
        return (self.name,)

    def in_namespace(self, namespace: str) -> "ParameterError":
        """Return the same error with the resolved name.

        :param namespace: global name of the namespace of the parameters
        """
        name = f"{namespace}/{self.name}" if self.name else namespace
        return ParameterError(name, self.value, self.allowed, self.reason)

    def __str__(self) -> str:
        text = f"parameter {self.name}: refused {format_value(self.value)}: must be {self.allowed}"
        return f"{text} ({self.reason})" if self.reason else text


class Parameter(Generic[Value]):
    """Declared parameter; base class of all parameter types.

    :param default: default value, in ``unit``
    :param unit: unit of the value, empty without one
    :param help: one sentence for docs and descriptions
    """

    #: Name of the type as shown to users.
    type_name: ClassVar[str] = ""
    #: Whether a change takes effect only when the node is created again.
    read_once = False

    def __init__(self, default: Value, *, unit: str = "", help: str) -> None:
        self.name = ""
        self.unit = unit
        self.help = help
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> "Parameter[Value]": ...

    @overload
    def __get__(self, instance: object, owner: type) -> Value: ...

    def __get__(self, instance: Optional[object], owner: type) -> Union["Parameter[Value]", Value]:
        # Reached on the class only: an instance's __dict__ comes first.
        return self

    @property
    def allowed(self) -> str:
        """Allowed values, worded to follow "must be"."""
        raise NotImplementedError

    @property
    def range(self) -> str:
        """Allowed values in interval or set notation, empty if all are allowed."""
        return ""

    def coerce(self, raw: Any) -> Value:
        """Convert a value of the parameter server to this type.

        :param raw: value from YAML or XML-RPC
        :returns: the value in the declared type and ``unit``
        :raises ParameterError: if the value is not allowed
        """
        raise NotImplementedError

    def accept(self, raw: Any) -> Value:
        """Convert a value from any source to this type, see :func:`plain` and :meth:`coerce`.

        :param raw: the value, which may be a numpy value
        :raises ParameterError: if the value is not allowed
        """
        return self.coerce(plain(raw))

    def refuse(self, raw: Any) -> ParameterError:
        """Return the error of a rejected value, for the caller to raise.

        :param raw: the rejected value
        """
        return ParameterError(self.name, raw, self.allowed)


class BoolParameter(Parameter[bool]):
    """Boolean; numbers and text are rejected."""

    type_name = "bool"

    @property
    def allowed(self) -> str:
        return "true or false"

    def coerce(self, raw: Any) -> bool:
        if not isinstance(raw, bool):
            raise self.refuse(raw)
        return raw


class StringParameter(Parameter[str]):
    """Text. Numbers are rejected: they need quotes in YAML."""

    type_name = "str"

    @property
    def allowed(self) -> str:
        return "text without control characters (quote it if YAML would read something else)"

    def coerce(self, raw: Any) -> str:
        if not isinstance(raw, str) or _NOT_IN_XML.search(raw):
            raise self.refuse(raw)
        return raw


class BytesParameter(Parameter[bytes]):
    """Bytes, on the server as a list of numbers from 0 to 255.

    ``!!binary`` in YAML and ``binfile=`` in a launch file are accepted too, and replaced by such a
    list: ``rosparam get`` and ``dump`` fail on binary values.

    :param max_length: largest allowed number of bytes
    """

    type_name = "bytes"

    def __init__(
        self, default: bytes, *, max_length: int = 1000, unit: str = "", help: str
    ) -> None:
        super().__init__(default, unit=unit, help=help)
        self.max_length = max_length

    @property
    def allowed(self) -> str:
        return f"at most {self.max_length} bytes, as a list of numbers from 0 to 255"

    @property
    def range(self) -> str:
        return f"at most {self.max_length} bytes"

    def coerce(self, raw: Any) -> bytes:
        wrapped = getattr(raw, "data", None)  # XML-RPC wraps binary values
        value = wrapped if isinstance(wrapped, bytes) else plain(raw)
        if isinstance(value, (list, tuple)) and all(type(number) is int for number in value):
            try:
                value = bytes(value)
            except ValueError:
                pass  # a number out of range
        if not isinstance(value, bytes) or len(value) > self.max_length:
            raise self.refuse(raw)
        return value


class EnumParameter(Parameter[str]):
    """One of several words.

    :param choices: the allowed words
    """

    type_name = "enum"

    def __init__(self, default: str, *, choices: Sequence[str], unit: str = "", help: str) -> None:
        super().__init__(default, unit=unit, help=help)
        is_list = not isinstance(choices, str) and all(isinstance(each, str) for each in choices)
        if not is_list or any(map(_NOT_IN_XML.search, choices)):
            raise TypeError(f"choices: refused {choices!r:.80}: must be a list of words")
        self.choices = tuple(choices)

    @property
    def allowed(self) -> str:
        return "one of " + ", ".join(self.choices)

    @property
    def range(self) -> str:
        return "{" + ", ".join(self.choices) + "}"

    def coerce(self, raw: Any) -> str:
        if not isinstance(raw, str) or raw not in self.choices:
            raise self.refuse(raw)
        return raw


class ListParameter(Parameter[Tuple[Any, ...]]):
    """List of elements of one type.

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
        if not isinstance(element, Parameter):
            raise TypeError(f"element: refused {element!r:.80}: must be a parameter, with brackets")
        self.element = element
        self.min_length, self.max_length = min_length, max_length

    @property
    def allowed(self) -> str:
        lengths = f"{self.min_length} to {self.max_length}"
        return f"a list of {lengths} elements, each {self.element.allowed}"

    @property
    def range(self) -> str:
        element = self.element.range or self.element.type_name
        return f"{self.min_length} to {self.max_length} of {element}"

    def coerce(self, raw: Any) -> Tuple[Any, ...]:
        if not isinstance(raw, (list, tuple)) or not self.min_length <= len(raw) <= self.max_length:
            raise self.refuse(raw)
        try:
            return tuple(self.element.accept(item) for item in raw)
        except ParameterError:
            raise self.refuse(raw) from None


def plain(raw: Any) -> Any:
    """Return a raw value as a built-in type.

    :param raw: any value
    :returns: a number or text for a numpy scalar or a subclass of str, a list for an array;
        any other value unchanged
    """
    if isinstance(raw, str):
        return str.__str__(raw)
    # numpy is not imported, because most nodes do not need it.
    return raw.tolist() if hasattr(raw, "tolist") and hasattr(raw, "dtype") else raw


def to_wire(value: Any) -> Any:
    """Return a value in the form of the parameter server.

    :param value: a coerced value, or a new value of a parameter
    :returns: lists for tuples and bytes, and the result of :func:`plain` for other values
    """
    value = plain(value)
    if isinstance(value, (tuple, list, bytes)):
        return [to_wire(item) for item in value]
    return value


def format_value(value: Any, limit: int = 80) -> str:
    """Return a value for a message: short, and numbers without needless digits.

    :param value: any raw or coerced value
    :param limit: longest result [characters]
    """
    wrapped, value = getattr(value, "data", None), plain(value)
    if isinstance(value, float):
        text = f"{value:.6g}"
        text = (text if float(text) == value else f"{value:.12g}").replace("e+0", "e")
    elif isinstance(value, str):
        text = f"'{value}'"
    else:
        text = repr(wrapped if isinstance(wrapped, bytes) else to_wire(value))
    return text if len(text) <= limit else text[: limit - 3] + "..."


class NoValue:
    """Placeholder for a missing or unreadable raw value; no parameter accepts it.

    :param text: text of the placeholder
    """

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


#: Value of a key that is not set on the server.
MISSING = NoValue("MISSING")
#: Value that the master cannot send, such as an integer of 64 bits.
UNREADABLE = NoValue("a value that the master cannot send")


def is_same(one: Any, other: Any) -> bool:
    """Return whether two raw values and their types are equal: 1, 1.0 and True differ.

    :param one: a raw value of the parameter server
    :param other: another raw value
    """
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(is_same, one, other))
    both_nan = one != one and other != other
    return type(one) is type(other) and bool(one == other or both_nan)
