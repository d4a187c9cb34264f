"""Server of dynamic_reconfigure's protocol for live parameters.

With it ``dynamic_reconfigure.client.Client`` and rqt_reconfigure work on the
same values as ``rosparam``. Only the messages of the package are used: its own
server does not follow ``rosparam set``, clamps silently and accepts NaN.
Lists and bytes are omitted, because the interface has no such types.
"""

import functools
import sys
from typing import Any, Callable, Dict, Mapping, Type

import rospy

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameters.declaration import (
    EnumParameter,
    Parameter,
    ParameterError,
    ParameterSet,
)
from nodekit.parameters.parameter_types import is_same
from nodekit.parameters.schema import help_of
from nodekit.parameters.validation import on_wire

try:
    from dynamic_reconfigure.msg import (
        BoolParameter,
        Config,
        ConfigDescription,
        DoubleParameter,
        Group,
        GroupState,
        IntParameter,
        ParamDescription,
        StrParameter,
    )
    from dynamic_reconfigure.srv import Reconfigure, ReconfigureRequest

    AVAILABLE = True
except ImportError:  # the package is optional
    AVAILABLE = False

_GROUP = "Default"
_INT_RANGE = (-(2**31), 2**31 - 1)
_FLOAT_RANGE = (-sys.float_info.max, sys.float_info.max)
_TYPES = {"bool": "bool", "int": "int", "float": "double", "str": "str", "enum": "str"}


class ReconfigureInterface:
    """Server of live parameters for the dynamic_reconfigure tools.

    :ROS Publishers:
        - ``parameter_descriptions`` (dynamic_reconfigure/ConfigDescription), latched
        - ``parameter_updates`` (dynamic_reconfigure/Config), latched

    :ROS Services:
        - ``set_parameters`` (dynamic_reconfigure/Reconfigure): all changes or,
          if one is rejected, none; the response holds the current values

    :param live: the parameters; the names above are in their namespace
    :param publisher: creates a publisher from a name, a type and ``latch``
    :param service: creates a service from a name, a type and a handler
    """

    def __init__(
        self,
        live: LiveParameters[Any],
        publisher: Callable[..., Any],
        service: Callable[..., Any],
    ) -> None:
        self._live = live
        name = live.namespace + "/%s"
        descriptions = publisher(name % "parameter_descriptions", ConfigDescription, latch=True)
        description = _description(type(live.values), live.takes_effect)  # type: ignore[arg-type]
        descriptions.publish(description)
        self._updates = publisher(name % "parameter_updates", Config, latch=True)
        service(name % "set_parameters", Reconfigure, self._set)
        #: Stops publishing changes.
        self.close = live.add_listener(self._publish)
        self._publish()

    def _publish(self) -> None:
        # Two threads may publish together: the values published last must be the current ones.
        published = None
        while published is not self._live.values:
            published = self._live.values
            self._updates.publish(_state(published))

    def _set(self, request: "ReconfigureRequest") -> "Config":
        parts = (request.config.bools, request.config.ints, request.config.doubles)
        changes = {item.name: item.value for part in parts for item in part}
        changes.update((item.name, item.value) for item in request.config.strs)
        held = on_wire(self._live.values)
        # Some clients send all values, also those that another client has just set.
        news = {n: v for n, v in changes.items() if n not in held or not is_same(v, held[n])}
        try:
            self._live.change(news)
        except ParameterError as error:
            rospy.logwarn("%s", error)
        except MasterUnreachable as error:
            rospy.logwarn("the master does not answer (%s): nothing is changed", error)
        return _state(self._live.values)


def _state(values: ParameterSet) -> "Config":
    """Return the message of values; nodes with default values share one."""
    kind: Any = type(values)
    return _defaults(kind) if values is kind.as_declared() else _config(_offered(values))


@functools.lru_cache(maxsize=None)
def _defaults(kind: Type[ParameterSet]) -> "Config":
    return _config(_offered(kind.as_declared()))


def _offered(values: ParameterSet) -> Dict[str, Any]:
    return {k: v for k, v in values.as_dict().items() if not isinstance(v, (tuple, bytes))}


@functools.lru_cache(maxsize=None)
def _description(kind: Type[ParameterSet], takes_effect: str) -> "ConfigDescription":
    declared = {k: p for k, p in kind.declared.items() if p.type_name in _TYPES}
    described = [
        ParamDescription(
            name, _TYPES[item.type_name], 0, _help(item, takes_effect), _edit_method(item)
        )
        for name, item in declared.items()
    ]
    return ConfigDescription(
        groups=[Group(_GROUP, "", described, 0, 0)],
        min=_config({name: _bounds(item)[0] for name, item in declared.items()}),
        max=_config({name: _bounds(item)[1] for name, item in declared.items()}),
        dflt=_config({name: item.default for name, item in declared.items()}),
    )


def _help(item: Parameter[Any], takes_effect: str) -> str:
    text = help_of(item, takes_effect)
    return f"{text} ({item.unit})" if item.unit else text


def _edit_method(item: Parameter[Any]) -> str:
    """Return the words of an enum in the notation that clients evaluate."""
    if not isinstance(item, EnumParameter):
        return ""
    words = [
        {"name": word, "type": "str", "value": word, "description": ""} for word in item.choices
    ]
    return repr({"enum": words, "enum_description": item.help})


def _bounds(item: Parameter[Any]) -> Any:
    """Return the limits as the tools show them, with open ends closed."""
    if item.type_name == "bool":
        return False, True
    if item.type_name not in ("int", "float"):
        return "", ""
    number, widest = (int, _INT_RANGE) if item.type_name == "int" else (float, _FLOAT_RANGE)
    ends = (
        next((end for end in pair if end is not None), limit)
        for pair, limit in zip(
            ((item.above, item.minimum), (item.below, item.maximum)),  # type: ignore[attr-defined]
            widest,
        )
    )
    return tuple(number(end) for end in ends)


def _config(values: Dict[str, Any]) -> "Config":
    config = config_of(values)
    config.groups.append(GroupState(_GROUP, True, 0, 0))
    return config


def config_of(values: Mapping[str, Any]) -> "Config":
    """Return the message of some values, without a group.

    :param values: booleans, numbers and text by name
    """
    config = Config()
    for name, value in values.items():
        if isinstance(value, bool):
            config.bools.append(BoolParameter(name, value))
        elif isinstance(value, int):
            config.ints.append(IntParameter(name, value))
        elif isinstance(value, float):
            config.doubles.append(DoubleParameter(name, value))
        else:
            config.strs.append(StrParameter(name, value))
    return config
