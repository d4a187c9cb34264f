"""Tests of the parameters that launch files set; nothing is started."""

import functools
import pathlib

import pytest

from nodekit.testing.launch_files import load_launch, node_names, private_parameters
from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.plant.system_parameters import SystemParameters

load = functools.partial(load_launch, "pid_control")

THREE = ["/controller", "/set_point_generator", "/system"]


@pytest.mark.parametrize(
    "name, nodes",
    [
        ("motor_control", THREE),
        ("system", THREE[2:]),
        ("pid_real", THREE[:2]),
        ("model", ["/model"]),
    ],
)
def test_each_file_starts_its_nodes(name: str, nodes: list) -> None:
    config = load(name + ".launch")
    assert node_names(config) == nodes
    for node in config.nodes:
        assert node.output == "screen" and "xterm" not in (node.launch_prefix or "")
    for node in load(name + ".launch", "terminals:=true").nodes:
        assert node.launch_prefix.startswith("xterm -e")


def test_files_of_the_motor_and_of_the_controller_hold_the_declared_defaults() -> None:
    config = load("motor_control.launch")
    assert private_parameters(config, "/system") == SystemParameters().as_dict()
    defaults = ControllerParameters().as_dict()
    held = private_parameters(config, "/controller")
    assert held == {name: defaults[name] for name in held}


def test_other_files_can_be_given(tmp_path: pathlib.Path) -> None:
    """Course 003-pid-4."""
    arguments = []
    for argument in ("system_config", "control_config", "set_point_config"):
        file = tmp_path / f"{argument}.yaml"
        file.write_text(f"mark: {argument}\n")
        arguments.append(f"{argument}:={file}")
    config = load("motor_control.launch", *arguments)
    for node, argument in zip(THREE, ("control_config", "set_point_config", "system_config")):
        assert private_parameters(config, node) == {"mark": argument}


def test_scope_shows_all_three_signals() -> None:
    """Course 003-pid-5."""
    config = load("motor_control.launch", "scope:=true")
    (scope,) = [node for node in config.nodes if node.package == "topic_scope"]
    values = dict(scope.env_args)
    assert values["SCOPE_FIELDS"] == "set_point/setPoint motor_output/output"
    assert values["SCOPE_BELOW"] == "motor_input/input"


def test_managed_reaches_the_motor() -> None:
    for text, is_managed in (("false", False), ("yes", True)):
        params = load("system.launch", f"managed:={text}").params
        assert params["/system/managed"].value is is_managed


def test_model_launch_shares_input_and_remaps_output(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "model.yaml"
    file.write_text("system_param_K: 5.0\n")
    config = load("model.launch", f"model:={file}", "scope:=true")
    (model,) = [node for node in config.nodes if node.package == "pid_control"]
    assert [tuple(pair) for pair in model.remap_args] == [("motor_output", "model_output")]
    assert private_parameters(config, "/model") == {"system_param_K": 5.0}
    (scope,) = [node for node in config.nodes if node.package == "topic_scope"]
    assert dict(scope.env_args)["SCOPE_FIELDS"] == "motor_output/output model_output/output"
