"""Checks of a class of parameters at its definition, for mistakes that would go unnoticed."""

import inspect
import re
from typing import Any, Collection, Dict

from nodekit.parameters.parameter_types import Parameter

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_MUST_BE_NAME = "must be a letter (a-z, A-Z), then letters, digits and underscores"


def check_members(cls: type, taken: Collection[str], of_every_node: Collection[str]) -> None:
    """Check the body of a class of parameters.

    Names with a leading underscore are private to the class, unless they are parameters. Only a
    property may replace an inherited parameter, and removes it.

    :param cls: the class
    :param taken: attribute names of the base class
    :param of_every_node: parameters that every node has in addition
    :raises TypeError: if an attribute only looks like a parameter, or hides one
    :raises ValueError: if a parameter has a name that ROS does not allow
    """
    _check_inherited(cls)
    found: Dict[int, str] = {}
    for name, item in list(vars(cls).items()):
        where = f"{cls.__name__}.{name}"
        if isinstance(item, Parameter):
            if _NAME.fullmatch(name) is None:
                raise ValueError(f"{where}: {_MUST_BE_NAME}")
            if name in taken:
                raise TypeError(f"{where}: every ParameterSet has a {name} already")
            if name in of_every_node:
                raise TypeError(f"{where}: every node has a parameter {name} already")
            other = found.setdefault(id(item), name)
            if other != name:
                raise TypeError(f"{where}: is the same object as {other}: declare each for itself")
        elif isinstance(item, type) and issubclass(item, Parameter):
            raise TypeError(
                f"{where}: brackets missing: write {item.__name__}(…), with its default"
            )
        elif inspect.iscoroutinefunction(item) and hasattr(item, "parameters"):
            raise TypeError(f"{where}: must not be async: write def instead of async def")
        elif not (name.startswith("_") or _is_ordinary(item) or _is_inherited(cls, name)):
            advice = "write FloatParameter(1.0, help=…) or another type; a constant begins with _"
            raise TypeError(f"{where} = {item!r:.40}: not a parameter: {advice}")
    for name in _annotated(cls):
        if not name.startswith("_") and name not in taken and not hasattr(cls, name):
            advice = f"write {name} = FloatParameter(1.0, help=…) or another type"
            raise TypeError(f"{cls.__name__}.{name}: an annotation is not enough: {advice}")


def _check_inherited(cls: type) -> None:
    """Reject attributes that would silently hide an inherited parameter.

    They may also come from a base class without parameters.
    """
    inherited = {
        name: item
        for base in cls.__mro__[1:]
        for name, item in vars(base).items()
        if isinstance(item, Parameter)
    }
    for name, parameter in inherited.items():
        item = inspect.getattr_static(cls, name)
        is_type = isinstance(item, type) and issubclass(
            item, Parameter
        )  # rejected below, with advice
        if not (isinstance(item, (Parameter, property)) or is_type):
            declaration = f"{type(parameter).__name__}(…)"
            advice = (
                f"write {declaration} for another default, or property(lambda self: …) to remove it"
            )
            raise TypeError(f"{cls.__name__}.{name} = {item!r:.40}: hides a parameter: {advice}")


def check_rules(owner: str, rules: Collection[Any], declared: Collection[str]) -> None:
    """Check that rules refer to declared parameters.

    :param owner: name of the class of parameters
    :param rules: functions that are marked as rules
    :param declared: names of its parameters
    :raises TypeError: if a function is not marked, or refers to an undeclared parameter
    """
    for method in rules:
        if not hasattr(method, "parameters"):
            raise TypeError(f"{owner}: refused {method!r:.80}: must be marked by @rule('name')")
        unknown = sorted(set(method.parameters) - set(declared))
        if unknown:
            text = ", ".join(unknown)
            raise TypeError(f"{owner}: a rule is about undeclared parameters: {text}")


def _is_ordinary(item: object) -> bool:
    """Return whether an attribute is a method, a property or a class."""
    return isinstance(item, type) or hasattr(item, "__get__")


def _is_inherited(cls: type, name: str) -> bool:
    """Return whether a base class has an attribute of this name."""
    return any(name in vars(base) for base in cls.__mro__[1:])


def _annotated(cls: type) -> Collection[str]:
    try:
        return list(getattr(cls, "__annotations__", ()))
    except (
        NameError
    ):  # since Python 3.14 they are evaluated only now, and may use an undefined name
        return ()


def checked_default(owner: str, parameter: Parameter[Any]) -> Any:
    """Return the coerced default of a parameter; numeric text is rejected here.

    :param owner: name of the class
    :param parameter: the parameter
    :raises ParameterError: if the default is not allowed
    """
    value = parameter.accept(parameter.default)
    if _texts(parameter.default) != _texts(value):
        refused = parameter.refuse(parameter.default)
        refused.reason = "text"
        raise refused.in_namespace(owner)
    return value


def _texts(value: Any) -> Any:
    """Return which parts of a value are text."""
    if isinstance(value, (list, tuple)):
        return [_texts(item) for item in value]
    return isinstance(value, str)
