"""Camera node whose name and rate can be changed at run time."""

import rospy
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from nodekit import IntParameter, Node, ParameterSet, StringParameter, Throttle, run
from parameters_demo.messages import camera_info, image
from parameters_demo.picture import Picture

#: Value that ``~slow_down`` sets [Hz].
_SLOW_HZ = 40


class CameraDemoParameters(ParameterSet):
    """Parameters of camera_demo."""

    camera_name = StringParameter("camera", help="Name of the camera")
    camera_rate = IntParameter(
        60, minimum=10, maximum=80, step=10, unit="Hz", help="Camera frame rate in Hz"
    )


class CameraDemo:
    """Publishes a test card with a moving object, the camera's name, the frame number and the time.

    :ROS Publishers:
        - ``camera/image_color`` (sensor_msgs/Image): 640 by 480, rgb8, in the frame
          ``NAME_optical_frame``
        - ``camera/camera_info`` (sensor_msgs/CameraInfo): one with each image

    :ROS Services:
        - ``~slow_down`` (std_srvs/Trigger): sets ``~camera_rate`` to 40, in code

    :ROS Parameters:
        - private, can be changed at run time: see :class:`CameraDemoParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(CameraDemoParameters, on_change=self._on_change)
        self._throttle = Throttle(1.0)
        self._picture = Picture(self._parameters.values.camera_name)
        self._frames = 0
        self._images = node.create_publisher("camera/image_color", Image)
        self._infos = node.create_publisher("camera/camera_info", CameraInfo)
        node.create_service("~slow_down", Trigger, self.slow_down)
        node.create_timer(lambda: self._parameters.values.camera_rate, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish the next frame."""
        name = self._parameters.values.camera_name
        now = rospy.get_rostime()
        header = Header(stamp=now, frame_id=f"{name}_optical_frame")
        self._infos.publish(camera_info(header))
        self._images.publish(image(header, self._picture.draw(self._frames, now.to_sec())))
        self._frames += 1
        if self._throttle.is_due():
            rospy.loginfo("Published frame from: %s", name)

    def slow_down(self, request: TriggerRequest) -> TriggerResponse:
        """Set a parameter in code: it is validated like any other, and set on the server."""
        self._parameters.update(camera_rate=_SLOW_HZ)
        return TriggerResponse(True, f"camera_rate is {_SLOW_HZ}")

    def _on_change(self, new: CameraDemoParameters, old: CameraDemoParameters) -> None:
        if new.camera_name != old.camera_name:
            self._picture = Picture(new.camera_name)


def main() -> None:
    """Run the node until it is shut down."""
    run("camera_demo", CameraDemo)
