"""Two timers in a reentrant group, and two in a mutually exclusive group."""

from executors_demo.four_timers import FourTimers
from nodekit import MutuallyExclusiveCallbackGroup, Node, ReentrantCallbackGroup, run


class MutexReentrant(FourTimers):
    """``timer1`` and ``timer2`` in a reentrant group, ``timer3`` and ``timer4`` in a mutex group.

    A reentrant group does not restrict its calls: even two calls of ``timer1`` overlap if it sleeps
    for longer than its period. An exclusive group runs one call at a time.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.FourTimersParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        reentrant, mutex = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.start_timers(reentrant, reentrant, mutex, mutex)


def main() -> None:
    """Run the node until it is shut down."""
    run("mutex_reentrant", MutexReentrant)
