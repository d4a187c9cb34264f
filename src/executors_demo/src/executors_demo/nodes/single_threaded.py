"""Four timers on one thread."""

from executors_demo.four_timers import FourTimers, FourTimersParameters
from nodekit import EnumParameter, MutuallyExclusiveCallbackGroup, Node, run


class SingleThreadedParameters(FourTimersParameters):
    """Parameters of single_threaded."""

    executor = EnumParameter("single", choices=("single", "multi"), help="executor")


class SingleThreaded(FourTimers):
    """Four timers that could run in parallel, each in its own group.

    But the executor has one thread: it makes one call after the other, in the order of their due
    times. While ``timer1`` sleeps, nothing else runs. With ``_executor:=multi`` all timers run in
    parallel.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`SingleThreadedParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, SingleThreadedParameters)
        self.start_timers(
            MutuallyExclusiveCallbackGroup(),
            MutuallyExclusiveCallbackGroup(),
            MutuallyExclusiveCallbackGroup(),
            MutuallyExclusiveCallbackGroup(),
        )


def main() -> None:
    """Run the node until it is shut down."""
    run("single_threaded", SingleThreaded)
