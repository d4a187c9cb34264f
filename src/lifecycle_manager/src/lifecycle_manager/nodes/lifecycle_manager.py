"""A node that brings a system of managed nodes up in order, watches it, and brings it back."""

import concurrent.futures
import contextlib
import threading
import time
from concurrent.futures import Future
from typing import Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest

from lifecycle_manager.contact import Contact
from lifecycle_manager.plan import Level
from lifecycle_manager.reports import reports
from lifecycle_manager.rivals import rival
from lifecycle_manager.system import FIRST_LOOK_S, System
from nodekit import (
    BoolParameter,
    FloatParameter,
    ListParameter,
    Node,
    ParameterError,
    ParameterSet,
    StringParameter,
    give_up,
    read_once,
    run,
)
from nodekit_msgs.srv import ManageNodes, ManageNodesRequest

#: How often it looks around, Hz.
LOOK_HZ = 20.0
#: How often it reports at least, Hz.
REPORT_HZ = 1.0
#: What is allowed as nodes.
ALONE = "nodes without another manager"
#: Longest time that it takes, at its end, to bring the nodes down, s.
END_S = 1.5


class LifecycleManagerParameters(ParameterSet):
    """Parameters of the lifecycle manager."""

    node_names = read_once(
        ListParameter(
            [],
            element=StringParameter("", help=""),
            help="the nodes in their order; a relative name is in the manager's namespace",
        )
    )
    autostart = read_once(BoolParameter(False, help="bring the nodes up without being told"))
    heartbeat_timeout = FloatParameter(
        0.8, minimum=0.4, maximum=60.0, unit="s", help="silence after which a node is lost"
    )
    respawn_window = FloatParameter(
        10.0, minimum=0.0, maximum=3600.0, unit="s", help="how long a node may be away"
    )
    request_timeout = FloatParameter(
        5.0, above=0.0, maximum=3600.0, unit="s", help="longest wait for the end of a transition"
    )


class LifecycleManager:
    """Configures all nodes in order, then activates all in order; takes them down in reverse.

    Where one is lost, those before it are deactivated and those after it cleaned up as well, until
    it is back. Where one fails to do what it is asked, all others come down and stay there until
    told.

    :ROS Services:
        - ``~manage_nodes`` (nodekit_msgs/ManageNodes): brings them up or down, and answers when
          that is done or has failed
        - ``~is_active`` (std_srvs/Trigger): whether all are active
        - of each node: ``change_state``, ``get_state``, as a client

    :ROS Publishers:
        - ``/diagnostics`` (diagnostic_msgs/DiagnosticArray): at 1 Hz and after each change

    :ROS Subscribers:
        - of each node: ``heartbeat`` (std_msgs/Header), ``state`` (lifecycle_msgs/State)

    :ROS Parameters:
        - those of :class:`LifecycleManagerParameters`, private

    :param node: the node
    :raises nodekit.ParameterError: if one of the nodes has another manager
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._settings = node.parameters(LifecycleManagerParameters)
        values = self._settings.values
        names = [node.resolve(name) for name in values.node_names]
        if not names or len(set(names)) < len(names):
            raise self._refused("names of nodes, each of them once")
        claimed = rival(node, names)
        if claimed:
            raise self._refused(ALONE, claimed)
        self._system = System(names, values.autostart, time.monotonic())
        self._contacts = {
            member: Contact(node, self._system, member, self.work)
            for member in self._system.members
        }
        self._answer: "Future[Tuple[bool, str]]" = Future()  # to the command that came last
        self._has_begun = threading.Event()
        self._is_alone = False  # once it is known that the nodes have no other manager
        self._told = ""
        self._diagnostics = node.publisher("/diagnostics", DiagnosticArray)
        waiting = node.group(exclusive=False)
        node.service("~manage_nodes", ManageNodes, self.manage, group=waiting)
        node.service("~is_active", Trigger, self.is_active)
        node.every(LOOK_HZ, self.look_around, steady=True)
        node.every(REPORT_HZ, self.report, steady=True)
        node.before_end(self.end)

    def manage(self, request: ManageNodesRequest) -> Tuple[bool, str]:
        """Take a command, and answer when the nodes are where it leads to, or cannot be."""
        self._has_begun.wait(2 * FIRST_LOOK_S)  # what is allowed depends on what it finds
        try:
            return self._command(request.command).result()
        except ValueError as refusal:
            return False, str(refusal)

    def is_active(self, _: TriggerRequest) -> Tuple[bool, str]:
        """Tell whether all nodes are active."""
        return self._system.is_active, self._system.summary

    def look_around(self, _: float) -> None:
        """Notice who is silent, and who has not come back."""
        if not self._is_alone:
            self._make_sure()
        for contact in self._contacts.values():
            contact.look()
        values = self._settings.values
        now = time.monotonic()
        self._system.look_around(values.heartbeat_timeout, values.respawn_window, now)
        self.work()

    def work(self) -> None:
        """Ask the nodes whatever they are to be asked now, and tell what has changed."""
        if not self._is_alone:
            return
        if self._system.goal is not None:
            self._has_begun.set()
        self._tell()
        member = self._system.ask_next(time.monotonic())
        while member is not None:
            self._contacts[member].ask(self._settings.values.request_timeout)
            member = self._system.ask_next(time.monotonic())
        result = self._system.settle()
        if result is not None and not self._answer.done():
            self._answer.set_result(result)

    def _tell(self) -> None:
        """Report what has changed; log what is wrong, and what is done."""
        summary = self._system.summary
        if summary != self._told:
            self._told = summary
            if self._system.problem:
                rospy.logerr("%s", summary)
            elif self._system.is_reached:
                rospy.loginfo("%s", summary)
            self.report()

    def report(self, _: float = 0.0) -> None:
        """Publish diagnostics."""
        header = Header(stamp=rospy.get_rostime())
        self._diagnostics.publish(header, reports(self._node.name, self._system))

    def end(self) -> None:
        """Bring the nodes down, as far as there is time: nobody will watch them."""
        if not self._is_alone:
            return
        with contextlib.suppress(concurrent.futures.TimeoutError):
            self._command(ManageNodesRequest.RESET).result(END_S)
        left = [each.name for each in self._system.members if each.level > Level.UNCONFIGURED]
        if left:
            rospy.logwarn("left behind as they are: %s", ", ".join(left))

    def _command(self, number: int) -> "Future[Tuple[bool, str]]":
        """Take a command.

        :param number: of the command
        :returns: what has come of it, later
        :raises ValueError: if it is none, or not one for now
        """
        with self._node.default_group:
            self._system.command(number, time.monotonic())
            if not self._answer.done():
                self._answer.set_result((False, "another command has come"))
            answer = self._answer = Future()
            self.work()
        return answer

    def _refused(self, allowed: str, reason: str = "") -> ParameterError:
        names = self._settings.values.node_names
        error = ParameterError("node_names", names, allowed, reason)
        return error.in_namespace(self._node.name)

    def _make_sure(self) -> None:
        """Look once more for another manager, which may have started at the same time."""
        claimed = rival(self._node, [member.name for member in self._contacts])
        if claimed:
            give_up(self._refused(ALONE, claimed))
        self._is_alone = not claimed


def main() -> None:
    """Run the node until it is shut down."""
    run("lifecycle_manager", LifecycleManager)
