"""Two-way mirror of a ROS 2 node's parameters on the ROS 1 parameter server."""

import collections
import difflib
import queue
import threading
import time
import traceback
from typing import Any, Callable, Deque, Dict, List, Set, Tuple

import rospy
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters

from nodekit import MasterUnreachable, Throttle, follow_parameter
from nodekit.master import MasterClient
from ros2_bridge.parameters import messages
from ros2_bridge.parameters.values import (
    DOUBLE,
    DOUBLES,
    as_kind,
    fitting_kind,
    flat,
    is_same,
    kind_of,
    ros1_key,
    unfit,
)
from ros2_bridge.ros2.client import NoResponse, Ros2Client
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.skip_log import SkipLog

#: Timeout for the node [s].
_TIMEOUT_S = 2.0
#: Shortest time between two warnings that a node does not answer [s]: a node may never spin.
_SELDOM_S = 600.0
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 10.0


class ParametersToRos1:
    """Mirror that writes a node's parameters to the server, and sends changes there to the node.

    A single thread does all of it, in sequence.

    :param participant: the bridge in ROS 2
    :param client: client of the master
    :param name, other: global name of the node in ROS 1 and in ROS 2
    """

    def __init__(
        self,
        participant: Participant,
        client: MasterClient,
        name: str,
        other: str,
        skip_log: SkipLog,
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._name, self._master, self._skip_log = name, client, skip_log
        #: Values shared by node and server, by ROS 2 name, and their types.
        self._values: Dict[str, Any] = {}
        self._kinds: Dict[str, int] = {}
        #: Reasons why ROS 1 cannot represent values of the node, by ROS 2 name.
        self._unfit: Dict[str, str] = {}
        self._is_written = False
        #: Names on the server that the node does not have and the user has been warned of.
        self._warned: Set[str] = set()
        #: End of the pause between warnings, on the monotonic clock [s].
        self._quiet_until = 0.0
        #: Current content of the server, until it is sent to the node.
        self._latest: Deque[Any] = collections.deque(maxlen=1)
        self._work: "queue.SimpleQueue[Callable[[], None]]" = queue.SimpleQueue()
        self._is_closed = False
        self.write_all()
        self._followed = follow_parameter(name, self._send_soon)
        self._list = Ros2Client(participant, ListParameters, f"{other}/list_parameters")
        self._get = Ros2Client(participant, GetParameters, f"{other}/get_parameters")
        self._set = Ros2Client(participant, SetParameters, f"{other}/set_parameters")
        threading.Thread(target=self._run, name=f"parameters of {name}", daemon=True).start()

    def write_all(self) -> None:
        """Write all of the node's parameters to the server, for example after its restart."""
        self._work.put(self._write_all)

    def retry_write_all(self) -> None:
        """Write all of the node's parameters again, if that failed before."""
        if not self._is_written and self._work.empty():
            self.write_all()

    def report_unfit(self) -> None:
        """Report the values that ROS 1 cannot represent; to be called at each poll."""
        for why in list(self._unfit.values()):
            self._skip_log.report(f"{self._name}: {why}")

    def write_event(self, event: Any) -> None:
        """Write the node's changes to the server."""
        changed = [
            (one.name, one.value) for one in [*event.new_parameters, *event.changed_parameters]
        ]
        gone = [one.name for one in event.deleted_parameters]
        self._work.put(lambda: self._write([one for one in changed if self._is_news(*one)], gone))

    def close(self) -> None:
        """Stop the mirror, and delete the node's parameters from the server."""
        self._followed.close()
        for one in (self._list, self._get, self._set):
            one.close()
        self._work.put(lambda: self._write([], list(self._values)))
        self._work.put(self._end)

    def _end(self) -> None:
        self._is_closed = True

    def _run(self) -> None:
        while not self._is_closed:
            try:
                self._work.get()()
            except (NoResponse, MasterUnreachable) as error:
                self._is_written = False  # the server may lack something
                self._warn_seldom(f"parameters of {self._name} in ROS 2: {error}")
            except Exception:  # the node may send malformed responses
                if self._throttle.is_due():
                    rospy.logerr(traceback.format_exc())

    def _warn_seldom(self, text: str) -> None:
        now = time.monotonic()
        if now >= self._quiet_until:
            self._quiet_until = now + _SELDOM_S
            rospy.logwarn(text)

    def _write_all(self) -> None:
        names = self._list.call(ListParameters.Request(), _TIMEOUT_S).result.names
        values = self._get.call(GetParameters.Request(names=names), _TIMEOUT_S).values
        self._write(list(zip(names, values)), [])
        self._is_written = True

    def _write(self, changed: List[Tuple[str, Any]], gone: List[str]) -> None:
        written = {}
        for name, message in changed:
            value = messages.to_plain(message)
            why = "" if value is None else unfit(name, value)
            self._unfit.pop(name, None)
            if why:
                self._unfit[name] = why
            elif value is not None:
                self._values[name], self._kinds[name] = value, message.type
                written[self._key(name)] = value
        self._write_server(written)
        for name in gone:
            self._unfit.pop(name, None)
        gone = [name for name in gone if self._values.pop(name, None) is not None]
        self._master.request([("deleteParam", self._key(name)) for name in gone])

    def _write_server(self, values: Dict[str, Any]) -> None:
        """Write to the server, and read it again: the same value may be set again from there."""
        self._master.write(values)
        if values:
            self._followed.report_again()

    def _is_news(self, name: str, message: Any) -> bool:
        """Return whether a change did not come from the server.

        A change from there is not written back: the server may already hold a newer value that is
        still to be sent.
        """
        known = None if name in self._unfit else self._values.get(name)
        return not is_same(known, messages.to_plain(message))

    def _key(self, name: str) -> str:
        return f"{self._name}/{ros1_key(name)}"

    def _send_soon(self, tree: Any) -> None:
        """Send the server's current content to the node.

        Earlier content is dropped: a rejected value may have been corrected since.
        """
        self._latest.append(tree)
        self._work.put(self._send_latest)

    def _send_latest(self) -> None:
        tree = self._latest.pop() if self._latest else None  # may be sent already
        if isinstance(tree, dict):
            self._send_changes(flat(tree))
            if self._is_written:
                self._warn_of_unknown([name for name in tree if not isinstance(tree[name], dict)])

    def _warn_of_unknown(self, names: List[str]) -> None:
        """Warn once of each parameter on the server that the node does not have.

        :param names: names without a namespace; a namespace may belong to another node
        """
        for name in names:
            if name not in self._values and name not in self._warned:
                self._warned.add(name)
                near = difflib.get_close_matches(name, self._values, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                rospy.logwarn(f"{self._name}/{name}: the node in ROS 2 has no such parameter{hint}")

    def _send_changes(self, found: Dict[str, Any]) -> None:
        refused, kept = [], {}
        for name, old in list(self._values.items()):
            value = found.get(name, old)
            kind = self._kinds[name]
            if kind in (DOUBLE, DOUBLES) and kind_of(value) in (kind - 1, kind):
                value = as_kind(value, kind)
            if is_same(value, old):
                continue
            why = self._send(name, value)
            if why:
                refused.append(f"{self._key(name)}={value!r} ({why}; {old!r} stays)")
                kept[self._key(name)] = old
            else:
                self._values[name] = value
        if refused:
            rospy.logwarn("refused by ROS 2: %s", ", ".join(refused))
            self._write_server(kept)

    def _send(self, name: str, value: Any) -> str:
        """Send a value to the node; return the reason for a rejection."""
        message = messages.to_message(value, fitting_kind(value, self._kinds[name]))
        if not message.type:
            return "parameters of ROS 2 cannot have such a value"
        request = SetParameters.Request(parameters=[Parameter(name=name, value=message)])
        try:
            results = self._set.call(request, _TIMEOUT_S).results
        except NoResponse as error:
            return str(error)
        if len(results) != 1:
            return f"the node sent {len(results)} results for one parameter"
        reason = results[0].reason.rstrip(".")  # the message continues after it
        return "" if results[0].successful else reason or "no reason given"
