"""A clock that a test steps, waiting for robots at each step: neither luck nor lost time."""

import threading
import time
from typing import Any, Callable, Dict, List

import rospy
from rosgraph_msgs.msg import Clock

from nodekit.testing.waiting import TIMEOUT_S

#: Steps a second: odometry comes at every second one, commands at every third one.
STEPS_HZ = 60
#: How far a stamp may be behind, s: a step, as rospy may hear of it after a node's timer has, less
#: what rounding makes of it.
_BEHIND = 1.0 / STEPS_HZ - 1e-6
#: Longest wait at a step, and pause where a topic that is not waited for is silent [s].
_PATIENCE_S, _PAUSE_S = 0.1, 0.01


class SteppedClock:
    """Publishes /clock, and waits until all messages have the time of the clock.

    Nodes use only this clock, so their behaviour is the same on machines of any speed.
    """

    def __init__(self) -> None:
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._changed = threading.Condition()
        self._periods: Dict[str, float] = {}
        self._heard: Dict[str, List[Any]] = {}
        self._steps = 100 * STEPS_HZ
        self._kept_at = time.monotonic()

    @property
    def now(self) -> float:
        """The time [s]."""
        return self._steps / STEPS_HZ

    def subscribe(self, topic: str, data_class: Any, rate: float) -> None:
        """Wait at each step for messages with stamps at a rate.

        :param topic: name
        :param data_class: message class
        :param rate: Hz; 0 not to wait for them
        """
        self._heard[topic] = []
        self.expect(topic, rate)
        rospy.Subscriber(topic, data_class, self._on_message, topic, tcp_nodelay=True)

    def expect(self, topic: str, rate: float) -> None:
        """Change the rate of a topic's messages.

        :param topic: an observed topic
        :param rate: Hz; 0 to stop waiting for them
        """
        self._periods.pop(topic, None)
        if rate:
            self._periods[topic] = 1.0 / rate

    def heard(self, topic: str) -> List[Any]:
        """Return the received messages, oldest first."""
        with self._changed:
            return list(self._heard[topic])

    def forget(self) -> None:
        """Start over."""
        with self._changed:
            self._heard = {topic: messages[-1:] for topic, messages in self._heard.items()}

    def _on_message(self, message: Any, topic: str) -> None:
        with self._changed:
            self._heard[topic].append(message)
            self._changed.notify_all()

    def _late(self) -> List[str]:
        """Return the topics whose messages are older than their period."""
        return [
            topic
            for topic, period in self._periods.items()
            if not self._heard[topic]
            or self._heard[topic][-1].header.stamp.to_sec() <= self.now - period - _BEHIND
        ]

    def step(self, *but: str) -> None:
        """Advance by one step.

        :param but: topics that are not waited for
        """
        self._steps += 1
        self._clock.publish(Clock(rospy.Time.from_sec(self.now)))
        with self._changed:
            # With a timeout: a slow node may need the next step to continue.
            if self._changed.wait_for(lambda: set(self._late()) <= set(but), _PATIENCE_S):
                self._kept_at = time.monotonic()
            if set(but).intersection(self._late()):
                self._changed.wait(_PAUSE_S)  # limits the speed of simulated time
        if time.monotonic() - self._kept_at > TIMEOUT_S:
            raise AssertionError(f"at {self.now} s nothing new on {self._late()}")

    def step_until(self, condition: Callable[[], Any], what: str, longest: float, *but: str) -> Any:
        """Step until a condition holds; return its result.

        :param condition: evaluated after each step
        :param what: describes the missing condition
        :param longest: timeout by this clock [s]
        :param but: topics that are not waited for
        """
        end = self.now + longest
        while self.now < end:
            self.step(*but)
            answer = condition()
            if answer:
                return answer
        raise AssertionError(f"after {longest:g} s: {what}")

    def begin(self) -> None:
        """Step until all topics are heard."""
        for _ in range(round(TIMEOUT_S / 0.05)):
            self._steps += 1
            self._clock.publish(Clock(rospy.Time.from_sec(self.now)))
            with self._changed:
                if self._changed.wait_for(lambda: not self._late(), 0.05):
                    return
        raise AssertionError(f"nothing on {self._late()}")
