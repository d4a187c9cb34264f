"""Refuse a class of parameters that does not mean what it seems to, as it is read."""

import inspect
import re
from typing import Any, Collection, Dict

from nodekit.parameters.parameter_types import Parameter

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_MUST_BE_NAME = "must be a letter (a-z, A-Z), then letters, digits and underscores"


def check_members(cls: type, taken: Collection[str], of_every_node: Collection[str]) -> None:
    """Judge what a class of parameters has in its own body.

    Names with an underscore before them are the class's own business, unless they are parameters.
    A property in place of a parameter that is inherited takes that away; nothing else does.

    :param cls: the class
    :param taken: what the base of all these classes has
    :param of_every_node: parameters that every node has beside those of its class
    :raises TypeError: if something is no parameter but looks like one, or is hidden by another
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
            raise TypeError(f"{where}: the kind alone: write {item.__name__}(…), with its default")
        elif inspect.iscoroutinefunction(item) and hasattr(item, "parameters"):
            raise TypeError(f"{where}: a rule is judged at once: write def instead of async def")
        elif not (name.startswith("_") or _is_ordinary(item) or _is_inherited(cls, name)):
            advice = "write FloatParameter(1.0, help=…) or another kind; a constant begins with _"
            raise TypeError(f"{where} = {item!r:.40}: is no parameter: {advice}")
    for name in _annotated(cls):
        if not name.startswith("_") and name not in taken and not hasattr(cls, name):
            advice = f"write {name} = FloatParameter(1.0, help=…) or another kind"
            raise TypeError(f"{cls.__name__}.{name}: a type alone declares nothing: {advice}")


def _check_inherited(cls: type) -> None:
    """Refuse what would take an inherited parameter away without a word.

    It may come from a base that declares no parameters, too.
    """
    inherited = {
        name: item
        for base in cls.__mro__[1:]
        for name, item in vars(base).items()
        if isinstance(item, Parameter)
    }
    for name, parameter in inherited.items():
        item = inspect.getattr_static(cls, name)
        is_kind = isinstance(item, type) and issubclass(item, Parameter)  # refused below, in words
        if not (isinstance(item, (Parameter, property)) or is_kind):
            kind = f"{type(parameter).__name__}(…)"
            advice = f"write {kind} for another default, or property(lambda self: …) to do without"
            raise TypeError(f"{cls.__name__}.{name} = {item!r:.40}: hides a parameter: {advice}")


def check_rules(owner: str, rules: Collection[Any], declared: Collection[str]) -> None:
    """Judge whether rules are about what is declared.

    :param owner: name of the class of parameters
    :param rules: functions that are marked as rules
    :param declared: names of its parameters
    :raises TypeError: if one is not marked, or about something else
    """
    for method in rules:
        if not hasattr(method, "parameters"):
            raise TypeError(f"{owner}: refused {method!r:.80}: must be marked by @rule('name')")
        unknown = sorted(set(method.parameters) - set(declared))
        if unknown:
            text = ", ".join(unknown)
            raise TypeError(f"{owner}: a rule is about undeclared parameters: {text}")


def _is_ordinary(item: object) -> bool:
    """Tell whether a class has this for its own use: a method, a property or a class."""
    return isinstance(item, type) or hasattr(item, "__get__")


def _is_inherited(cls: type, name: str) -> bool:
    """Tell whether a class takes something of another's away, or has its own in its place."""
    return any(name in vars(base) for base in cls.__mro__[1:])


def _annotated(cls: type) -> Collection[str]:
    try:
        return list(getattr(cls, "__annotations__", ()))
    except NameError:  # since Python 3.14 they are read only now, and may name what is not there
        return ()


def checked_default(owner: str, parameter: Parameter[Any]) -> Any:
    """Return the default of a declared parameter; text is no number here, as it is in YAML.

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
    """Return what of a value is text."""
    if isinstance(value, (list, tuple)):
        return [_texts(item) for item in value]
    return isinstance(value, str)
