# Pure: knows no ROS.
"""Parameter panel of one node: values, limits and service buttons, from its own description.

The description is the reply of nodekit's service ``~describe``: a YAML list. The parameters are
rebuilt from it, so that values are validated here as in the node, with the same error messages.
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
#: libyaml's loader takes a tenth of the time of the Python loader.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class PanelEntry(NamedTuple):
    """Parameter of a panel.

    :param parameter: validator of values
    :param shown: description for the page, without the value
    """

    parameter: Parameter[Any]
    shown: Mapping[str, Any]


class ParameterPanel:
    """Parameters of a node, and its services that have a button.

    :param node: namespace of the parameters
    :param described: descriptions in the form of :func:`nodekit.describe`
    :param services: type of each service, SetBool or Trigger, by name
    :raises DescriptionError: if a description is invalid
    """

    def __init__(
        self, node: str, described: Iterable[Mapping[str, Any]], services: Mapping[str, str]
    ) -> None:
        self.node = node
        self.services = services
        self.entries: Dict[str, PanelEntry] = {}
        self.values: Dict[str, Any] = {}
        for one in described:
            name, entry, value = _entry(node, one)
            self.entries[name] = entry
            self.values[name] = value

    def message(self) -> Dict[str, Any]:
        """Return the panel as a message for the page."""
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
        """Return a parameter's value in the form for the page.

        :param name: name of the parameter
        """
        value = to_wire(self.values[name])
        if isinstance(value, list):
            return yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
        return value

    def check(self, name: str, value: Any) -> Any:
        """Return a value as the node would convert it.

        :param name: name of the parameter
        :param value: from the page, or from the parameter server; a page writes a list or bytes
            as YAML
        :raises ParameterError: if the value is invalid, with the node's error message
        """
        parameter = self.entries[name].parameter
        if isinstance(parameter, (ListParameter, BytesParameter)) and isinstance(value, str):
            try:
                value = yaml.load(value, _LOADER)
            except yaml.YAMLError:
                raise parameter.refuse(value) from None
        return parameter.coerce(value)

    def follow(self, raw: Mapping[str, Any]) -> List[str]:
        """Update the values from the parameter server, as far as they are valid.

        :param raw: values by name; the node is about to restore an invalid value
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
    """Return the names of the numbers of an enum."""
    try:
        return [(value, str(word)) for value, word in pairs if type(value) in (int, float)]
    except (TypeError, ValueError):
        return []


def _entry(node: str, described: Mapping[str, Any]) -> Tuple[str, PanelEntry, Any]:
    name = str(described.get("name"))
    try:
        parameter = parameter_of(described)
        parameter.name = f"{node}/{name}"
        value = parameter.coerce(described["value"])
    except (KeyError, ValueError) as error:  # an unknown type, a bad limit, an invalid value
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
    return name, PanelEntry(parameter, shown), value
