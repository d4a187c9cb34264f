"""Services and topics of a managed node, as in ROS 2's lifecycle."""

import threading
import time
from typing import Any, Callable, Mapping, Union

import rospy
from std_msgs.msg import Header

from lifecycle_msgs import msg, srv
from nodekit.groups.callback_groups import NoGroup
from nodekit.lifecycle_states import (
    STATES,
    TRANSITIONS,
    NotAllowed,
    State,
    Transition,
    available,
)
from nodekit.managed.lifecycle import Lifecycle, Result
from nodekit.node.callbacks import ServiceCallback
from nodekit.node.ros_node import Node
from nodekit.node.node_scope import NodeScope
from nodekit.process_context import PROCESS
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.timing.clocks import MonotonicClock
from nodekit.timing.scheduler import Scheduler, Timer

#: Rate of the heartbeat on the monotonic clock [Hz].
BEATS_HZ = 5.0
#: Longest wait for callbacks at the end of the process [s].
END_WAIT_S = 2.0


class LifecycleServices:
    """Services that request transitions of a node, and topics with its state.

    :param node: the node
    :param callbacks: callback of each transition state, see :class:`.Lifecycle`

    :ivar lifecycle: performs the node's transitions
    """

    def __init__(self, node: Node, callbacks: Mapping[State, Callable[..., Result]]) -> None:
        self.node = node
        self.lifecycle = Lifecycle(node, callbacks, self._publish_transition)
        self._event = node.create_publisher("~transition_event", msg.TransitionEvent)
        self._state = node.create_publisher("~state", msg.State, latch=True)
        self._state.publish(_message(self.state))
        Heartbeat(node)
        # In no group: they respond during a transition.
        for name, service_class, handler in (
            ("change_state", srv.ChangeState, self._change_state),
            ("get_state", srv.GetState, lambda _: _message(self.state)),
            ("get_available_states", srv.GetAvailableStates, lambda _: [_STATES]),
            ("get_available_transitions", srv.GetAvailableTransitions, self._get_available),
            ("get_transition_graph", srv.GetAvailableTransitions, lambda _: [_GRAPH]),
        ):
            node.create_service(f"~{name}", service_class, handler, group=NoGroup())
        change = node.resolve("~change_state")
        self._performing = node.own(
            ServiceCallback(node.default_group, self.lifecycle.perform, change)
        )
        PROCESS.instances(LifecycleServices).add(self)

    @property
    def state(self) -> State:
        """The present state."""
        return self.lifecycle.machine.state

    def _change_state(self, request: Any) -> bool:
        """Handle a request; log the reason of a rejection."""
        wanted: Union[int, str] = request.transition.label or request.transition.id
        machine = self.lifecycle.machine
        try:
            transition = machine.claim(wanted)
        except NotAllowed as reason:
            rospy.logwarn("%s: %s", self.node.name, reason)
            return False
        try:
            return bool(self._performing.respond(transition))
        finally:
            machine.release()

    def _get_available(self, _: Any) -> Any:
        return [[_description(each) for each in available(self.state)]]

    def _publish_transition(self, transition: Transition) -> None:
        self._state.publish(_message(transition.goal))
        now = rospy.get_rostime().to_nsec()
        self._event.publish(now, *_parts(transition))


class Heartbeat:
    """Publisher of ``~heartbeat`` in any state; without a subscriber nothing is sent.

    Long callbacks do not delay it, except callbacks of a subscriber of heartbeats in this process.

    :param node: the node, which owns the heartbeat
    """

    def __init__(self, node: NodeScope) -> None:
        self._publisher = node.create_publisher("~heartbeat", Header)
        self._beats = 0
        self._timer = Timer(_scheduler(), self._beat, BEATS_HZ)
        _scheduler().start([self._timer])
        node.own(self)

    def _beat(self, _: float) -> None:
        self._beats += 1
        self._publisher.publish(self._beats, rospy.get_rostime(), "")

    def close(self) -> None:
        """Stop the heartbeat."""
        self._timer.close()


def _scheduler() -> Scheduler:
    """Return the scheduler of all heartbeats of this process, which calls no timers of nodes."""
    return PROCESS.get(Scheduler, lambda: Scheduler(MonotonicClock()), "heartbeats")


def _message(state: State) -> msg.State:
    return msg.State(*state)


def _parts(transition: Transition) -> Any:
    """Return transition, start and goal as messages have them."""
    return (
        msg.Transition(transition.id, transition.label),
        _message(transition.start),
        _message(transition.goal),
    )


def _description(transition: Transition) -> msg.TransitionDescription:
    return msg.TransitionDescription(*_parts(transition))


_STATES = [_message(state) for state in STATES]
_GRAPH = [_description(transition) for transition in TRANSITIONS]


def _end_all() -> None:
    """Shut down all started managed nodes; abandon those that do not finish in time."""
    ending, lent = {}, []
    for managed in list(PROCESS.instances(LifecycleServices)):
        if not managed.node.is_up:
            continue
        work, group = managed.lifecycle.shut_down, managed.node.default_group
        if group.is_mine:  # one of its callbacks ends the process
            if managed.lifecycle.is_in_transition:  # a callback of a transition: it cannot be left
                _warn_about_busy(managed, 0.0)
                continue
            work = managed.lifecycle.shut_down_inside
            lent.append(group)
        ending[managed] = threading.Thread(target=work, name="shutdown", daemon=True)
        ending[managed].start()
    deadline = time.monotonic() + END_WAIT_S
    for managed, thread in ending.items():
        thread.join(max(0.0, deadline - time.monotonic()))
        if thread.is_alive():
            _warn_about_busy(managed, END_WAIT_S)
    for group in lent:
        group.adopt()


def _warn_about_busy(managed: LifecycleServices, waited: float) -> None:
    text = "%s ends without its shutdown: it is %s, and still busy after %g s"
    rospy.logwarn(text, managed.node.name, managed.state.label, waited)


at_end(ShutdownPhase.TRANSITIONS, _end_all)
