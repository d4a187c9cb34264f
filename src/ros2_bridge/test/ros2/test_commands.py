"""The commands of the ROS 2 courses, for nodes of ROS 1: docs/ros2_course.md."""

import statistics
import sys
from typing import Any, Dict, Iterator, List

import both
import pytest
import rospy
from ament_index_python.packages import get_package_share_directory
from ament_index_python.resources import get_resource
from rcl_interfaces.msg import Parameter, ParameterType
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from test_parameters import get, set_one, value

NODE = "/parameterized_node"


@pytest.fixture(scope="module")
def node(bridge: both.Bridge) -> Iterator[both.Running]:
    with both.Running("my_robot_package", "parameterized_node") as running:
        yield running


@pytest.fixture(scope="module")
def camera(bridge: both.Bridge) -> Iterator[both.Running]:
    with both.Running("parameters_demo", "camera_demo") as running:
        yield running


def names(ros: both.Both) -> List[str]:
    return list(ros.call2(ListParameters, f"{NODE}/list_parameters").result.names)


def test_param_list_and_get(ros: both.Both, node: both.Running) -> None:
    """Course 001-command-1, 001-command-2."""
    assert {"robot_name", "max_velocity", "safety_mode", "use_sim_time"} <= set(names(ros))
    assert get(ros, "max_velocity", "safety_mode", "robot_name", node=NODE)[:2] == [1.0, True]


def test_param_set(ros: both.Both, node: both.Running) -> None:
    """Course 001-command-3."""
    assert set_one(ros, "max_velocity", 2.5, NODE).successful
    node.wait_for_log("Max velocity updated to: 2.5")
    result = set_one(ros, "max_velocity", -1.0, NODE)
    assert not result.successful
    assert result.reason.endswith("refused -1: must be a number in [0, 100] (m/s)")


def test_param_describe(ros: both.Both, node: both.Running) -> None:
    """Course 001-command-7."""
    request: Dict[str, Any] = {"names": ["max_velocity"]}
    (found,) = ros.call2(DescribeParameters, f"{NODE}/describe_parameters", **request).descriptors
    assert found.description == "speed limit of the robot (m/s)"
    (limits,) = found.floating_point_range
    assert (limits.from_value, limits.to_value) == (0.0, 100.0)


def test_param_delete_is_refused(ros: both.Both, node: both.Running) -> None:
    """Course 001-command-4."""
    nothing = Parameter(name="max_velocity")
    assert nothing.value.type == ParameterType.PARAMETER_NOT_SET
    service = f"{NODE}/set_parameters"
    (result,) = ros.call2(SetParameters, service, parameters=[nothing]).results
    assert not result.successful
    assert "max_velocity cannot be removed" in result.reason


def test_param_dump_and_load(ros: both.Both, node: both.Running) -> None:
    """Course 001-command-5, 001-command-6."""
    kept = [name for name in names(ros) if name != "use_sim_time"]
    dumped = dict(zip(kept, get(ros, *kept, node=NODE)))
    assert set_one(ros, "max_velocity", 7.0, NODE).successful
    values = [value(name, plain) for name, plain in dumped.items()]
    results = ros.call2(SetParameters, f"{NODE}/set_parameters", parameters=values).results
    assert [result.successful for result in results] == [True] * len(kept)
    assert get(ros, *kept, node=NODE) == list(dumped.values())


def test_param_use_sim_time_is_that_of_all_nodes(ros: both.Both, node: both.Running) -> None:
    assert get(ros, "use_sim_time", node=NODE) == [False]
    rospy.set_param("/use_sim_time", True)
    assert get(ros, "use_sim_time", node=NODE) == [True]
    rospy.delete_param("/use_sim_time")
    result = set_one(ros, "use_sim_time", True, NODE)
    assert not result.successful
    assert result.reason.endswith("rosparam set /use_sim_time")


def test_camera_is_set_and_its_topic_timed(ros: both.Both, camera: both.Running) -> None:
    """Course 001-params-11, 001-params-12, 001-params-13, 001-command-10."""
    service = "/camera_demo/describe_parameters"
    (rates,) = ros.call2(DescribeParameters, service, names=["camera_rate"]).descriptors
    (limits,) = rates.integer_range
    assert (limits.from_value, limits.to_value, limits.step) == (10, 80, 10)
    for rate, is_good in ((5, False), (15, False), (70, True), (90, False), (20, True)):
        assert set_one(ros, "camera_rate", rate, "/camera_demo").successful is is_good, rate
    assert set_one(ros, "camera_name", "front_facing_camera", "/camera_demo").successful
    camera.wait_for_log("front_facing_camera")
    recorder = ros.hear2("/camera/image_color", Image)
    recorder.wait(30)
    recorder.end()
    stamps = [image.header.stamp for image in recorder.heard]
    times = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
    gaps = [later - earlier for earlier, later in zip(times, times[1:])]
    assert statistics.median(gaps) == pytest.approx(0.05, abs=0.01)


def test_service_list_type_find_and_call(ros: both.Both, camera: both.Running) -> None:
    service = "/camera_demo/slow_down"
    answer = ros.call2(Trigger, service)
    assert (answer.success, answer.message) == (True, "camera_rate is 40")
    offered = dict(ros.node.get_service_names_and_types())
    assert offered[service] == ["std_srvs/srv/Trigger"]
    found = [name for name, types in offered.items() if "std_srvs/srv/Trigger" in types]
    assert service in found


def test_interface_show_and_list(monkeypatch: "pytest.MonkeyPatch") -> None:
    """Course 001-command-11, 001-if-1."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", sys.prefix)  # as ci/ros2 does
    listed, prefix = get_resource("rosidl_interfaces", "robot_custom_interfaces")
    assert "msg/RobotStatus.msg" in listed.splitlines()
    services, _ = get_resource("rosidl_interfaces", "my_robot_package_interfaces")
    assert "srv/AddTwoInts.srv" in services.splitlines()
    share = get_package_share_directory("robot_custom_interfaces")
    assert share.startswith(prefix)
    with open(f"{share}/msg/RobotStatus.msg", encoding="utf-8") as file:
        shown = [line.partition("#")[0].split() for line in file]
    assert ["string", "robot_name"] in shown
