"""ROS 1 action client for the tests, which executes commands line by line, and prints its events.

Commands are ``send KEY X Y`` (see action_server2), ``cancel KEY``, ``cancel_until KEY`` and
``cancel_all``. It prints ``KEY accepted TOOK``, ``KEY feedback DISTANCE TOOK PHASE``, and at the
end of a goal ``KEY STATE PHASE TEXT``; durations are in us.
"""

import sys
import time
from functools import partial

import actionlib
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus

from bot_controller_demo_msgs.msg import GoToAction, GoToGoal

NAMES = {value: name for name, value in vars(GoalStatus).items() if isinstance(value, int)}


def say(line: str) -> None:
    """Print a complete line: several threads print."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


class Client:
    """A client of the action of this name."""

    def __init__(self, name: str) -> None:
        self._client = actionlib.ActionClient(name, GoToAction)
        self._goals, self._began = {}, {}
        self._cancel = rospy.Publisher(f"{name}/cancel", GoalID, queue_size=10)
        rospy.sleep(0.01)  # until simulated time, if used, is known: its first jump ends the wait
        assert self._client.wait_for_server(rospy.Duration(20.0))
        say("connected")

    def obey(self, what: str, key: str = "", x: str = "0", y: str = "0") -> None:
        """Execute a command line."""
        if what == "send":
            goal = GoToGoal()
            goal.target_pose.header.frame_id = key
            goal.target_pose.pose.position.x = float(x)
            goal.target_pose.pose.position.y = float(y)
            self._began[key] = time.monotonic()
            self._goals[key] = self._client.send_goal(
                goal, partial(self._move, key), partial(self._feed, key)
            )
        elif what == "cancel":
            # Before that, actionlib's client treats a goal as lost if a status does not list it.
            while self._goals[key].get_comm_state() == actionlib.CommState.WAITING_FOR_GOAL_ACK:
                rospy.sleep(0.001)
            self._goals[key].cancel()
        elif what == "cancel_until":
            stamp = self._goals[key].comm_state_machine.action_goal.goal_id.stamp
            self._cancel.publish(GoalID(stamp=stamp))
        else:
            self._client.cancel_all_goals()

    def _move(self, key: str, handle) -> None:
        if handle.get_comm_state() == actionlib.CommState.ACTIVE:
            say(f"{key} accepted {1e6 * (time.monotonic() - self._began[key]):.0f}")
        if handle.get_comm_state() == actionlib.CommState.DONE:
            result = handle.get_result()
            phase = result.progress.phase if result is not None else ""
            state, text = handle.get_terminal_state(), handle.get_goal_status_text()
            say(f"{key} {NAMES[state]} {phase or '-'} {text}")

    def _feed(self, key: str, _handle, feedback) -> None:
        progress = feedback.progress
        took = 1e6 * (time.monotonic() - progress.heading_error)
        say(f"{key} feedback {progress.distance} {took:.0f} {progress.phase}")


if __name__ == "__main__":
    rospy.init_node("action_client1", anonymous=True, disable_signals=True)
    client = Client(sys.argv[1])
    for line in sys.stdin:
        client.obey(*line.split())
