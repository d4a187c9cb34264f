"""Lifecycle: performs the transitions of a managed node by calling on_configure and the others."""

import contextlib
import traceback
from typing import Any, Callable, List, Mapping, Union

import rospy

from nodekit.argument_checks import check_function
from nodekit.lifecycle_states import (
    ACTIVATING,
    ACTIVE,
    CONFIGURING,
    DEACTIVATING,
    INACTIVE,
    OUTCOMES,
    SHUTTINGDOWN,
    NotAllowed,
    Outcome,
    State,
    Transition,
    requested,
)
from nodekit.managed.activation_gate import ActivationGate
from nodekit.managed.lifecycle_scope import LifecycleScope
from nodekit.managed.state_machine import StateMachine
from nodekit.node import fork_guard
from nodekit.node.node_scope import NodeScope

#: Result of a callback: None and True are success, False is failure.
Result = Union[None, bool, Outcome]

#: Number of scopes that stay open in a state, of on_configure and on_activate; 0 in others.
_SCOPES = {INACTIVE: 1, ACTIVE: 2}


class Lifecycle:
    """Lifecycle of a node: performs its transitions.

    :param node: the node
    :param callbacks: callback of each transition state; the first two receive a scope
    :param on_step: called after each step, with its transition
    :raises TypeError: if a callback is not callable, or async

    :ivar previous: the state before the latest transition, which may be running
    """

    def __init__(
        self,
        node: NodeScope,
        callbacks: Mapping[State, Callable[..., Result]],
        on_step: Callable[[Transition], None],
    ) -> None:
        for state, callback in callbacks.items():
            check_function(callback, f"{node.name}: callback of {state.label}")
        self.machine = StateMachine(on_step)
        self.previous = self.machine.state
        self._node = node
        self._callbacks = callbacks
        self._gate = ActivationGate()
        self._scopes: List[LifecycleScope] = []

    @property
    def is_in_transition(self) -> bool:
        """Whether a callback of a transition is running."""
        return self.machine.state in self._callbacks

    def perform(self, transition: Transition) -> bool:
        """Perform the transition that the machine was claimed for; called in the node's group.

        :param transition: an allowed transition
        :returns: whether the callback succeeded
        """
        if self.machine.state != transition.start:  # a callback has ended the process meanwhile
            text = "%s: %s is too late: the node is %s"
            rospy.logwarn(text, self._node.name, transition.label, self.machine.state.label)
            return False
        self.previous = transition.start
        self._advance(transition)
        outcomes: List[Outcome] = []
        while self.machine.state in self._callbacks:
            outcomes.append(self._call())
            self._advance(OUTCOMES[self.machine.state, outcomes[-1]])
        return outcomes[0] is Outcome.SUCCESS

    def _advance(self, transition: Transition) -> None:
        """Go to the next state, and switch publishers and timers accordingly."""
        goal = transition.goal
        self._gate.allow_ticking(False)
        # A last message may be sent on the way out, such as one that stops a motor.
        if goal not in (ACTIVE, DEACTIVATING, SHUTTINGDOWN):
            self._gate.allow_publishing(False)
        if goal not in self._callbacks:
            while len(self._scopes) > _SCOPES.get(goal, 0):
                self._scopes.pop().close()
        self.machine.advance(transition)
        self._gate.allow_ticking(goal == ACTIVE)

    def _call(self) -> Outcome:
        """Call the callback of this state; open what it has created."""
        state = self.machine.state
        callback = self._callbacks[state]
        name = f"{self._node.name}: {callback.__name__}"
        try:
            if state not in (CONFIGURING, ACTIVATING):
                outcome = _outcome(fork_guard.call(callback))
            else:
                created_at = "configure" if state == CONFIGURING else "activate"
                scope = self._node.own(LifecycleScope(self._node, self._gate, created_at))
                self._scopes.append(scope)
                outcome = _outcome(fork_guard.call(callback, scope))
                if outcome is Outcome.SUCCESS:
                    # A subscription may receive a message, and reply to it, as soon as it is open.
                    self._gate.allow_publishing(state == ACTIVATING)
                    scope.open()
            if outcome is not Outcome.SUCCESS:
                rospy.logwarn("%s: %s", name, outcome.name.lower())
            return outcome
        except BaseException:  # SystemExit too: the client would wait for its response
            rospy.logerr("%s failed:\n%s", name, traceback.format_exc().rstrip())
            return Outcome.ERROR

    def shut_down(self) -> None:
        """Go through shutdown at the end of the process, after a running transition."""
        with contextlib.suppress(NotAllowed):  # already finalized
            transition = self.machine.claim("shutdown", None)
            with self._node.default_group:
                self.perform(transition)
            self.machine.release()

    def shut_down_inside(self) -> None:
        """Shut down immediately, in place of a thread that ends the process from a callback.

        That thread waits meanwhile, and must then adopt the group again. A caller that has claimed
        the machine is waiting for the group, or about to release the machine.
        """
        self._node.default_group.adopt()
        with contextlib.suppress(NotAllowed):  # already finalized
            self.perform(requested(self.machine.state, "shutdown"))


def _outcome(result: Any) -> Outcome:
    """Return the outcome for the result of a callback.

    :raises TypeError: if the result is invalid
    """
    if result is None or result is True:
        return Outcome.SUCCESS
    if result is False:
        return Outcome.FAILURE
    if result in tuple(Outcome):
        return Outcome(result)
    raise TypeError(f"returned {result!r}: must be None or True, False, or an Outcome")
