"""What a manager says to one node and hears from it."""

import time
from typing import Callable, Optional

import rospy
from std_msgs.msg import Header

from lifecycle_manager.member import LOOK, Member
from lifecycle_manager.system import System
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, ChangeStateRequest, GetState, GetStateRequest
from nodekit import CallError, CallFuture, Node


class Contact:
    """The wires to one node. Whatever comes over them is noted in the manager's default group.

    :param node: the manager
    :param system: what is known of all nodes
    :param member: what is known of this one
    :param work: called after each note
    """

    def __init__(
        self, node: Node, system: System, member: Member, work: Callable[[], None]
    ) -> None:
        self.member = member
        self._system, self._work = system, work
        self._heartbeat = node.subscribe(f"{member.name}/heartbeat", Header, self._hear)
        node.subscribe(f"{member.name}/state", State, self._tell)
        self._change = node.client(f"{member.name}/change_state", ChangeState)
        self._get = node.client(f"{member.name}/get_state", GetState)
        self._call: Optional[CallFuture] = None
        self._connections = 0

    def look(self) -> None:
        """Notice if the node has hung up, as it does when its process ends in whatever way."""
        before, self._connections = self._connections, self._heartbeat.get_num_connections()
        if self._connections < before and self.member.is_heard:
            self._system.lose(self.member, "it has ended", time.monotonic())

    def ask(self, timeout: float) -> None:
        """Ask the node what is noted as under way; then for its state, which alone counts.

        :param timeout: longest wait for each answer, s
        """
        label = self.member.under_way
        if label == LOOK:
            self._ask_state("", timeout)
            return
        rospy.loginfo("%s: %s", self.member.name, label)
        request = ChangeStateRequest(Transition(0, label))
        self._call = self._change.call_async(request, timeout)
        self._call.add_done_callback(lambda call: self._ask_state(_error_of(call), timeout, call))

    def _ask_state(self, why: str, timeout: float, call: Optional[CallFuture] = None) -> None:
        if call is not None and call is not self._call:
            return  # it was dropped
        self._call = self._get.call_async(GetStateRequest(), timeout)
        self._call.add_done_callback(lambda call: self._end(call, why))

    def _end(self, call: CallFuture, why: str) -> None:
        if call is not self._call:
            return
        self._call = None
        self.look()
        if self.member.under_way:
            state = 0 if _error_of(call) else call.result().current_state.id
            self._system.end(self.member, state, why, time.monotonic())
        self._work()

    def _hear(self, _: Header) -> None:
        self.look()
        self._system.hear(self.member, time.monotonic())
        self._work()

    def _tell(self, message: State) -> None:
        self._system.tell(self.member, message.id, time.monotonic())
        self._work()


def _error_of(call: CallFuture) -> str:
    """Return why a call that is done has no answer, empty where it has."""
    try:
        call.result()
    except CallError as error:
        return str(error)
    return ""
