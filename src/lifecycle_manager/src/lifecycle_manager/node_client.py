"""Client of one managed node."""

import time
from typing import Callable, Optional

import rospy
from std_msgs.msg import Header

from lifecycle_manager.node_state import GET_STATE, NodeState
from lifecycle_manager.system import System
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, ChangeStateRequest, GetState, GetStateRequest
from nodekit import CallError, CallFuture, Node


class NodeClient:
    """A manager's subscriptions to one node, and its service clients.

    All callbacks run in the manager's default group.

    :param node: the manager
    :param system: states of all nodes
    :param member: state of this node
    :param on_change: called after each change of the state
    """

    def __init__(
        self, node: Node, system: System, member: NodeState, on_change: Callable[[], None]
    ) -> None:
        self.member = member
        self._system = system
        self._on_change = on_change
        self._heartbeat = node.create_subscription(
            f"{member.name}/heartbeat", Header, self._on_heartbeat
        )
        node.create_subscription(f"{member.name}/state", State, self._on_state)
        self._change = node.create_client(f"{member.name}/change_state", ChangeState)
        self._get = node.create_client(f"{member.name}/get_state", GetState)
        self._call: Optional[CallFuture] = None
        self._connections = 0

    def check_connection(self) -> None:
        """Mark the node as lost if its connection is closed: its process has ended."""
        before, self._connections = self._connections, self._heartbeat.get_num_connections()
        if self._connections < before and self.member.is_heard:
            self._system.mark_lost(self.member, "it has ended", time.monotonic())

    def send_request(self, timeout: float) -> None:
        """Send the node its pending request; then query its state, which is authoritative.

        :param timeout: timeout of each answer [s]
        """
        label = self.member.under_way
        if label == GET_STATE:
            self._ask_state("", timeout)
            return
        rospy.loginfo("%s: %s", self.member.name, label)
        request = ChangeStateRequest(Transition(0, label))
        self._call = self._change.call_async(request, timeout)
        self._call.add_done_callback(lambda call: self._ask_state(_error_of(call), timeout, call))

    def _ask_state(self, why: str, timeout: float, call: Optional[CallFuture] = None) -> None:
        if call is not None and call is not self._call:
            return  # the request was dropped
        self._call = self._get.call_async(GetStateRequest(), timeout)
        self._call.add_done_callback(lambda call: self._on_answer(call, why))

    def _on_answer(self, call: CallFuture, why: str) -> None:
        if call is not self._call:
            return
        self._call = None
        self.check_connection()
        if self.member.under_way:
            state = 0 if _error_of(call) else call.result().current_state.id
            self._system.record_answer(self.member, state, why, time.monotonic())
        self._on_change()

    def _on_heartbeat(self, _: Header) -> None:
        self.check_connection()
        self._system.record_heartbeat(self.member, time.monotonic())
        self._on_change()

    def _on_state(self, message: State) -> None:
        self._system.record_state(self.member, message.id, time.monotonic())
        self._on_change()


def _error_of(call: CallFuture) -> str:
    """Return the error of a finished call, empty without one."""
    try:
        call.result()
    except CallError as error:
        return str(error)
    return ""
