"""Two pairs of timers; the timers of a pair exclude each other."""

from executors_demo.four_timers import FourTimers
from nodekit import MutuallyExclusiveCallbackGroup, Node, run


class TwoMutex(FourTimers):
    """``timer1`` and ``timer2`` are in an exclusive group, ``timer3`` and ``timer4`` in another.

    While ``timer1`` sleeps, ``timer2`` waits; ``timer3`` and ``timer4`` alternate.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.FourTimersParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        first, second = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.start_timers(first, first, second, second)


def main() -> None:
    """Run the node until it is shut down."""
    run("two_mutex", TwoMutex)
