"""Four timers in callback groups that a demo chooses."""

from typing import Type

from executors_demo.demo import Demo, ExecutorParameters, period_of, sleep_of
from nodekit import CallbackGroup, Node


class FourTimersParameters(ExecutorParameters):
    """Parameters of a demo with four timers."""

    period = period_of(1.0, "each timer")
    timer1_sleep = sleep_of(0.1, "timer1")
    timer2_sleep = sleep_of(0.1, "timer2")
    timer3_sleep = sleep_of(0.1, "timer3")
    timer4_sleep = sleep_of(0.1, "timer4")


class FourTimers(Demo[FourTimersParameters]):
    """Four timers with the same period, started together.

    :param node: the node's API
    :param declaration: class that declares its parameters
    """

    def __init__(
        self, node: Node, declaration: Type[FourTimersParameters] = FourTimersParameters
    ) -> None:
        super().__init__(node, declaration)
        self._node = node

    def start_timers(
        self,
        group1: CallbackGroup,
        group2: CallbackGroup,
        group3: CallbackGroup,
        group4: CallbackGroup,
    ) -> None:
        """Start the timers, each in its callback group.

        :param group1: group of timer1, and so on
        """
        self._node.create_timer(self._rate, self.timer1, group=group1)
        self._node.create_timer(self._rate, self.timer2, group=group2)
        self._node.create_timer(self._rate, self.timer3, group=group3)
        self._node.create_timer(self._rate, self.timer4, group=group4)

    def _rate(self) -> float:
        return 1.0 / self.settings.period

    def timer1(self, elapsed: float) -> None:
        """Work for ``~timer1_sleep``."""
        self.work("timer1", self.settings.timer1_sleep)

    def timer2(self, elapsed: float) -> None:
        """Work for ``~timer2_sleep``."""
        self.work("timer2", self.settings.timer2_sleep)

    def timer3(self, elapsed: float) -> None:
        """Work for ``~timer3_sleep``."""
        self.work("timer3", self.settings.timer3_sleep)

    def timer4(self, elapsed: float) -> None:
        """Work for ``~timer4_sleep``."""
        self.work("timer4", self.settings.timer4_sleep)
