"""Parameters of a ROS 1 node with dynamic_reconfigure, as ROS 2 sees and sets them."""

from types import SimpleNamespace
from typing import Any, Callable, Dict, List

import pytest
from dynamic_reconfigure.msg import (
    BoolParameter,
    Config,
    ConfigDescription,
    DoubleParameter,
    Group,
    IntParameter,
    ParamDescription,
    StrParameter,
)

from nodekit import CallError, MasterUnreachable
from ros2_bridge.parameters import reconfigured_parameters, ros1_parameters
from ros2_bridge.parameters.reconfigured_parameters import ReconfiguredParameters
from ros2_bridge.parameters.ros1_parameters import (
    DescribedParameters,
    ServerParameters,
    UnreadableParameters,
)
from ros2_bridge.parameters.values import DOUBLE, INTEGER, STRINGS

CHOICES = "{'enum': [{'name': 'Slow', 'value': 0}, {'name': 'Fast', 'value': 2}]}"
#: Name, type and edit_method of each parameter.
DESCRIBED = (
    ("gain", "double", ""),
    ("mode", "int", CHOICES),
    ("on", "bool", ""),
    ("id", "str", ""),
)
DESCRIPTION = ConfigDescription(
    groups=[
        Group(parameters=[ParamDescription(name, kind, 0, name, edit)])
        for name, kind, edit in DESCRIBED
    ],
    min=Config(doubles=[DoubleParameter("gain", 0.0)], ints=[IntParameter("mode", 0)]),
    max=Config(doubles=[DoubleParameter("gain", 2.0)], ints=[IntParameter("mode", 5)]),
)
VALUES = Config(
    bools=[BoolParameter("on", False)],
    ints=[IntParameter("mode", 0)],
    strs=[StrParameter("id", "left")],
    doubles=[DoubleParameter("gain", 1.0)],
)


class Node:
    """Fake node, its parameter server and its service, which answers with ``config``."""

    def __init__(self) -> None:
        self.callbacks: Dict[str, Callable[[Any], None]] = {}
        self.server: Dict[str, Any] = {"/camera": {"names": ["a"], "odd": [1, "a"]}}
        self.sent: List[Any] = []
        self.config = VALUES

    def create_subscription(self, topic: str, _: Any, callback: Callable[[Any], None]) -> None:
        self.callbacks[topic] = callback

    def read(self, names: List[str]) -> Any:
        return SimpleNamespace(values={name: self.server.get(name) for name in names})

    def write(self, values: Dict[str, Any]) -> None:
        self.server.update(values)

    def call(self, service: str, _: Any, config: Any, timeout: float) -> Any:
        assert service == "/camera/set_parameters" and timeout > 0.0
        self.sent.append(config)
        return SimpleNamespace(result=lambda: SimpleNamespace(config=self.config))


@pytest.fixture
def node(monkeypatch: "pytest.MonkeyPatch") -> Node:
    made = Node()
    monkeypatch.setattr(reconfigured_parameters, "call_service", made.call)
    return made


@pytest.fixture
def parameters(node: Node) -> ReconfiguredParameters:
    scope: Any = node
    made = ReconfiguredParameters(scope, "/camera", scope)
    node.callbacks["/camera/parameter_descriptions"](DESCRIPTION)
    node.callbacks["/camera/parameter_updates"](VALUES)
    return made


def test_values_of_node_and_server_are_read(node: Node, parameters: ReconfiguredParameters) -> None:
    node.server["/use_sim_time"] = True
    found = parameters.read()
    assert {name: one.value for name, one in found.items()} == {
        **{"names": ["a"], "use_sim_time": True},  # ROS 2 has no type for the others
        **{"gain": 1.0, "mode": 0, "on": False, "id": "left"},
    }
    assert [found[name].kind for name in ("gain", "mode", "names")] == [DOUBLE, INTEGER, STRINGS]


