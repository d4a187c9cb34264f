"""What tells a manager, at any time, that a managed node's process is alive."""

import functools

import rospy
from std_msgs.msg import Header

from nodekit.node.lifetime import Lifetime
from nodekit.timing.clocks import MonotonicClock
from nodekit.timing.scheduler import Scheduler, Timer

#: Rate of the heartbeat, Hz, by the machine's clock.
BEATS_HZ = 5.0


class Heart:
    """Publishes ``~heartbeat`` in any state, beside all callbacks: one that takes long stops none.

    Without a subscriber nothing is sent.

    :param node: the node; the heart is closed with it
    """

    def __init__(self, node: Lifetime) -> None:
        self._publisher = node.publisher("~heartbeat", Header)
        self._beats = 0
        self._timer = Timer(_scheduler(), self._beat, BEATS_HZ)
        _scheduler().start([self._timer])
        node.own(self)

    def _beat(self, _: float) -> None:
        self._beats += 1
        self._publisher.publish(self._beats, rospy.get_rostime(), "")

    def close(self) -> None:
        """Beat no longer."""
        self._timer.close()


@functools.lru_cache(maxsize=None)
def _scheduler() -> Scheduler:
    """Return the scheduler of all hearts of this process: its thread makes no user's call."""
    return Scheduler(MonotonicClock())
