"""Four timers on one thread."""

from executors_demo.four_timers import FourTimers, FourTimersParameters
from nodekit import EnumParameter, MutuallyExclusiveCallbackGroup, Node, run


class SingleThreadedParameters(FourTimersParameters):
    """Parameters of single_threaded."""

    executor = EnumParameter("single", choices=("single", "multi"), help="executor")


class SingleThreaded(FourTimers):
    """Four timers that might run at the same time, each being in a group of its own.

    But the executor has one thread: it makes one call after the other, in the order in which they
    became due. While ``timer1`` sleeps, nothing else runs. With ``_executor:=multi`` they all do.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): what waits, what runs, what was left out

    :ROS Parameters:
        - those of :class:`SingleThreadedParameters`, private and live
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
