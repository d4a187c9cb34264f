"""Parameters that the launch files give to the node; no node is started."""

import functools
import os
from typing import Any, Dict, List, Tuple
from xml.dom import minidom

import pytest
import rospkg

from first_order_sys_sim.system_parameters import SystemParameters
from nodekit.testing.launch_files import load_launch, node_names, private_parameters

LAUNCH = os.path.join(rospkg.RosPack().get_path("first_order_sys_sim"), "launch")
NODE = "/first_order_sys"

load = functools.partial(load_launch, "first_order_sys_sim")

#: For each argument of system.launch its parameter, and a value other than the default.
ARGUMENTS: Dict[str, Tuple[str, Any]] = {
    "system_gain": ("system_param_K", 2.5),
    "system_tau": ("system_param_T", 0.3),
    "sample_time": ("system_sample_time", 0.1),
    "node_rate": ("system_node_rate", 50.0),
    "initial_conditions": ("system_initial_conditions", 1.0),
    "max_output": ("system_max_output", 5.0),
    "min_input": ("system_min_input", 0.5),
    "method": ("method", "euler"),
}


def children(root: minidom.Element, name: str) -> List[minidom.Element]:
    """Return the tags of a type directly below the root of a launch file."""
    return [tag for tag in root.childNodes if tag.nodeName == name]


def test_system_has_the_declared_defaults() -> None:
    assert private_parameters(load("system.launch"), NODE) == SystemParameters().as_dict()


def test_arguments_reach_parameters_with_same_help() -> None:
    root = minidom.parse(os.path.join(LAUNCH, "system.launch")).documentElement
    docs = {
        tag.getAttribute("name"): tag.getAttribute("doc")
        for tag in children(root, "arg")
        if not tag.hasAttribute("value")
    }
    assert set(docs) == {*ARGUMENTS, "terminals", "managed"}
    for argument, (name, value) in ARGUMENTS.items():
        expected = SystemParameters(**{name: value}).as_dict()
        assert private_parameters(load("system.launch", f"{argument}:={value}"), NODE) == expected
        declared = SystemParameters.declared[name]
        unit = f" [{declared.unit}]" if declared.unit else ""
        choices = f" {declared.range}" if declared.type_name == "enum" else ""
        assert docs[argument] == declared.help + unit + choices


def test_managed_reaches_the_node() -> None:
    for text, is_managed in (("false", False), ("yes", True)):
        params = load("system.launch", f"managed:={text}").params
        assert params[NODE + "/managed"].value is is_managed


def test_tuned_overrides_three_arguments_and_keeps_the_rest() -> None:
    expected = SystemParameters(
        system_param_K=10.0, system_param_T=0.1, system_min_input=0.05
    ).as_dict()
    assert private_parameters(load("system_tuned.launch"), NODE) == expected


def test_tuned_hands_its_own_arguments_on() -> None:
    arguments = ["system_gain:=7", "system_tau:=0.7", "min_input:=0.01"]
    got = private_parameters(load("system_tuned.launch", *arguments), NODE)
    assert (got["system_param_K"], got["system_param_T"], got["system_min_input"]) == (7, 0.7, 0.01)


def test_chain_remaps_the_input_of_the_system_only() -> None:
    config = load("cw1_system.launch", "system_gain:=2", "system_tau:=0.5")
    assert node_names(config) == ["/first_order_sys", "/process", "/signal_generator"]
    remaps = {node.name: node.remap_args for node in config.nodes}
    assert remaps["first_order_sys"] == [["input", "proc_signal"]]
    assert remaps["process"] == remaps["signal_generator"] == []
    got = private_parameters(config, NODE)
    assert (got["system_param_K"], got["system_param_T"]) == (2.0, 0.5)


@pytest.mark.parametrize("name", sorted(os.listdir(LAUNCH)))
def test_terminals_are_for_every_node_and_only_when_asked_for(name: str) -> None:
    found = load(name).nodes
    assert found
    for node in found:
        assert "xterm" not in (node.launch_prefix or "")
        assert node.output == "screen"
    for node in load(name, "terminals:=true").nodes:
        assert node.launch_prefix.startswith("xterm -e")
