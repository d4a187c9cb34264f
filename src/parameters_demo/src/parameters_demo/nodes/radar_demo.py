"""Radar node beside a simulated road."""

import rospy
from std_msgs.msg import Header

from nodekit import IntParameter, Node, ParameterSet, StringParameter, Throttle, run
from parameters_demo.messages import radar_tracks
from parameters_demo.traffic import returns
from parameters_demo_msgs.msg import RadarTracks


class RadarDemoParameters(ParameterSet):
    """Parameters of radar_demo."""

    radar_name = StringParameter("radar", help="Name of the radar")
    radar_rate = IntParameter(60, minimum=55, maximum=80, unit="Hz", help="Radar frame rate in Hz")


class RadarDemo:
    """Publishes moving objects in front of the radar: cars and a walking person.

    :ROS Publishers:
        - ``radar/tracks`` (parameters_demo_msgs/RadarTracks): in the frame ``NAME_frame``

    :ROS Parameters:
        - private, can be changed at run time: see :class:`RadarDemoParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(RadarDemoParameters)
        self._throttle = Throttle(1.0)
        self._tracks = node.create_publisher("radar/tracks", RadarTracks)
        node.create_timer(lambda: self._parameters.values.radar_rate, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish the current targets."""
        name = self._parameters.values.radar_name
        now = rospy.get_rostime()
        header = Header(stamp=now, frame_id=f"{name}_frame")
        seen = returns(now.to_sec())
        self._tracks.publish(radar_tracks(header, seen))
        if self._throttle.is_due():
            rospy.loginfo("Published %d returns from: %s", len(seen), name)


def main() -> None:
    """Run the node until it is shut down."""
    run("radar_demo", RadarDemo)
