"""Tests of finding the controller that a command line names, and its parameters."""

import pathlib

from pid_control.runner.controller_command import find_controller, find_files


def test_find_files_skips_hidden_folders(tmp_path: pathlib.Path) -> None:
    for folder in (".git/kept", "scripts", "scripts/.old"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "controller.py").write_text("")
    found = [str(tmp_path / "scripts" / "controller.py")]
    assert find_files(str(tmp_path), "controller.py") == found


def test_find_controller_separates_parameters_of_other_nodes(tmp_path: pathlib.Path) -> None:
    launch = tmp_path / "loop.launch"
    launch.write_text(
        """<launch>
          <param name="limit" value="1.0"/>
          <node pkg="pid_control" type="system.py" name="loop">
            <param name="system_param_K" value="2.0"/>
          </node>
          <group ns="loop">
            <node pkg="pid_control" type="controller.py" name="controller">
              <param name="kp" value="0.5"/>
            </node>
            <node pkg="pid_control" type="controller.py" name="controller2">
              <param name="kp" value="0.7"/>
            </node>
          </group>
        </launch>"""
    )
    target = find_controller([str(launch)], "controller")
    parameters = target.parameters.items()
    assert parameters >= {"/limit": 1.0, "/loop/controller/kp": 0.5}.items()
    assert not parameters & target.of_others.items()
    assert target.of_others == {"/loop/system_param_K": 2.0, "/loop/controller2/kp": 0.7}
