"""Node that connects microcontrollers to ROS through rosserial's protocol."""

import time
from typing import Any, Dict, List, Sequence, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from nodekit import Node, run
from nodekit.master import MISSING, MasterClient
from serial_link.endpoints.ros_side import RosSide
from serial_link.hardware.ports import Port
from serial_link.hardware.serial_port import SerialPort
from serial_link.hardware.tcp_port import TcpServer
from serial_link.hardware.tcp_slots import parse_slots
from serial_link.host.counters import Counters
from serial_link.link.board_link import BoardLink
from serial_link.serial_parameters import TCP, SerialParameters

#: Timeout for the master when a board requests a parameter [s].
_MASTER_S = 0.5
#: Shortest time between two log lines about faults [s].
_LINE_EVERY_S = 10.0
#: Counters that are not faults: only on /diagnostics.
_USUAL = {"received", "received bytes", "sent", "sent bytes", "openings", "asked"}


class SerialNode:
    """Node that offers the topics, services, parameters and logs of boards in ROS.

    It requests a board's topics when the port opens, and after each restart of the board. It
    replaces rosserial_python's node of the same name.

    :ROS Subscribers:
        - the topics that a board subscribes to

    :ROS Publishers:
        - the topics that a board publishes
        - ``/diagnostics`` (diagnostic_msgs/DiagnosticArray): all counters, once a second
        - ``/rosout`` (rosgraph_msgs/Log): the board's log, under the name ``NODE/board``

    :ROS Services:
        - the services that a board offers

    :ROS Parameters:
        - private: see :class:`.SerialParameters`; and any parameter that a board requests

    :param node: the node
    :param words: command-line arguments: the port, and with tcp its number, as for
        rosserial_python's node
    """

    def __init__(self, node: Node, words: Sequence[str] = ()) -> None:
        # A sketch may ask for any private parameter.
        self._settings = node.declare_parameters(SerialParameters, exempt=["*"])
        if words:
            self._settings.update(**dict(zip(("port", "tcp_port"), words)))
        self._node_name = node.name
        self._boards = [self._board(node, space, port) for space, port in self._ports()]
        self._has_started = False
        self._diagnostics = node.create_publisher("/diagnostics", DiagnosticArray)
        node.create_timer(1.0, self._report, steady=True)
        node.on_shutdown(self._send_stop)

    def _ports(self) -> List[Tuple[str, Port]]:
        """Return the ports of the boards, with the boards' namespaces."""
        values = self._settings.values
        if values.port != TCP:
            return [("", SerialPort(values.port, values.baud))]
        slots = parse_slots(values.tcp_boards)
        server = TcpServer(values.tcp_address, values.tcp_port, slots, _warn)
        return [(slot.name, port) for slot, port in zip(slots, server.ports)]

    def _board(self, node: Node, space: str, port: Port) -> "_Board":
        counters = Counters()
        link = BoardLink(port, counters, _ros_time)
        timeout = lambda: self._settings.values.service_timeout  # noqa: E731
        side = RosSide(node, link, counters, timeout, self._find_parameter, space)
        node.own(link)
        node.own(side)
        return _Board(space or "board", link, side)

    def _send_stop(self) -> None:
        for board in self._boards:
            board.link.send_stop()

    def _find_parameter(self, name: str) -> Any:
        """Return a parameter for the board; None if it is not set.

        :raises MasterUnreachable: if it is not declared here and the master does not answer
        """
        private, _, own = name.rpartition("/")
        if private == self._node_name and own in SerialParameters.declared:
            return getattr(self._settings.values, own)
        with MasterClient(self._node_name, timeout=_MASTER_S) as master:
            found = master.read([name]).values[name]
        return None if found is MISSING else found

    def _report(self, _elapsed: float) -> None:
        if not self._has_started:  # not earlier: the board's topics are opened immediately
            self._has_started = True
            for board in self._boards:
                board.link.start()
                board.side.start()
        statuses = [board.status(self._node_name) for board in self._boards]
        self._diagnostics.publish(DiagnosticArray(Header(stamp=rospy.get_rostime()), statuses))


class _Board:
    """A board: its link, its ROS side, and the faults already reported.

    :param name: of the board on ``/diagnostics``
    :param link: to the board
    :param side: its ROS side
    """

    def __init__(self, name: str, link: BoardLink, side: RosSide) -> None:
        self.link, self.side = link, side
        self._name = name
        self._faults: Dict[str, int] = {}
        self._logged_faults: Dict[str, int] = {}
        self._logged_at = -_LINE_EVERY_S

    def status(self, node_name: str) -> DiagnosticStatus:
        """Return the status for ``/diagnostics``; log new faults.

        :param node_name: of the node
        """
        figures = self.link.all_counters()
        faults = {name: count for name, count in figures.items() if count and name not in _USUAL}
        is_new, self._faults = faults != self._faults, faults
        trouble = self.link.trouble
        level = DiagnosticStatus.WARN if is_new else DiagnosticStatus.OK
        message = "faults in the last second" if is_new else "synchronized"
        if trouble:
            level, message = DiagnosticStatus.ERROR, trouble
        values = [KeyValue(name, str(count)) for name, count in sorted(figures.items())]
        name = f"{node_name.lstrip('/')}: {self._name}"
        now = time.monotonic()
        if faults != self._logged_faults and now - self._logged_at >= _LINE_EVERY_S:
            self._logged_faults, self._logged_at = faults, now
            text = ", ".join(f"{name} {count}" for name, count in sorted(faults.items()))
            received, sent = figures.get("received", 0), figures.get("sent", 0)
            rospy.loginfo(
                "%s: %d frames received, %d sent; %s", self.link.port_name, received, sent, text
            )
        return DiagnosticStatus(level, name, message, self.link.port_name, values)


def _warn(text: str) -> None:
    rospy.logwarn("%s", text)


def _ros_time() -> Tuple[int, int]:
    now = rospy.get_rostime()
    return now.secs, now.nsecs


def main() -> None:
    """Run the node until it is shut down."""
    words = [word for word in rospy.myargv()[1:] if not word.startswith("-")]
    run("serial_node", lambda node: SerialNode(node, words))
