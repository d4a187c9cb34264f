"""Nodes and parameters of the launch files; no node is started."""

import functools
import os
from typing import Dict, List
from xml.dom import minidom

import pytest
import rospkg
import yaml
from roslaunch.config import ROSLaunchConfig

from motor_control.motor_parameters import MotorParameters
from motor_control.nodes.set_point import SetPointParameters
from nodekit.testing.launch_files import load_launch, private_parameters

PACKAGE = rospkg.RosPack().get_path("motor_control")
LAUNCH = os.path.join(PACKAGE, "launch")

load = functools.partial(load_launch, "motor_control")


def nodes(config: ROSLaunchConfig) -> Dict[str, str]:
    """Return the program of each node by its name."""
    return {node.namespace + node.name: node.type for node in config.nodes}


def pairs(groups: List[str]) -> Dict[str, str]:
    """Return the nodes of a motor and a set point in each of these groups."""
    motors = {group + "/motor_sys": "dc_motor.py" for group in groups}
    return {**motors, **{group + "/sp_gen": "set_point.py" for group in groups}}


def test_motor() -> None:
    assert nodes(load("motor.launch")) == pairs([""])


def test_motor_2() -> None:
    assert nodes(load("motor_2.launch")) == {
        "/group1/motor_sys_1": "dc_motor.py",
        "/group1/sp_gen_1": "set_point.py",
        "/group2/motor_sys_2": "dc_motor.py",
        "/group2/sp_gen_2": "set_point.py",
    }


def test_motor_3() -> None:
    assert nodes(load("motor_3.launch")) == pairs(["/group1", "/group2", "/group3"])


def test_managed_is_for_the_motor_alone() -> None:
    for text, is_managed in (("false", False), ("yes", True)):
        params = load("motor.launch", f"managed:={text}").params
        assert params["/motor_sys/managed"].value is is_managed
        assert "/sp_gen/managed" not in params


@pytest.mark.parametrize("count", [0, 1, 3, 10, 150])
def test_motors(count: int) -> None:
    groups = [f"/group{number}" for number in range(1, count + 1)]
    assert nodes(load("motors.launch", f"count:={count}")) == pairs(groups)


def test_every_motor_starts_from_the_defaults() -> None:
    config = load("motors.launch", "count:=2")
    for group in ("/group1", "/group2"):
        assert private_parameters(config, group + "/motor_sys") == MotorParameters().as_dict()
        set_point = SetPointParameters(**private_parameters(config, group + "/sp_gen"))
        assert set_point == SetPointParameters()


def test_params_go_over_the_defaults() -> None:
    config = load("motor_2.launch")
    expected = MotorParameters(sys_gain_K=4.0, sys_tau_T=0.9).as_dict()
    assert private_parameters(config, "/group1/motor_sys_1") == expected
    assert private_parameters(config, "/group2/motor_sys_2") == MotorParameters().as_dict()


def test_params_name_nodes_and_parameters_that_exist() -> None:
    started = nodes(load("motor_2.launch"))
    with open(os.path.join(PACKAGE, "config", "params.yaml")) as file:
        groups = yaml.safe_load(file)
    assert groups
    for group, members in groups.items():
        assert members, group
        for node, values in members.items():
            assert started[f"/{group}/{node}"] == "dc_motor.py"
            MotorParameters(**values)


def test_own_configuration_can_be_given() -> None:
    params = os.path.join(PACKAGE, "config", "set_point.yaml")
    config = load("motor.launch", "motor:=m", "set_point:=s", "motor_config:=" + params)
    assert set(nodes(config)) == {"/m", "/s"}
    assert private_parameters(config, "/m") == private_parameters(config, "/s")


@pytest.mark.parametrize("name", sorted(os.listdir(LAUNCH)))
def test_terminals_are_for_every_node_and_only_when_asked_for(name: str) -> None:
    found = load(name).nodes
    assert found
    for node in found:
        assert "xterm" not in (node.launch_prefix or "")
        assert node.output == "screen"
    for node in load(name, "terminals:=true").nodes:
        assert node.launch_prefix.startswith("xterm -e")


@pytest.mark.parametrize("name", sorted(os.listdir(LAUNCH)))
def test_every_argument_has_a_doc(name: str) -> None:
    root = minidom.parse(os.path.join(LAUNCH, name)).documentElement
    declared = [tag for tag in root.childNodes if tag.nodeName == "arg"]
    assert [tag.getAttribute("name") for tag in declared if not tag.getAttribute("doc")] == []
