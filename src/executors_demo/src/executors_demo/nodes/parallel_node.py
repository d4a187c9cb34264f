"""A fast timer, a slow one and a topic, all at the same time."""

from std_msgs.msg import String

from executors_demo.demo import Demo, ExecutorParameters, period_of, sleep_of
from nodekit import MutuallyExclusiveCallbackGroup, Node, ReentrantCallbackGroup, run


class ParallelNodeParameters(ExecutorParameters):
    """Parameters of parallel_node."""

    fast_period = period_of(0.1, "fast")
    slow_period = period_of(1.0, "slow")
    slow_sleep = sleep_of(0.5, "slow")
    command_sleep = sleep_of(0.0, "commands")


class ParallelNode(Demo[ParallelNodeParameters]):
    """A fast timer goes on while a slow one works; commands are carried out one by one.

    :ROS Subscribers:
        - ``commands`` (std_msgs/String), in an exclusive group of its own

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): what waits, what runs, what was left out

    :ROS Parameters:
        - those of :class:`ParallelNodeParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, ParallelNodeParameters)
        timers, commands = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        node.create_timer(lambda: 1.0 / self.settings.fast_period, self.fast, group=timers)
        node.create_timer(lambda: 1.0 / self.settings.slow_period, self.slow, group=timers)
        node.create_subscription("commands", String, self.command, group=commands)

    def fast(self, elapsed: float) -> None:
        """Be done at once."""
        self.work("fast", 0.0)

    def slow(self, elapsed: float) -> None:
        """Work for ``~slow_sleep``."""
        self.work("slow", self.settings.slow_sleep)

    def command(self, message: String) -> None:
        """Carry out a command, for ``~command_sleep``."""
        self.work("commands", self.settings.command_sleep, message.data)


def main() -> None:
    """Run the node until it is shut down."""
    run("parallel_node", ParallelNode)
