# Pure: knows no ROS.
"""In which state a managed node is: one transition at a time, and none that the table lacks."""

import threading
from typing import Callable, Optional, Union

from nodekit.lifecycle_states import UNCONFIGURED, NotAllowed, State, Transition, requested


class StateMachine:
    """The state of one managed node.

    Whoever wants a transition claims the machine for it, makes its two or three steps, and
    releases it.

    :param tell: called after each step, with it

    :ivar state: the present state
    """

    def __init__(self, tell: Callable[[Transition], None]) -> None:
        self.state: State = UNCONFIGURED
        self._tell = tell
        self._free = threading.Condition()
        self._under_way = ""  # label of the transition that it is claimed for

    def claim(self, wanted: Union[int, str], timeout: Optional[float] = 0.0) -> Transition:
        """Claim the machine for a transition.

        :param wanted: label, or number
        :param timeout: longest wait for one that is under way, s; None for ever
        :returns: the transition, to be begun by :meth:`advance`
        :raises NotAllowed: if it is not allowed now; then there is nothing to release
        """
        with self._free:
            if not self._free.wait_for(lambda: not self._under_way, timeout):
                raise NotAllowed(f"{wanted} has to wait: {self._under_way} is under way")
            transition = requested(self.state, wanted)
            self._under_way = transition.label
            return transition

    def release(self) -> None:
        """Let others claim the machine."""
        with self._free:
            self._under_way = ""
            self._free.notify()

    def advance(self, transition: Transition) -> None:
        """Go to the next state.

        :param transition: one that leaves the present state
        :raises NotAllowed: if it does not
        """
        if transition.start != self.state:
            raise NotAllowed(f"{transition.label} does not leave the state {self.state.label}")
        self.state = transition.goal
        self._tell(transition)
