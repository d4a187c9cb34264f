"""A service that takes three seconds, and a timer that continues meanwhile."""

from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from executors_demo.demo import Demo, ExecutorParameters, period_of, sleep_of
from nodekit import (
    BoolParameter,
    MutuallyExclusiveCallbackGroup,
    Node,
    ReentrantCallbackGroup,
    read_once,
    run,
)


class SlowServiceParameters(ExecutorParameters):
    """Parameters of slow_service."""

    exclusive = read_once(
        BoolParameter(False, help="whether calls of the service wait for each other")
    )
    service_sleep = sleep_of(3.0, "slow_service")
    timer_period = period_of(0.5, "timer")


class SlowService(Demo[SlowServiceParameters]):
    """Slow service that does not delay other callbacks.

    The timer and the service have their own groups, so the timer continues. The service's group is
    reentrant, so as many calls are answered in parallel as there are threads; with
    ``_exclusive:=true`` it is exclusive, and they are answered one by one.

    :ROS Services:
        - ``slow_service`` (std_srvs/Trigger): answers after ``~service_sleep``
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`SlowServiceParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, SlowServiceParameters)
        services = (
            MutuallyExclusiveCallbackGroup if self.settings.exclusive else ReentrantCallbackGroup
        )()
        node.create_service("slow_service", Trigger, self.serve, group=services)
        node.create_timer(lambda: 1.0 / self.settings.timer_period, self.timer)

    def serve(self, request: TriggerRequest) -> TriggerResponse:
        """Answer after ``~service_sleep``."""
        length = self.settings.service_sleep
        self.work("slow_service", length)
        return TriggerResponse(True, f"done after {length:g} s")

    def timer(self, elapsed: float) -> None:
        """Return immediately."""
        self.work("timer", 0.0)


def main() -> None:
    """Run the node until it is shut down."""
    run("slow_service", SlowService)
