"""Panels of dynamic_reconfigure servers.

Such a node publishes its description and its values on latched topics, keeps its values on the
parameter server, and changes them by a service, which silently limits a value to its range.
"""

import ast
import math
from typing import Any, Dict, List, Mapping

import rospy

from nodekit import call_service
from topic_scope.controls.parameter_sender import ChangeReply

try:
    from dynamic_reconfigure.msg import (
        BoolParameter,
        Config,
        ConfigDescription,
        DoubleParameter,
        IntParameter,
        StrParameter,
    )
    from dynamic_reconfigure.srv import Reconfigure

    AVAILABLE = True
    #: Field of a message with the values of each type, and their message type.
    _PARTS = {
        bool: ("bools", BoolParameter),
        int: ("ints", IntParameter),
        float: ("doubles", DoubleParameter),
        str: ("strs", StrParameter),
    }
except ImportError:  # the package is optional
    AVAILABLE = False

#: Last part of the service's name, and its type.
SERVICE, TYPE = "set_parameters", "dynamic_reconfigure/Reconfigure"
#: Timeout for a node's description [s].
_ANSWER_S = 2.0
_TYPES = {"bool": "bool", "int": "int", "double": "float", "str": "str"}
#: Bounds that denote an unlimited int or float.
_NO_END = {"int": 2**31 - 1, "float": 1e300}


def describe(node: str) -> List[Dict[str, Any]]:
    """Request the parameters of a node.

    :param node: namespace of the parameters
    :returns: descriptions in the form of :func:`nodekit.describe`
    :raises rospy.ROSException: if the node does not publish them
    """
    description, values = (
        rospy.wait_for_message(f"{node}/{topic}", kind, _ANSWER_S)
        for topic, kind in (
            ("parameter_descriptions", ConfigDescription),
            ("parameter_updates", Config),
        )
    )
    return described(description, values)


def change(node: str, values: Mapping[str, Any]) -> ChangeReply:
    """Change parameters of a node, all in one request.

    :param node: namespace of the parameters
    :param values: by name
    :raises CallError: if it does not answer in good time
    """
    answer = call_service(f"{node}/{SERVICE}", Reconfigure, config_of(values)).result()
    known = values_in(answer.config)
    made = {name: known[name] for name in values if name in known}
    other = [f"{name} = {made[name]!r}" for name in made if made[name] != values[name]]
    return ChangeReply(not other, f"{node} changed it to {', '.join(other)}", made)


def values_in(config: "Config") -> Dict[str, Any]:
    """Return the values in a message."""
    return {item.name: item.value for part, _ in _PARTS.values() for item in getattr(config, part)}


def config_of(values: Mapping[str, Any]) -> "Config":
    """Return values as a message.

    :param values: Booleans, numbers and strings, by name
    """
    config = Config()
    for name, value in values.items():
        part, kind = _PARTS[type(value)]
        getattr(config, part).append(kind(name, value))
    return config


def described(description: "ConfigDescription", values: "Config") -> List[Dict[str, Any]]:
    """Return a description in nodekit's form; a number of an enum also has ``labels``.

    :param description: as the node publishes it
    :param values: current values
    """
    now, low, high = map(values_in, (values, description.min, description.max))
    entries: Dict[str, Dict[str, Any]] = {}
    for group in description.groups:
        for parameter in group.parameters:
            name, kind = parameter.name, _TYPES.get(parameter.type)
            if kind is None or name not in now:
                continue
            ends = {"minimum": low.get(name), "maximum": high.get(name)}
            words = _words(parameter.edit_method)
            entries[name] = {
                "name": name,
                "value": now[name],
                "default": now[name],
                "type": kind,
                "help": parameter.description,
                **{end: value for end, value in ends.items() if _is_end(value, kind)},
            }
            if words and kind == "str":
                entries[name].update({"type": "enum", "choices": list(words.values())})
            elif words and kind in _NO_END:
                entries[name]["labels"] = [[value, word] for word, value in words.items()]
    return list(entries.values())


def _is_end(value: Any, kind: str) -> bool:
    if kind not in _NO_END or value is None or not math.isfinite(value):
        return False
    return bool(abs(value) < _NO_END[kind])


def _words(edit_method: str) -> Dict[str, Any]:
    """Return the names and values of an enum; empty for other parameters."""
    try:
        listed = ast.literal_eval(edit_method)["enum"]
        return {str(one["name"]): one["value"] for one in listed}
    except (ValueError, SyntaxError, TypeError, KeyError, MemoryError, RecursionError):
        return {}
