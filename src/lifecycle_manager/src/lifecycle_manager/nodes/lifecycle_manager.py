"""Lifecycle manager node: brings managed nodes up in order, monitors and restores them."""

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

from lifecycle_manager.node_client import NodeClient
from lifecycle_manager.plan import Level
from lifecycle_manager.reports import reports
from lifecycle_manager.other_managers import find_other_manager
from lifecycle_manager.system import FIRST_QUERY_S, System
from nodekit import (
    BoolParameter,
    FloatParameter,
    ListParameter,
    Node,
    ParameterError,
    ParameterSet,
    ReentrantCallbackGroup,
    StringParameter,
    abort,
    read_once,
    rule,
    run,
)
from nodekit_msgs.srv import ManageNodes, ManageNodesRequest

#: Rate of the checks of the nodes [Hz].
CHECK_HZ = 20.0
#: Minimum rate of the diagnostics [Hz].
REPORT_HZ = 1.0
#: Requirement for the nodes, for messages.
ALONE = "nodes that have no other manager"
#: Timeout for bringing the nodes down at shutdown [s].
END_S = 1.5


class LifecycleManagerParameters(ParameterSet):
    """Parameters of the lifecycle manager."""

    node_names = read_once(
        ListParameter(
            [],
            element=StringParameter("", help=""),
            help="the nodes, in start order; relative names are in the manager's namespace",
        )
    )
    autostart = read_once(
        BoolParameter(False, help="bring the nodes up at startup, without a command")
    )
    heartbeat_timeout = FloatParameter(
        0.8,
        minimum=0.4,
        maximum=60.0,
        unit="s",
        help="time without a heartbeat after which a node counts as lost",
    )
    respawn_window = FloatParameter(
        10.0,
        minimum=0.0,
        maximum=3600.0,
        unit="s",
        help="time for a lost node to come back",
    )
    request_timeout = FloatParameter(
        5.0, above=0.0, maximum=3600.0, unit="s", help="timeout of a transition"
    )


class LifecycleManager:
    """Configures all nodes in order, then activates them in order; brings them down in reverse.

    When a node is lost, the nodes before it are deactivated and those after it cleaned up as well,
    until it is back. When a transition fails, all other nodes are brought down and stay down until
    the next command.

    :ROS Services:
        - ``~manage_nodes`` (nodekit_msgs/ManageNodes): brings them up or down; answers when that
            has succeeded or failed
        - ``~is_active`` (std_srvs/Trigger): whether all are active
        - of each node: ``change_state``, ``get_state``, as a client

    :ROS Publishers:
        - ``/diagnostics`` (diagnostic_msgs/DiagnosticArray): at 1 Hz and after each change

    :ROS Subscribers:
        - of each node: ``heartbeat`` (std_msgs/Header), ``state`` (lifecycle_msgs/State)

    :ROS Parameters:
        - private: see :class:`LifecycleManagerParameters`

    :param node: the node
    :raises nodekit.ParameterError: if one of the nodes has another manager
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._settings = node.declare_parameters(
            LifecycleManagerParameters, rules=[self.can_be_managed]
        )
        values = self._settings.values
        names = [node.resolve(name) for name in values.node_names]
        claimed = find_other_manager(node, names)
        if claimed:
            raise self._has_rival(claimed)
        self._system = System(names, values.autostart, time.monotonic())
        self._clients = {
            member: NodeClient(node, self._system, member, self.update)
            for member in self._system.members
        }
        self._answer: "Future[Tuple[bool, str]]" = Future()  # to the latest command
        self._has_begun = threading.Event()
        self._is_alone = False  # until it is known that the nodes have no other manager
        self._reported = ""
        self._diagnostics = node.create_publisher("/diagnostics", DiagnosticArray)
        waiting = ReentrantCallbackGroup()
        node.create_service("~manage_nodes", ManageNodes, self.manage, group=waiting)
        node.create_service("~is_active", Trigger, self.is_active)
        node.create_timer(CHECK_HZ, self.check_nodes, steady=True)
        node.create_timer(REPORT_HZ, self.report, steady=True)
        node.on_shutdown(self.end)

    @rule("node_names")
    def can_be_managed(self, values: LifecycleManagerParameters) -> None:
        """Reject invalid node names."""
        names = [self._node.resolve(name) for name in values.node_names]
        if not names or len(set(names)) < len(names):
            raise ValueError("must be a list of node names without duplicates")
        if not all(name.strip("/") and name[0] != "~" for name in values.node_names):
            raise ValueError("must be names of nodes, relative or global")
        if self._node.name in names:
            raise ValueError("must be other nodes than the manager itself")

    def manage(self, request: ManageNodesRequest) -> Tuple[bool, str]:
        """Execute a command; answer when the nodes have reached its goal, or have failed to."""
        self._has_begun.wait(2 * FIRST_QUERY_S)  # allowed commands depend on the nodes' states
        try:
            return self._command(request.command).result()
        except ValueError as error:
            return False, str(error)

    def is_active(self, _: TriggerRequest) -> Tuple[bool, str]:
        """Return whether all nodes are active."""
        return self._system.is_active, self._system.summary

    def check_nodes(self, _: float) -> None:
        """Detect silent nodes, and nodes that have not come back."""
        if not self._is_alone:
            self._make_sure()
        for client in self._clients.values():
            client.check_connection()
        values = self._settings.values
        now = time.monotonic()
        self._system.check_timeouts(values.heartbeat_timeout, values.respawn_window, now)
        self.update()

    def update(self) -> None:
        """Send due requests, and report changes."""
        if not self._is_alone:
            return
        if self._system.goal is not None:
            self._has_begun.set()
        self._report_changes()
        member = self._system.ask_next(time.monotonic())
        while member is not None:
            self._clients[member].send_request(self._settings.values.request_timeout)
            member = self._system.ask_next(time.monotonic())
        result = self._system.settle()
        if result is not None and not self._answer.done():
            self._answer.set_result(result)

    def _report_changes(self) -> None:
        """Publish and log the summary if it has changed."""
        summary = self._system.summary
        if summary != self._reported:
            self._reported = summary
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
        """Bring the nodes down at shutdown, as far as time allows."""
        if not self._is_alone:
            return
        with contextlib.suppress(concurrent.futures.TimeoutError):
            self._command(ManageNodesRequest.RESET).result(END_S)
        left = [each.name for each in self._system.members if each.level > Level.UNCONFIGURED]
        if left:
            rospy.logwarn("left in their current states: %s", ", ".join(left))

    def _command(self, number: int) -> "Future[Tuple[bool, str]]":
        """Execute a command.

        :param number: of the command
        :returns: its future result
        :raises ValueError: if there is no such command, or it is not allowed now
        """
        with self._node.default_group:
            self._system.command(number, time.monotonic())
            if not self._answer.done():
                self._answer.set_result((False, "superseded by another command"))
            answer = self._answer = Future()
            self.update()
        return answer

    def _has_rival(self, claimed: str) -> ParameterError:
        names = self._settings.values.node_names
        error = ParameterError("node_names", names, ALONE, claimed)
        return error.in_namespace(self._node.name)

    def _make_sure(self) -> None:
        """Check again for another manager, which may have started at the same time."""
        claimed = find_other_manager(self._node, [member.name for member in self._clients])
        if claimed:
            abort(self._has_rival(claimed))
        self._is_alone = not claimed


def main() -> None:
    """Run the node until it is shut down."""
    run("lifecycle_manager", LifecycleManager)
