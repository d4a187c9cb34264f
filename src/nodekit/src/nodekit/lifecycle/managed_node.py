"""A node that waits for others to configure and activate it: ROS 2's lifecycle."""

import threading
import time
import weakref
from typing import Any, Callable, Dict, Union

import rospy

from lifecycle_msgs import msg, srv
from nodekit.execution.groups import Outside
from nodekit.life.callbacks import Answering
from nodekit.life.lifetime import Lifetime
from nodekit.lifecycle.lifecycle import Lifecycle, Result
from nodekit.lifecycle.table import (
    ACTIVATING,
    CLEANINGUP,
    CONFIGURING,
    DEACTIVATING,
    ERRORPROCESSING,
    SHUTTINGDOWN,
    STATES,
    TRANSITIONS,
    NotAllowed,
    State,
    Transition,
    available,
)
from nodekit.node import Node
from nodekit.rospy_internals.shutdown import before_shutdown

#: Longest wait for callbacks as the process ends, s.
END_WAIT_S = 2.0


class ManagedNode:
    """What the class of a managed node derives from; each callback may be left out.

    A callback returns None or True where it has succeeded, False where it has not: then the state
    stays what it was. What it raises is logged, and :meth:`on_error` is called. All are called one
    at a time, in the node's default group.

    :ROS Publishers:
        - ``~transition_event`` (lifecycle_msgs/TransitionEvent): each step
        - ``~state`` (lifecycle_msgs/State): latched

    :ROS Services:
        - ``~change_state`` (lifecycle_msgs/ChangeState)
        - ``~get_state`` (lifecycle_msgs/GetState)
        - ``~get_available_states`` (lifecycle_msgs/GetAvailableStates)
        - ``~get_available_transitions``, ``~get_transition_graph``
          (lifecycle_msgs/GetAvailableTransitions)

    :param node: the node
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        callbacks: Dict[State, Callable[..., Result]] = {
            CONFIGURING: self.on_configure,
            ACTIVATING: self.on_activate,
            DEACTIVATING: self.on_deactivate,
            CLEANINGUP: self.on_cleanup,
            SHUTTINGDOWN: self.on_shutdown,
            ERRORPROCESSING: self.on_error,
        }
        self._lifecycle = Lifecycle(node, callbacks, self._tell)
        self._event = node.publisher("~transition_event", msg.TransitionEvent)
        self._state = node.publisher("~state", msg.State, latch=True)
        self._state.publish(_message(self.state))
        # In no group: they answer while a transition takes its time.
        for name, service_class, handler in (
            ("change_state", srv.ChangeState, self._change_state),
            ("get_state", srv.GetState, lambda _: _message(self.state)),
            ("get_available_states", srv.GetAvailableStates, lambda _: [_STATES]),
            ("get_available_transitions", srv.GetAvailableTransitions, self._get_available),
            ("get_transition_graph", srv.GetAvailableTransitions, lambda _: [_GRAPH]),
        ):
            node.service(f"~{name}", service_class, handler, group=Outside())
        change = node.resolve("~change_state")
        self._making = node.own(Answering(node.default_group, self._lifecycle.make, change))
        _all.add(self)

    @property
    def state(self) -> State:
        """The present state, with its ``id`` and ``label``."""
        return self._lifecycle.machine.state

    @property
    def previous_state(self) -> State:
        """The state before the latest transition, which may be under way."""
        return self._lifecycle.previous

    def on_configure(self, made: Lifetime) -> Result:
        """Get ready.

        :param made: makes what lives until cleanup. It is opened when this has succeeded, and
            publishes and ticks only while the node is active
        """

    def on_activate(self, made: Lifetime) -> Result:
        """Begin to work.

        :param made: makes what lives until the node is active no longer; opened as above
        """

    def on_deactivate(self) -> Result:
        """Stop working; a last message may still be published."""

    def on_cleanup(self) -> Result:
        """Give up what :meth:`on_configure` got, besides what it has made."""

    def on_shutdown(self) -> Result:
        """Get ready for the end, which comes from any state."""

    def on_error(self) -> Result:
        """Tidy up after a callback that failed with an error: then all can begin anew.

        Where this fails too, the node is finalized.
        """

    def _change_state(self, request: Any) -> bool:
        """Answer the service; of a refusal, the reason is logged."""
        wanted: Union[int, str] = request.transition.label or request.transition.id
        machine = self._lifecycle.machine
        try:
            transition = machine.claim(wanted)
        except NotAllowed as refusal:
            rospy.logwarn("%s: %s", self.node.name, refusal)
            return False
        try:
            return bool(self._making.answer(transition))
        finally:
            machine.release()

    def _get_available(self, _: Any) -> Any:
        return [[_description(each) for each in available(self.state)]]

    def _tell(self, step: Transition) -> None:
        self._state.publish(_message(step.goal))
        now = rospy.get_rostime().to_nsec()
        self._event.publish(now, *_parts(step))


def _message(state: State) -> msg.State:
    return msg.State(*state)


def _parts(step: Transition) -> Any:
    """Return transition, start and goal as messages have them."""
    return msg.Transition(step.id, step.label), _message(step.start), _message(step.goal)


def _description(step: Transition) -> msg.TransitionDescription:
    return msg.TransitionDescription(*_parts(step))


_STATES = [_message(state) for state in STATES]
_GRAPH = [_description(step) for step in TRANSITIONS]

_all: "weakref.WeakSet[ManagedNode]" = weakref.WeakSet()


def _end_all() -> None:
    """Have all that have started go through shutdown; leave behind those that do not come to it."""
    ending = {}
    for managed in list(_all):
        if managed.node.is_up:
            work = managed._lifecycle.shut_down
            ending[managed] = threading.Thread(target=work, name="shutdown", daemon=True)
            ending[managed].start()
    deadline = time.monotonic() + END_WAIT_S
    for managed, thread in ending.items():
        thread.join(max(0.0, deadline - time.monotonic()))
        if thread.is_alive():
            text = "%s ends without its shutdown: it is %s, and busy for more than %g s"
            rospy.logwarn(text, managed.node.name, managed.state.label, END_WAIT_S)


before_shutdown(_end_all)
