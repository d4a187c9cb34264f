"""Nodes and parameters of the launch files; no node is started."""

import functools
import os
from typing import Any, Dict

import pytest
import rospkg
import yaml
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException

from nodekit import ParameterError
from nodekit.testing.launch_files import load_launch, node_names
from parameters_demo.nodes.camera_demo import CameraDemoParameters
from parameters_demo.nodes.lidar_demo import LidarDemoParameters
from parameters_demo.nodes.processing_demo import ProcessingDemoParameters
from parameters_demo.nodes.radar_demo import RadarDemoParameters

PACKAGE = rospkg.RosPack().get_path("parameters_demo")
load = functools.partial(load_launch, "parameters_demo")
DECLARED = {
    "camera_demo": CameraDemoParameters,
    "lidar_demo": LidarDemoParameters,
    "radar_demo": RadarDemoParameters,
    "processing_demo": ProcessingDemoParameters,
}
#: Values in parameters_demo.yaml and demo1.launch.
EXPECTED = {
    "/camera_demo/camera_name": "front_camera",
    "/camera_demo/camera_rate": 30,
    "/lidar_demo/lidar_name": "top_lidar",
    "/lidar_demo/lidar_rate": 20,
    "/radar_demo/radar_name": "front_radar",
    "/radar_demo/radar_rate": 60,
    "/processing_demo/processing_mode": "all",
    "/processing_demo/processing_rate": 10,
}


def parameters(config: ROSLaunchConfig) -> Dict[str, Any]:
    return {name: parameter.value for name, parameter in config.params.items()}


def in_file(name: str) -> Any:
    with open(os.path.join(PACKAGE, "config", name)) as file:
        return yaml.safe_load(file)


@pytest.mark.parametrize("name", ["demo1.launch", "demo2.launch"])
def test_demo1_and_demo2_set_the_same(name: str) -> None:
    """Course 001-params-7, 001-params-8."""
    config = load(name)
    assert parameters(config) == EXPECTED
    assert node_names(config) == sorted("/" + node for node in DECLARED)


def test_the_file_of_the_demos_is_taken_by_each_node() -> None:
    """Course 001-params-5."""
    held = in_file("parameters_demo.yaml")
    assert set(held) == set(DECLARED)
    for node, values in held.items():
        assert set(DECLARED[node](**values).as_dict()) - set(values) <= {"lidar_model"}
        for name, value in values.items():
            assert EXPECTED[f"/{node}/{name}"] == value


def test_demo3_sets_its_arguments_last() -> None:
    """Course 001-params-9."""
    more = {"/lidar_demo/lidar_model": "OS2"}
    assert parameters(load("demo3.launch")) == {**EXPECTED, **more}
    typed = ["lidar_model:=OS1", "processing_mode:=lidar_only", "processing_rate:=5"]
    more = {"/lidar_demo/lidar_model": "OS1", "/processing_demo/processing_mode": "lidar_only"}
    expected = {**EXPECTED, **more, "/processing_demo/processing_rate": 5}
    assert parameters(load("demo3.launch", *typed)) == expected


def test_demo4_starts_two_cameras_on_topics_of_their_own() -> None:
    """Course 001-params-6, 001-params-10."""
    config = load("demo4.launch")
    held = in_file("two_cameras_params.yaml")
    assert node_names(config) == sorted("/" + node for node in held)
    for number, name in ((1, "right_side_camera"), (2, "left_side_camera")):
        node = f"camera{number}_demo"
        values = {key: value for key, value in parameters(config).items() if node in key}
        assert values == {f"/{node}/camera_name": name, f"/{node}/camera_rate": 40}
        assert CameraDemoParameters(**held[node]).camera_rate == 40
        (found,) = [one for one in config.nodes if one.name == node]
        topics = [f"camera/{topic}" for topic in ("image_color", "camera_info")]
        expected = [[topic, topic.replace("camera/", f"camera{number}/", 1)] for topic in topics]
        assert found.remap_args == expected


def test_camera_rate_has_the_range_of_both_slides() -> None:
    """Course err-4."""
    rate = CameraDemoParameters.declared["camera_rate"]
    assert (rate.default, rate.allowed) == (60, "a whole number in [10, 80] in steps of 10 (Hz)")
    assert (rate.coerce(60), rate.coerce(70)) == (60, 70)
    with pytest.raises(ParameterError):
        rate.coerce(90)


def test_talker_and_listener_use_topic_argument() -> None:
    """Course 004-bridge-5, 004-bridge-8."""
    config = load("talker_listener_launch.launch")
    assert node_names(config) == ["/robot1/listener", "/robot1/talker"]
    assert all(node.remap_args == [["chatter", "messages"]] for node in config.nodes)
    assert parameters(config)["/robot1/talker/publish_rate"] == 2.0
    typed = ["rate:=5.0", "prefix:=r2", "topic_name:=my_topic", "message_prefix:=007"]
    config = load("talker_listener_launch.launch", *typed)
    assert node_names(config) == ["/r2/listener", "/r2/talker"]
    assert all(node.remap_args == [["chatter", "my_topic"]] for node in config.nodes)
    expected = {"/r2/talker/publish_rate": 5.0, "/r2/talker/message_prefix": "007"}
    assert parameters(config) == expected


def test_features_simulates_waits_includes_and_groups() -> None:
    """Course 004-bridge-6."""
    config = load("features.launch")
    robot = ["/robot1/controller_node", "/robot1/sensor_node"]
    assert node_names(config) == ["/late_starter", "/listener", *robot, "/sim_node", "/talker"]
    config = load("features.launch", "use_sim:=false", "delay:=0.5")
    assert node_names(config) == ["/late_starter", "/listener", *robot, "/talker"]
    (late,) = [node for node in config.nodes if node.name == "late_starter"]
    assert late.env_args == [("DELAY", "0.5")] and 'sleep "$DELAY"' in late.launch_prefix
    with pytest.raises(RLException):
        load("features.launch", "delay:=0; echo x")
