"""Parameters of a ROS 1 node with a dynamic_reconfigure server.

The node reads the parameter server only at its start; later changes go through its own service.
That service silently clips values to their limits, so they are validated here.
"""

import ast
import threading
from typing import Any, Dict, List, Mapping

from dynamic_reconfigure.msg import (
    BoolParameter,
    Config,
    ConfigDescription,
    DoubleParameter,
    IntParameter,
    StrParameter,
)
from dynamic_reconfigure.srv import Reconfigure

from nodekit import NodeScope, call_service
from nodekit.master import MasterClient
from ros2_bridge.parameters.ros1_parameters import TIMEOUT_S, Parameter, ServerParameters
from ros2_bridge.parameters.values import declared_kind

#: Base name of the service that identifies such a node.
SERVICE = "set_parameters"
#: Type names of nodekit's descriptions, by those of dynamic_reconfigure.
_TYPES = {"bool": "bool", "int": "int", "double": "float", "str": "str"}
#: Field of a Config, class of its items and converter of its values, by type.
_FIELDS = {
    "bool": ("bools", BoolParameter, bool),
    "int": ("ints", IntParameter, int),
    "float": ("doubles", DoubleParameter, float),
    "str": ("strs", StrParameter, str),
}


class ReconfiguredParameters(ServerParameters):
    """Parameters that the node describes, and its other parameters on the parameter server.

    :param client: client of the master
    :param name: global name of the node
    :param scope: creates the subscriptions to the node's descriptions and updates
    """

    def __init__(self, client: MasterClient, name: str, scope: NodeScope) -> None:
        super().__init__(client, name)
        self._lock = threading.Lock()
        self._entries: Dict[str, Mapping[str, Any]] = {}
        self._values: Dict[str, Any] = {}
        scope.create_subscription(
            f"{name}/parameter_descriptions", ConfigDescription, self._describe
        )
        scope.create_subscription(f"{name}/parameter_updates", Config, self._update)

    def _describe(self, message: Any) -> None:
        low, high = values_of(message.min), values_of(message.max)
        entries: Dict[str, Mapping[str, Any]] = {
            one.name: entry_of(one, low.get(one.name), high.get(one.name))
            for group in message.groups
            for one in group.parameters
            if one.type in _TYPES
        }
        with self._lock:
            self._entries = entries

    def _update(self, message: Any) -> None:
        with self._lock:
            self._values = values_of(message)

    def _described(self) -> Dict[str, Mapping[str, Any]]:
        with self._lock:
            return {name: self._entries[name] for name in self._values if name in self._entries}

    def _read(self) -> Dict[str, Parameter]:
        found = super()._read()
        entries = self._described()
        with self._lock:
            values = dict(self._values)
        for name, entry in entries.items():
            found[name] = Parameter(values[name], declared_kind(entry), entry)
        return found

    def caution(self, names: List[str]) -> str:
        entries = self._described()
        return super().caution([name for name in names if name not in entries])

    def _change(self, values: Mapping[str, Any]) -> str:
        entries = self._described()
        if not entries:
            return f"{self.name} has not described its parameters yet; try again"
        reasons = [refusal(name, values[name], entries[name]) for name in values if name in entries]
        if any(reasons):
            return "; ".join(filter(None, reasons))
        config = Config()
        for name in values:
            if name in entries:
                field, cls, make = _FIELDS[entries[name]["type"]]
                getattr(config, field).append(cls(name, make(values[name])))
        service = f"{self.name}/{SERVICE}"
        answer = call_service(service, Reconfigure, config, timeout=TIMEOUT_S).result()
        in_force = values_of(answer.config)
        with self._lock:
            self._values.update(in_force)
        others = {name: value for name, value in values.items() if name not in entries}
        self._client.write({f"{self.name}/{key}": value for key, value in others.items()})
        return "; ".join(
            f"{name}: {self.name} has set it to {in_force.get(name)!r}"
            for name in values
            if name in entries and in_force.get(name) != values[name]
        )


def values_of(config: Any) -> Dict[str, Any]:
    """Return the values of a Config by name."""
    fields = (config.bools, config.ints, config.doubles, config.strs)
    return {one.name: one.value for field in fields for one in field}


def entry_of(described: Any, low: Any, high: Any) -> Dict[str, Any]:
    """Return a parameter as an entry of a nodekit description.

    :param described: its ParamDescription
    :param low: minimum
    :param high: maximum
    """
    kind = _TYPES[described.type]
    entry: Dict[str, Any] = {"type": kind, "help": described.description}
    if kind in ("int", "float"):
        entry.update(minimum=low, maximum=high, range=f"from {low} to {high}")
    try:
        choices = ast.literal_eval(described.edit_method or "{}")["enum"]
        entry["choices"] = [one["value"] for one in choices]
    except (ValueError, SyntaxError, KeyError, TypeError):
        pass  # not an enumeration
    return entry


def refusal(name: str, value: Any, entry: Mapping[str, Any]) -> str:
    """Return why a value is invalid; empty if it is valid.

    :param name: name of the parameter
    :param value: the value
    :param entry: its description
    """
    kind = entry["type"]
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    fits = {
        "bool": isinstance(value, bool),
        "int": is_number and isinstance(value, int),
        "float": is_number,
        "str": isinstance(value, str),
    }[kind]
    if not fits:
        return f"{name}: refused {value!r}: must be of type {kind}"
    if kind in ("int", "float") and not entry["minimum"] <= value <= entry["maximum"]:
        return f"{name}: refused {value!r}: must be {entry['range']}"
    if entry.get("choices") and value not in entry["choices"]:
        return f"{name}: refused {value!r}: must be one of {entry['choices']}"
    return ""
