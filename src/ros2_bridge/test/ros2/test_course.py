"""The course's launch files with the bridge, and the corresponding ROS 2 commands."""

import signal
import subprocess
from typing import Iterator, List

import both
import pytest
import rospy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import Float32

from basic_comms.msg import SignalMsg
from nodekit.testing.waiting import TIMEOUT_S, wait_until

LAUNCHED = (
    ("basic_comms", "cw1.launch"),
    (
        "ros2_bridge",
        "bridge.launch",
        "deny:=['/proc_signal']",
        "direction:=to_ros2",
        "remap:=['/lab=/elsewhere']",
        "qos_file:={file}",
    ),
)


@pytest.fixture(scope="module")
def course(ros: both.Both, tmp_path_factory: "pytest.TempPathFactory") -> Iterator[None]:
    file = tmp_path_factory.mktemp("course") / "qos.yaml"
    file.write_text("qos: [{topic: /sig*, durability: transient_local, depth: 5}]")
    running: List["subprocess.Popen[bytes]"] = []
    rospy.set_param("/run_id", "tests")  # or each would give the master another one
    try:
        for arguments in LAUNCHED:
            command = ["roslaunch", *(argument.format(file=file) for argument in arguments)]
            running.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))
        yield
    finally:
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            process.wait(TIMEOUT_S)


def test_signal_is_right_and_its_generator_is_set(ros: both.Both, course: None) -> None:
    recorder = ros.hear2("/signal", SignalMsg)
    first = recorder.wait(3)[0]
    assert first.amplitude == 2.0
    assert abs(first.frequency - 6.2831853) < 1e-6
    service = "/signal_generator/set_parameters"
    for value, is_good in ((0.5, True), (-1.0, False)):
        request = [Parameter("amplitude", value=value).to_parameter_msg()]
        (result,) = ros.call2(SetParameters, service, parameters=request).results
        assert result.successful is is_good
    assert "refused -1" in result.reason
    wait_until(lambda: recorder.heard[-1].amplitude == 0.5, lambda: str(recorder.heard[-1]))
    recorder.end()


def test_quality_of_service_is_that_of_the_file(ros: both.Both, course: None) -> None:
    wait_until(lambda: ros.node.count_publishers("/signal"), lambda: "no /signal")
    (found,) = ros.node.get_publishers_info_by_topic("/signal")
    assert found.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    recorder = ros.hear2("/signal", SignalMsg, latched=True)
    recorder.wait()  # the messages from now on are kept for late subscribers
    later = ros.hear2("/signal", SignalMsg, latched=True)
    assert later.wait(2)[0].time_x <= recorder.heard[-1].time_x
    recorder.end()
    later.end()


def test_arguments_of_the_launch_file_are_kept(ros: both.Both, course: None) -> None:
    wait_until(lambda: ros.node.count_publishers("/signal"), lambda: "no /signal")
    out = ros.node.create_publisher(Float32, "/of_ros2", 10)
    recorder = ros.hear1("/of_ros2", "std_msgs/Float32")
    again = ros.hear2("/signal", SignalMsg)
    again.wait(20)  # both graphs were polled several times so far
    assert not ros.node.count_publishers("/proc_signal")  # denied
    assert not out.get_subscription_count()  # a way that is shut
    assert rospy.get_param("/ros2_bridge/remap") == ["/lab=/elsewhere"]
    recorder.end()
    again.end()
    ros.node.destroy_publisher(out)
