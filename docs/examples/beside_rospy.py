#!/usr/bin/env python3
"""Use libraries of rospy in a Node: tf2, message_filters, and dynamic_reconfigure's client."""

from contextlib import closing

import message_filters
import rospy
import tf2_ros
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PointStamped
from nodekit import MutuallyExclusiveCallbackGroup, Node, run
from std_msgs.msg import Float32, String
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse


class Companion:
    def __init__(self, node: Node) -> None:
        # tf2: rospy's own threads fill the buffer; any thread may read it.
        self.transforms = tf2_ros.Buffer()
        node.on_shutdown(tf2_ros.TransformListener(self.transforms).unregister)
        self.distance = node.create_publisher("distance", Float32)
        node.create_timer(10.0, self.measure)

        # message_filters: the node's subscriptions feed the filters, so the callback runs in the
        # node's group.
        self.difference = node.create_publisher("difference", Float32, latch=True)
        sides = [message_filters.SimpleFilter() for _ in range(2)]
        for name, side in zip(("left", "right"), sides):
            node.create_subscription(name, PointStamped, side.signalMessage)
        message_filters.TimeSynchronizer(sides, 10).registerCallback(self.compare)

        # AnyMsg: messages of any type, as bytes.
        self.sizes = Sizes()
        node.create_subscription("anything", rospy.AnyMsg, self.sizes.add, group=self.sizes.group)

        # subscriber_listener: a rospy publisher that uses the node's names and closes with it.
        summary = rospy.Publisher(
            node.resolve("summary"), String, queue_size=1, subscriber_listener=self.sizes
        )
        node.on_shutdown(summary.unregister)

        # dynamic_reconfigure's client waits for another node, so it gets a group of its own.
        own = MutuallyExclusiveCallbackGroup()
        node.create_service("~calm", Empty, self.calm, group=own)

    def measure(self, elapsed: float) -> None:
        try:  # without a time-out: waiting would block the node's other callbacks
            found = self.transforms.lookup_transform("robot", "goal", rospy.Time(0))
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(10.0, "no distance: %s", error)
        else:
            self.distance.publish(found.transform.translation.x)

    def compare(self, left: PointStamped, right: PointStamped) -> None:
        self.difference.publish(left.point.x - right.point.x)

    def calm(self, request: EmptyRequest) -> EmptyResponse:
        with closing(Client("/range_keeper", timeout=5.0)) as keeper:
            keeper.update_configuration({"gain": 0.1})
        return EmptyResponse()


class Sizes(rospy.SubscribeListener):
    """Counter of received bytes; sends the sum to each new subscriber."""

    def __init__(self) -> None:
        super().__init__()
        self.group = MutuallyExclusiveCallbackGroup()
        self.sum = 0

    def add(self, message: rospy.AnyMsg) -> None:
        self.sum += len(message._buff)

    def peer_subscribe(self, topic_name: str, topic_publish: object, peer_publish: object) -> None:
        with self.group:  # rospy calls this in a thread of its own
            peer_publish(String(f"{self.sum} bytes so far"))


if __name__ == "__main__":
    run("companion", Companion)
