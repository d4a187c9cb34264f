# Pure: knows no ROS.
"""State machine of a managed node, with one transition at a time."""

import threading
from typing import Callable, Optional, Union

from nodekit.lifecycle_states import UNCONFIGURED, NotAllowed, State, Transition, requested


class StateMachine:
    """The state of one managed node.

    A caller claims the machine for a transition, makes its two or three steps, and releases it.

    :param on_step: called after each step, with its transition

    :ivar state: the present state
    """

    def __init__(self, on_step: Callable[[Transition], None]) -> None:
        self.state: State = UNCONFIGURED
        self._on_step = on_step
        self._free = threading.Condition()
        self._under_way = ""  # label of the claimed transition

    def claim(self, wanted: Union[int, str], timeout: Optional[float] = 0.0) -> Transition:
        """Claim the machine for a transition.

        :param wanted: label, or number
        :param timeout: longest wait for a running transition [s]; None for no limit
        :returns: the transition, to be started by :meth:`advance`
        :raises NotAllowed: if it is not allowed now; the machine is not claimed then
        """
        with self._free:
            if not self._free.wait_for(lambda: not self._under_way, timeout):
                raise NotAllowed(f"{wanted} is not allowed while {self._under_way} is running")
            transition = requested(self.state, wanted)
            self._under_way = transition.label
            return transition

    def release(self) -> None:
        """Release the machine for other callers."""
        with self._free:
            self._under_way = ""
            self._free.notify()

    def advance(self, transition: Transition) -> None:
        """Go to the next state.

        :param transition: a transition that starts in the present state
        :raises NotAllowed: if it does not
        """
        if transition.start != self.state:
            raise NotAllowed(f"{transition.label} does not leave the state {self.state.label}")
        self.state = transition.goal
        self._on_step(transition)
