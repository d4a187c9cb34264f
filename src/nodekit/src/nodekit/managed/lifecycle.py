"""Leads a node through its transitions: calls its class, and opens and closes what that makes."""

import contextlib
import traceback
from typing import Any, Callable, List, Mapping, Union

import rospy

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
from nodekit.validation import check_function

#: What a callback may return: nothing and True are success, False is failure.
Result = Union[None, bool, Outcome]

#: How many scopes live on in a state: what on_configure has made, and on_activate. None in others.
_SCOPES = {INACTIVE: 1, ACTIVE: 2}


class Lifecycle:
    """A node's way through its states.

    :param node: whose
    :param callbacks: what to call in each transition state; the first two get a maker of their own
    :param tell: called after each step, with it
    :raises TypeError: if a callback is no function, or async

    :ivar previous: the state before the latest transition, which may be under way
    """

    def __init__(
        self,
        node: NodeScope,
        callbacks: Mapping[State, Callable[..., Result]],
        tell: Callable[[Transition], None],
    ) -> None:
        for state, callback in callbacks.items():
            check_function(callback, f"{node.name}: callback of {state.label}")
        self.machine = StateMachine(tell)
        self.previous = self.machine.state
        self._node = node
        self._callbacks = callbacks
        self._gate = ActivationGate()
        self._scopes: List[LifecycleScope] = []

    @property
    def is_under_way(self) -> bool:
        """Whether a callback of a transition is."""
        return self.machine.state in self._callbacks

    def make(self, transition: Transition) -> bool:
        """Make a transition that the machine was claimed for; called in the node's group.

        :param transition: one that is allowed
        :returns: whether the callback has succeeded
        """
        if self.machine.state != transition.start:  # a callback was ending the process meanwhile
            text = "%s: %s comes too late: the node is %s"
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
        """Go to the next state; have what the node has made update it."""
        goal = transition.goal
        self._gate.allow_ticking(False)
        # A last message may be sent on the way out, one that stops a motor.
        if goal not in (ACTIVE, DEACTIVATING, SHUTTINGDOWN):
            self._gate.allow_publishing(False)
        if goal not in self._callbacks:
            while len(self._scopes) > _SCOPES.get(goal, 0):
                self._scopes.pop().close()
        self.machine.advance(transition)
        self._gate.allow_ticking(goal == ACTIVE)

    def _call(self) -> Outcome:
        """Call the node's class, as it is up to in this state; open what it has made."""
        state = self.machine.state
        callback = self._callbacks[state]
        name = f"{self._node.name}: {callback.__name__}"
        try:
            if state not in (CONFIGURING, ACTIVATING):
                outcome = _outcome(fork_guard.call(callback))
            else:
                made_at = "configure" if state == CONFIGURING else "activate"
                scope = self._node.own(LifecycleScope(self._node, self._gate, made_at))
                self._scopes.append(scope)
                outcome = _outcome(fork_guard.call(callback, scope))
                if outcome is Outcome.SUCCESS:
                    # What is opened may hear a message, and answer it, at once.
                    self._gate.allow_publishing(state == ACTIVATING)
                    scope.open()
            if outcome is not Outcome.SUCCESS:
                rospy.logwarn("%s: %s", name, outcome.name.lower())
            return outcome
        except BaseException:  # SystemExit too: the client would wait for its answer
            rospy.logerr("%s failed:\n%s", name, traceback.format_exc().rstrip())
            return Outcome.ERROR

    def shut_down(self) -> None:
        """Go through shutdown as soon as nothing else is under way, as the process ends."""
        with contextlib.suppress(NotAllowed):  # it is finalized
            transition = self.machine.claim("shutdown", None)
            with self._node.default_group:
                self.make(transition)
            self.machine.release()

    def shut_down_inside(self) -> None:
        """Go through shutdown at once, in place of a thread whose callback ends the process.

        That thread waits meanwhile, and is then to adopt the group again. Who has claimed the
        machine now is waiting for the group, or about to release it.
        """
        self._node.default_group.adopt()
        with contextlib.suppress(NotAllowed):  # it is finalized
            self.make(requested(self.machine.state, "shutdown"))


def _outcome(result: Any) -> Outcome:
    """Return what a callback means.

    :raises TypeError: if it means nothing
    """
    if result is None or result is True:
        return Outcome.SUCCESS
    if result is False:
        return Outcome.FAILURE
    if result in tuple(Outcome):
        return Outcome(result)
    raise TypeError(f"returned {result!r}: must be None or True, False, or an Outcome")
