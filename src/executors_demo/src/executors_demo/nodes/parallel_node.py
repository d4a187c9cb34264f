"""A fast timer, a slow timer and a topic, in parallel."""

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
    """A fast timer continues while a slow timer works; commands are executed one by one.

    :ROS Subscribers:
        - ``commands`` (std_msgs/String), in its own exclusive group

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ParallelNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, ParallelNodeParameters)
        timers, commands = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        node.create_timer(lambda: 1.0 / self.settings.fast_period, self.fast, group=timers)
        node.create_timer(lambda: 1.0 / self.settings.slow_period, self.slow, group=timers)
        node.create_subscription("commands", String, self.command, group=commands)

    def fast(self, elapsed: float) -> None:
        """Return immediately."""
        self.work("fast", 0.0)

    def slow(self, elapsed: float) -> None:
        """Work for ``~slow_sleep``."""
        self.work("slow", self.settings.slow_sleep)

    def command(self, message: String) -> None:
        """Execute a command, for ``~command_sleep``."""
        self.work("commands", self.settings.command_sleep, message.data)


def main() -> None:
    """Run the node until it is shut down."""
    run("parallel_node", ParallelNode)
