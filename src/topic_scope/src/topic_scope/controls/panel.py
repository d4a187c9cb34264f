# Pure: knows no ROS.
"""Panel of a node, made of the node's description of its parameters.

The descriptions are those of the service ``~describe`` of nodekit: a YAML list. The parameters are
built from it again, so that a value is checked here as the node would, and is refused in the same
words.
"""

from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Tuple

import yaml

from nodekit import (
    BytesParameter,
    DescriptionError,
    ListParameter,
    Parameter,
    ParameterError,
    parameter_of,
    to_wire,
)

_KINDS = {"bool": "bool", "int": "int", "float": "float", "enum": "enum"}  # else: text
_ENDS = ("minimum", "maximum", "above", "below")
#: The loader of libyaml takes a tenth of the time of the one in Python.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Entry(NamedTuple):
    """One parameter of a panel.

    :param parameter: validates values
    :param shown: what the page is told, without the value
    """

    parameter: Parameter[Any]
    shown: Mapping[str, Any]


class Panel:
    """The parameters of one node, and the services that can be called with a button.

    :param node: namespace of the parameters
    :param described: what :func:`nodekit.describe` says of each
    :param services: kind of each service, SetBool or Trigger, by name
    :raises DescriptionError: if one of them describes no parameter
    """

    def __init__(
        self, node: str, described: Iterable[Mapping[str, Any]], services: Mapping[str, str]
    ) -> None:
        self.node = node
        self.services = services
        self.entries: Dict[str, Entry] = {}
        self.values: Dict[str, Any] = {}
        for one in described:
            name, entry, value = _entry(node, one)
            self.entries[name] = entry
            self.values[name] = value

    def message(self) -> Dict[str, Any]:
        """Return what the page shows."""
        return {
            "node": self.node,
            "parameters": [
                {**entry.shown, "value": self.shown_value(name)}
                for name, entry in self.entries.items()
            ],
            "services": [
                {"name": name, "kind": kind} for name, kind in sorted(self.services.items())
            ],
        }

    def shown_value(self, name: str) -> Any:
        """Return a parameter's value as the page shows it.

        :param name: name of the parameter
        """
        value = to_wire(self.values[name])
        if isinstance(value, list):
            return yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
        return value

    def check(self, name: str, value: Any) -> Any:
        """Return the value that the node would make of one.

        :param name: name of the parameter
        :param value: as the page, or the parameter server, has it; a page writes a list or bytes
            as YAML
        :raises ParameterError: if it is not allowed, in the node's own words
        """
        parameter = self.entries[name].parameter
        if isinstance(parameter, (ListParameter, BytesParameter)) and isinstance(value, str):
            try:
                value = yaml.load(value, _LOADER)
            except yaml.YAMLError:
                raise parameter.refuse(value) from None
        return parameter.coerce(value)

    def follow(self, raw: Mapping[str, Any]) -> List[str]:
        """Take over what stands on the parameter server, as far as it is allowed.

        :param raw: values by name; one that is not allowed is about to be put back by the node
        :returns: names of the parameters that have changed
        """
        changed = []
        for name in self.entries:
            try:
                value = self.check(name, raw[name])
            except (KeyError, ParameterError):
                continue
            if value != self.values[name]:
                self.values[name] = value
                changed.append(name)
        return changed


def _labels(pairs: Any) -> List[Tuple[float, str]]:
    """Return what the numbers of an enum are called."""
    try:
        return [(value, str(word)) for value, word in pairs if type(value) in (int, float)]
    except (TypeError, ValueError):
        return []


def _entry(node: str, described: Mapping[str, Any]) -> Tuple[str, Entry, Any]:
    name = str(described.get("name"))
    try:
        parameter = parameter_of(described)
        parameter.name = f"{node}/{name}"
        value = parameter.coerce(described["value"])
    except (KeyError, ValueError) as error:  # an unknown kind, a bad limit, an invalid value
        raise DescriptionError(f"{name}: {error}") from None
    shown: Dict[str, Any] = {
        "name": name,
        "kind": _KINDS.get(parameter.type_name, "string"),
        "unit": parameter.unit,
        "help": parameter.help,
        **{end: getattr(parameter, end, None) for end in _ENDS},
        "choices": list(getattr(parameter, "choices", [])),
        "labels": _labels(described.get("labels", [])),
    }
    return name, Entry(parameter, shown), value
