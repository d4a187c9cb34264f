"""Topics that a server of an action publishes; messages are sent in the order of the changes."""

import threading
from collections import deque
from typing import Any, Deque, Tuple

import rospy
from actionlib_msgs.msg import GoalStatusArray

from nodekit.actions.goal_list import Goal, GoalList
from nodekit.messaging.publisher import Publisher
from nodekit.node.action_types import ActionMessages, header_now, status_message

#: Most results, and feedback messages, held for a client that does not read.
DEPTH = 1000


class ServerTopics:
    """Publishers of an action's server.

    Messages are queued under the server's lock and sent without it: subscribers in this process
    are called while a message is sent.

    :param scope: the scope that owns the publishers
    :param name: name of the action, resolved
    :param messages: message classes of the action
    :param goals: the goals to list
    """

    def __init__(self, scope: Any, name: str, messages: ActionMessages, goals: GoalList) -> None:
        self._messages, self._goals = messages, goals
        self._status = scope._publish(f"{name}/status", GoalStatusArray, latch=True)
        self._result = scope._publish(f"{name}/result", messages.action_result, queue_size=DEPTH)
        feedback = messages.action_feedback
        self._feedback = scope._publish(f"{name}/feedback", feedback, queue_size=DEPTH)
        self._outbox: Deque[Tuple[Publisher, Any]] = deque()
        self._sending = threading.Lock()

    def queue_status(self) -> None:
        """Queue the states of all goals."""
        statuses = [_status(goal) for goal in self._goals]
        self._outbox.append((self._status, GoalStatusArray(header_now(), statuses)))

    def queue_result(self, goal: Goal, result: Any) -> None:
        """Queue the result of a goal, and the states of all goals.

        :param goal: a goal that has just ended
        :param result: of the action's result class
        """
        message = self._messages.action_result(header_now(), _status(goal), result)
        self._outbox.append((self._result, message))
        self.queue_status()

    def send(self) -> None:
        """Send the queued messages, in one thread that no other waits for."""
        while self._outbox and self._sending.acquire(False):
            try:
                while self._outbox:
                    publisher, message = self._outbox.popleft()
                    publisher.publish(message)
            except rospy.ROSException as error:  # most often of a publisher that was just closed
                rospy.logdebug("%s", error)
            finally:
                self._sending.release()

    def publish_feedback(self, goal: Goal, feedback: Any) -> None:
        """Send feedback immediately: its author may change it for the next message.

        :param goal: a goal
        :param feedback: of the action's feedback class
        """
        message = self._messages.action_feedback(header_now(), _status(goal), feedback)
        self._feedback.publish(message)


def _status(goal: Goal) -> Any:
    return status_message(goal.id, goal.stamp, goal.state, goal.text)
