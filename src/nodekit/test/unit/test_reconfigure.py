"""Tests of dynamic_reconfigure's interface, without a master."""

from types import SimpleNamespace
from typing import Any, Callable, Dict, List

import pytest
import rospy
from dynamic_reconfigure.srv import ReconfigureRequest

from nodekit import BoolParameter, EnumParameter, FloatParameter, IntParameter, ParameterSet
from nodekit.parameter_server.reconfigure import ReconfigureInterface, config_of
from nodekit.testing.offline_parameters import OfflineParameters


class Lamp(ParameterSet):
    """One parameter of each type that the interface has."""

    on = BoolParameter(True, help="")
    count = IntParameter(3, minimum=1, maximum=9, help="")
    level = FloatParameter(0.5, above=0.0, help="")
    colour = EnumParameter("red", choices=("red", "green"), help="")


class Interface:
    """Interface of parameters: what it publishes, and its service."""

    def __init__(self) -> None:
        self.parameters = OfflineParameters(Lamp)
        self.published: Dict[str, List[Any]] = {}
        self.call: Callable[[ReconfigureRequest], Any]
        setattr(self.parameters, "namespace", "/lamp")
        setattr(self.parameters, "takes_effect", "")
        setattr(self.parameters, "add_listener", lambda listener: lambda: None)
        live: Any = self.parameters
        ReconfigureInterface(live, self._publisher, self._serve)

    def _publisher(self, name: str, _data_class: type, latch: bool) -> Any:
        assert latch
        return SimpleNamespace(publish=self.published.setdefault(name, []).append)

    def _serve(self, _name: str, _service_class: type, handler: Callable[[Any], Any]) -> None:
        self.call = handler

    def set(self, **values: Any) -> Dict[str, Any]:
        """Call the service; return the values in its response."""
        return values_in(self.call(ReconfigureRequest(config_of(values))))


def values_in(config: Any) -> Dict[str, Any]:
    parts = (config.bools, config.ints, config.doubles, config.strs)
    return {item.name: item.value for part in parts for item in part}


def test_description_has_limits_and_default_of_each_parameter() -> None:
    (description,) = Interface().published["/lamp/parameter_descriptions"]
    defaults = {"on": True, "count": 3, "level": 0.5, "colour": "red"}
    assert values_in(description.dflt) == defaults
    assert set(values_in(description.min)) == set(values_in(description.max)) == set(defaults)
    assert [item.name for item in description.groups[0].parameters] == list(defaults)


def test_change_with_an_unknown_name_is_refused_with_the_nearest(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    warnings: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: warnings.append(text % values))
    interface = Interface()
    assert interface.set(count=5, levle=0.7)["count"] == 3
    assert len(warnings) == 1
    assert "levle: refused 0.7" in warnings[0] and "did you mean level?" in warnings[0]
    assert interface.set(count=5, level=0.7)["level"] == 0.7
    assert len(warnings) == 1
