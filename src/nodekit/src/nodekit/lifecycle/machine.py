"""In which state a managed node is: one transition at a time, and none that the table lacks."""

import threading
from typing import Callable, Union

from nodekit.lifecycle.table import (
    OUTCOMES,
    UNCONFIGURED,
    NotAllowed,
    Outcome,
    State,
    Transition,
    requested,
)


class Machine:
    """The state of one managed node.

    Whoever wants a transition claims the machine for it, makes its two or three steps, and
    releases it.

    :param tell: called after each step, with it

    :ivar state: the present state
    """

    def __init__(self, tell: Callable[[Transition], None]) -> None:
        self.state: State = UNCONFIGURED
        self._tell = tell
        self._is_claimed = threading.Lock()
        self._under_way = "another transition"

    def claim(self, wanted: Union[int, str], timeout: float = 0.0) -> Transition:
        """Claim the machine for a transition.

        :param wanted: label, or number
        :param timeout: longest wait for one that is under way, s
        :returns: the transition, to be begun by :meth:`step`
        :raises NotAllowed: if it is not allowed now; then there is nothing to release
        """
        if not self._is_claimed.acquire(timeout=timeout):
            raise NotAllowed(f"{wanted} has to wait: {self._under_way} is under way")
        try:
            transition = requested(self.state, wanted)
        except NotAllowed:
            self._is_claimed.release()
            raise
        self._under_way = transition.label
        return transition

    def release(self) -> None:
        """Let others claim the machine."""
        self._is_claimed.release()

    def step(self, transition: Transition) -> None:
        """Go to the next state.

        :param transition: one that leaves the present state
        :raises NotAllowed: if it does not
        """
        if transition.start != self.state:
            raise NotAllowed(f"{transition.label} does not leave the state {self.state.label}")
        self.state = transition.goal
        self._tell(transition)

    def end(self, outcome: Outcome) -> None:
        """Go to the state that a callback leads to.

        :param outcome: what became of it
        :raises NotAllowed: if none is under way in this state
        """
        transition = OUTCOMES.get((self.state, outcome))
        if transition is None:
            raise NotAllowed(f"no callback is under way in the state {self.state.label}")
        self.step(transition)