def test_described_parameters_without_values_are_not_there_yet(node: Node) -> None:
    scope: Any = node
    parameters = ReconfiguredParameters(scope, "/camera", scope)
    node.callbacks["/camera/parameter_descriptions"](DESCRIPTION)
    assert sorted(parameters.read()) == ["names", "use_sim_time"]
    node.callbacks["/camera/parameter_updates"](Config(ints=[IntParameter("mode", 2)]))
    assert sorted(parameters.read()) == ["mode", "names", "use_sim_time"]


def test_nothing_is_changed_before_the_node_has_described_its_parameters(node: Node) -> None:
    scope: Any = node
    why = ReconfiguredParameters(scope, "/camera", scope).change({"gain": 1.5})
    assert why == "/camera has not described its parameters yet; try again"
    assert not node.sent and "/camera/gain" not in node.server


@pytest.mark.parametrize("entries", [{"gain": {}}, {"gain": None}, {"gain": {"value": 1}}])
def test_malformed_description_is_an_error_of_its_node(
    node: Node, monkeypatch: "pytest.MonkeyPatch", entries: Any
) -> None:
    def client(*_: Any) -> Any:
        return SimpleNamespace(describe=lambda: entries)

    monkeypatch.setattr(ros1_parameters, "ParameterClient", client)
    fake: Any = node
    with pytest.raises(UnreadableParameters, match="malformed description of /camera: "):
        DescribedParameters(fake, "/camera").read()


def test_node_or_master_that_does_not_answer_is_the_reason(
    node: Node, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    def fail(*_: Any) -> Any:
        raise CallError("/camera/describe: no answer")

    def is_gone(*_: Any) -> Any:
        raise MasterUnreachable("http://localhost:1")

    client = SimpleNamespace(describe=fail, change=fail)
    monkeypatch.setattr(ros1_parameters, "ParameterClient", lambda *_: client)
    fake: Any = node
    described, plain = DescribedParameters(fake, "/camera"), ServerParameters(fake, "/camera")
    with pytest.raises(UnreadableParameters, match="^/camera/describe: no answer$"):
        described.read()
    assert described.change({"gain": 1.0}) == "/camera/describe: no answer"
    monkeypatch.setattr(node, "read", is_gone)
    monkeypatch.setattr(node, "lookup_service", is_gone, raising=False)
    with pytest.raises(UnreadableParameters, match="http://localhost:1"):
        plain.read()
    assert "http://localhost:1" in plain.change({"gain": 1.0})


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("gain", 2.5, "refused 2.5: must be from 0.0 to 2.0"),
        ("gain", True, "refused True: must be of type float"),
        ("mode", 1, "refused 1: must be one of [0, 2]"),
        ("mode", 6, "refused 6: must be from 0 to 5"),
        ("mode", 2.0, "refused 2.0: must be of type int"),
        ("on", 1, "refused 1: must be of type bool"),
        ("id", 1, "refused 1: must be of type str"),
    ],
)
def test_invalid_value_is_refused_and_nothing_is_sent(
    node: Node, parameters: ReconfiguredParameters, name: str, value: Any, reason: str
) -> None:
    assert parameters.change({"names": ["b"], name: value}) == f"{name}: {reason}"
    assert not node.sent and "/camera/names" not in node.server


def test_each_value_goes_to_the_node_or_to_the_server(
    node: Node, parameters: ReconfiguredParameters
) -> None:
    node.config = Config(
        bools=[BoolParameter("on", True)],
        ints=[IntParameter("mode", 2)],
        strs=[StrParameter("id", "left")],
        doubles=[DoubleParameter("gain", 1.5)],
    )
    assert parameters.change({"gain": 2, "mode": 2, "on": True, "names": ["b"]}) == (
        "gain: /camera has set it to 1.5"
    )
    (sent,) = node.sent
    assert (sent.doubles, sent.ints) == ([DoubleParameter("gain", 2.0)], [IntParameter("mode", 2)])
    assert (sent.bools, sent.strs) == ([BoolParameter("on", True)], [])
    assert (node.server["/camera/names"], len(node.server)) == (["b"], 2)
    found = parameters.read()  # before the node publishes its update
    assert [found[name].value for name in ("gain", "mode", "on")] == [1.5, 2, True]
    assert parameters.caution(["gain", "names"]).startswith(
        "names: written to the parameter server"
    )
