"""Conversion between plain parameter values and rcl_interfaces messages; descriptors and events."""

from typing import Any, Dict, Mapping

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    Parameter,
    ParameterDescriptor,
    ParameterEvent,
    ParameterValue,
)

from ros2_bridge.parameters.values import (
    FIELDS,
    INTEGER,
    NOT_SET,
    as_kind,
    declared_kind,
    description_of,
    range_of,
)


def to_message(value: Any, kind: int) -> ParameterValue:
    """Return a plain value as a message; NOT_SET if ROS 2 has no such type."""
    message = ParameterValue(type=kind, check_fields=True)  # otherwise it would fail when sent
    if kind != NOT_SET:
        try:
            setattr(message, FIELDS[kind], as_kind(value, kind))
        except (TypeError, ValueError, AssertionError, OverflowError):
            return ParameterValue()
    return message


def to_plain(message: ParameterValue) -> Any:
    """Return the value of a message; None if it has no value."""
    if message.type not in FIELDS:
        return None
    value = getattr(message, FIELDS[message.type])
    if isinstance(value, (bool, int, float, str)):
        return value
    return [one[0] if isinstance(one, bytes) else one for one in value]


def descriptor(name: str, entry: Mapping[str, Any]) -> ParameterDescriptor:
    """Return the descriptor of a parameter.

    :param entry: from the node's own description
    """
    words, allowed = description_of(entry)
    message = ParameterDescriptor(
        name=name, type=declared_kind(entry), description=words, additional_constraints=allowed
    )
    limits = range_of(entry)
    if limits is not None and message.type == INTEGER:
        message.integer_range = [
            IntegerRange(from_value=int(limits.low), to_value=int(limits.high), step=limits.step)
        ]
    elif limits is not None:
        message.floating_point_range = [
            FloatingPointRange(from_value=limits.low, to_value=limits.high, step=limits.step)
        ]
    return message


def event(node: str, stamp: Any, *parts: Dict[str, ParameterValue]) -> ParameterEvent:
    """Return the event message of a change.

    :param parts: new, changed and deleted parameters
    """
    new, changed, deleted = (
        [Parameter(name=name, value=value) for name, value in part.items()] for part in parts
    )
    return ParameterEvent(
        stamp=stamp,
        node=node,
        new_parameters=new,
        changed_parameters=changed,
        deleted_parameters=deleted,
    )
