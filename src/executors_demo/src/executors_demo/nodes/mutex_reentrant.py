"""Two timers in a reentrant group, and two that exclude each other."""

from executors_demo.four_timers import FourTimers
from nodekit import MutuallyExclusiveCallbackGroup, Node, ReentrantCallbackGroup, run


class MutexReentrant(FourTimers):
    """``timer1`` and ``timer2`` in a reentrant group, ``timer3`` and ``timer4`` in an exclusive.

    A reentrant group lets everything run: also ``timer1`` beside itself, where it sleeps for longer
    than its period. Of an exclusive group one call runs at a time.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): what waits, what runs, what was left out

    :ROS Parameters:
        - those of :class:`.FourTimersParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        reentrant, mutex = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.start_timers(reentrant, reentrant, mutex, mutex)


def main() -> None:
    """Run the node until it is shut down."""
    run("mutex_reentrant", MutexReentrant)
