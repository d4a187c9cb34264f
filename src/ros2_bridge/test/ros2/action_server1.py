"""ROS 1 action server for the tests, with any number of concurrent goals.

A goal is a pose: x is its duration [s], y its outcome: it is accepted and succeeds (0), or is
aborted (1), it is rejected (2), or remains pending until it is cancelled (3), or it is accepted and
ignores cancellation (4). The result has the goal's frame_id, and so has the feedback, with the
remaining time and the time of sending [s].
"""

import contextlib
import sys
import time

import actionlib
import rospy

from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToResult

SUCCEED, ABORT, REJECT, PEND, PERSIST = range(5)


class Server:
    """Serves the action of this name."""

    def __init__(self, name: str) -> None:
        self._goals, self._cancelled = {}, set()
        # By default, actionlib keeps 50 results in a burst.
        rospy.set_param("actionlib_server_pub_queue_size", 1000)
        self._server = actionlib.ActionServer(
            name, GoToAction, self._begin, self._cancel, auto_start=False
        )
        self._server.start()

    def _begin(self, handle) -> None:
        pose = handle.get_goal().target_pose
        if pose.pose.position.y == REJECT:
            handle.set_rejected(text="not this one")
            return
        if pose.pose.position.y != PEND:
            handle.set_accepted("on its way")
        self._goals[handle.get_goal_id().id] = (handle, rospy.get_time())

    def _cancel(self, handle) -> None:
        self._cancelled.add(handle.get_goal_id().id)

    def step(self) -> None:
        """End finished goals, and publish feedback for the others."""
        with self._server.lock:  # which actionlib holds in the callbacks above
            for name, (handle, began) in list(self._goals.items()):
                pose, elapsed = handle.get_goal().target_pose, rospy.get_time() - began
                what, result = pose.pose.position.y, GoToResult()
                result.progress.phase = pose.header.frame_id
                if name in self._cancelled and what != PERSIST:
                    handle.set_canceled(result, "cancelled")
                elif what == PEND:
                    continue
                elif elapsed < pose.pose.position.x:
                    feedback = GoToFeedback()
                    feedback.progress.distance = pose.pose.position.x - elapsed
                    feedback.progress.phase = pose.header.frame_id
                    feedback.progress.heading_error = time.monotonic()
                    handle.publish_feedback(feedback)
                    continue
                elif what == ABORT:
                    handle.set_aborted(result, "no way")
                else:
                    handle.set_succeeded(result, "there")
                del self._goals[name]


if __name__ == "__main__":
    rospy.init_node("action_server1")
    server = Server(sys.argv[1])
    print("serving", flush=True)
    with contextlib.suppress(rospy.ROSInterruptException):
        while not rospy.is_shutdown():
            server.step()
            rospy.sleep(0.05)
