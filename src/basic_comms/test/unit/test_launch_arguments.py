"""Arguments of launch files match the nodes' declarations: names, defaults and help.

After a change of a declaration, copy the missing text of a failure into the launch file.
"""

from typing import Any, Dict, Type

import pytest
import yaml
from launch_loading import listed_arguments, load

from basic_comms.nodes.process import ProcessParameters
from basic_comms.nodes.talker import TalkerParameters
from basic_comms.signals.signal_parameters import SignalParameters
from nodekit import Parameter, ParameterSet, to_wire

#: Launch file, prefix of its arguments, declaration of the node, name of the node.
NODES = [
    ("signal_gen.launch", "", SignalParameters, "signal_generator"),
    ("cw1.launch", "signal_", SignalParameters, "signal_generator"),
    ("process.launch", "", ProcessParameters, "process"),
    ("cw1.launch", "process_", ProcessParameters, "process"),
]
#: Arguments that are not parameters of a node.
OWN = {"terminals", "managed", "ns", "plot", "record", "record_prefix"}

Declaration = Type[ParameterSet]


def doc_of(parameter: Parameter[Any]) -> str:
    """Return the doc of a launch file's argument: help, unit and choices."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    choices = f" {parameter.range}" if parameter.type_name == "enum" else ""
    return parameter.help + unit + choices


@pytest.mark.parametrize("name, start, declaration, node", NODES)
def test_defaults_and_docs_are_those_declared(
    name: str, start: str, declaration: Declaration, node: str
) -> None:
    listed = listed_arguments(name)
    said = {
        argument: (yaml.safe_load(default), doc)
        for argument, (doc, default) in listed.items()
        if argument not in OWN and argument.startswith(start)
    }
    declared = {
        start + key: (to_wire(parameter.default), doc_of(parameter))
        for key, parameter in declaration.declared.items()
    }
    assert said == declared


def test_cw1_has_no_arguments_but_those_of_its_nodes() -> None:
    starts = ("signal_", "process_")
    rest = {argument for argument in listed_arguments("cw1.launch") if argument not in OWN}
    assert {argument for argument in rest if not argument.startswith(starts)} == set()


@pytest.mark.parametrize("name, start, declaration, node", NODES)
def test_every_argument_reaches_its_parameter(
    name: str, start: str, declaration: Declaration, node: str
) -> None:
    wanted = {
        key: unlike(parameter, number)
        for number, (key, parameter) in enumerate(declaration.declared.items(), start=1)
    }
    arguments = [f"{start}{key}:={as_text(value)}" for key, value in wanted.items()]
    prefix = f"/{node}/"
    found = {
        key[len(prefix) :]: parameter.value
        for key, parameter in load(name, *arguments).params.items()
        if key.startswith(prefix)
    }
    assert found.pop("managed") is False
    assert found == wanted


@pytest.mark.parametrize("name", ["signal_gen.launch", "process.launch"])
def test_managed_reaches_the_node(name: str) -> None:
    (node,) = load(name).nodes
    for text, is_managed in (("true", True), ("on", True), ("no", False)):
        assert load(name, f"managed:={text}").params[f"/{node.name}/managed"].value is is_managed


def unlike(parameter: Parameter[Any], number: int) -> Any:
    """Return a value of a parameter's type that is neither its default nor another's value."""
    default = to_wire(parameter.default)
    if isinstance(default, bool):
        return not default
    if isinstance(default, (int, float)):
        return type(default)(default + 1000 * number)
    if isinstance(default, list):
        return [1000.5 * number]
    return f"text{number}"


def as_text(value: Any) -> str:
    """Return a value as it is typed on the command line."""
    return str(value).lower() if isinstance(value, bool) else str(value)


@pytest.mark.parametrize(
    "name, arguments",
    [
        ("talker_listener.launch", {"rate": "rate", "scope": "message_scope"}),
        ("include/talker_listener.xml", {"rate": "rate", "scope": "message_scope"}),
        ("include/talker.xml", {"rate": "rate", "scope": "message_scope"}),
        ("activity1.launch", {"scope": "message_scope"}),
        ("activity2.launch", {"scope": "message_scope"}),
        ("activity3.launch", {"scope": "message_scope"}),
    ],
)
def test_defaults_of_the_talkers_arguments(name: str, arguments: Dict[str, str]) -> None:
    listed = listed_arguments(name)
    assert arguments
    for argument, parameter in arguments.items():
        default = yaml.safe_load(listed[argument][1])
        assert default == to_wire(TalkerParameters.declared[parameter].default)
