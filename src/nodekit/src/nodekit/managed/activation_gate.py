"""Publishers and timers that work only while their node is active, and their switch."""

import threading
from typing import Any, Callable, List, Optional, Sequence, Set, Union

import rospy

from nodekit.groups.callback_groups import NoGroup
from nodekit.messaging.publisher import Publisher
from nodekit.node.callbacks import Callback
from nodekit.node.timers import NodeTimer
from nodekit.timing.scheduler import checked_rate


class ActivationGate:
    """Switch of a managed node's publishers and timers.

    :ivar publishes: whether messages are published
    :ivar ticks: whether timers tick
    :ivar closings: how often publishing was switched off
    :ivar deactivate_hooks: callbacks to call before publishing is switched off
    """

    def __init__(self) -> None:
        self.publishes = self.ticks = False
        self.closings = 0
        self.deactivate_hooks: List[DeactivateHook] = []
        self._lock = threading.Lock()
        self._members: Set[Union[ManagedPublisher, ManagedTimer]] = set()

    def add(self, thing: "Union[ManagedPublisher, ManagedTimer]") -> None:
        """Notify a publisher or a timer from now on.

        :param thing: a new one
        """
        with self._lock:
            self._members.add(thing)

    def remove(self, thing: "Union[ManagedPublisher, ManagedTimer]") -> None:
        """Notify a publisher or a timer no longer.

        :param thing: one that was added
        """
        with self._lock:
            self._members.discard(thing)

    def allow_publishing(self, publishes: bool) -> None:
        """Switch publishing on or off.

        :param publishes: whether messages are published
        """
        if self.publishes and not publishes:
            self.closings += 1
            for hook in list(self.deactivate_hooks):
                hook.call()
        self.publishes = publishes
        self._notify()

    def allow_ticking(self, ticks: bool) -> None:
        """Switch timers on, with an immediate first tick, or off.

        :param ticks: whether they tick
        """
        self.ticks = ticks
        self._notify()

    def _notify(self) -> None:
        with self._lock:
            members = list(self._members)
        for thing in members:  # without the lock: a timer calls the node's code for its rate
            thing.update()


class DeactivateHook(Callback):
    """Callback that is called just before publishing is switched off.

    :param gate: calls it, within a transition and so inside the node's default group
    :param function: the function
    :param what: names it in the log
    """

    takes = 0

    def __init__(self, gate: ActivationGate, function: Callable[[], Any], what: str) -> None:
        super().__init__(NoGroup(), function, what)
        self._gate = gate
        gate.deactivate_hooks.append(self)

    def close(self) -> None:
        """Remove the callback from the gate."""
        self._gate.deactivate_hooks.remove(self)
        super().close()


class ManagedPublisher(Publisher):
    """Publisher that publishes only while its node is active.

    Messages at other times are dropped. The last message of a latched topic is a state: it is kept
    and sent when the node becomes active.

    :param gate: holds whether the node is active
    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: how long they get the last message if it is not latched [s]
    :param queue_size: most messages held for a subscriber that does not read

    :ivar dropped: number of dropped messages
    """

    def __init__(
        self,
        gate: ActivationGate,
        name: str,
        data_class: type,
        latch: bool,
        lifespan: float = 0.0,
        queue_size: Optional[int] = None,
    ) -> None:
        super().__init__(name, data_class, latch, lifespan, queue_size)
        self.dropped = 0
        self._gate = gate
        self._kept: Any = None
        self._keeping, self._sending = threading.Lock(), threading.Lock()
        self._warned_of: Optional[int] = None
        gate.add(self)

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Send a message, see :meth:`.Publisher.publish`; drop it if the node is not active."""
        if self._passes:
            super().publish(*args, **kwds)
            return
        message = self._to_message(args, kwds)  # a dropped message is checked too
        if self._latch:
            self._keep(message)
        else:
            self._drop(1)

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send messages, see :meth:`.Publisher.publish_all`, or drop them."""
        if self._passes:
            super().publish_all(messages)
        elif not self._latch:
            self._drop(len(messages))
        elif messages:
            self._keep(messages[-1])

    @property
    def _passes(self) -> bool:
        """Whether a message is sent now: the gate is open, and no kept message precedes it."""
        return self._is_closed or (self._gate.publishes and self._kept is None)

    def update(self) -> None:
        """Send the kept message if the gate is open; later messages follow it."""
        # One thread sends, and no other waits for it: a subscriber may publish in its callback.
        while self._gate.publishes and self._kept is not None and self._sending.acquire(False):
            kept = self._kept
            try:
                if kept is not None:  # else another thread has just sent it
                    super().publish(kept)
            finally:
                with self._keeping:
                    if self._kept is kept:
                        self._kept = None
                self._sending.release()

    def close(self) -> None:
        """Stop publishing."""
        self._gate.remove(self)
        self._kept = None
        super().close()

    def _keep(self, message: Any) -> None:
        with self._keeping:
            self._kept = message
        self.update()  # the gate may have opened meanwhile

    def _drop(self, count: int) -> None:
        self.dropped += count
        if self._warned_of != self._gate.closings:  # once per inactive phase
            self._warned_of = self._gate.closings
            text = "%s: messages are dropped because the node is not active; %d in all"
            rospy.logwarn(text, self.resolved_name, self.dropped)


class ManagedTimer(NodeTimer):
    """Timer that ticks only while its node is active.

    :param gate: holds whether the node is active
    :param options: as for :class:`.NodeTimer`
    """

    def __init__(self, gate: ActivationGate, *options: Any) -> None:
        super().__init__(*options)
        self._gate = gate
        self._wanted = self._rate
        gate.add(self)
        self.update()

    def set_rate(self, rate: float) -> None:
        """Change the rate, now or once the node is active.

        :param rate: calls per second [Hz]; 0 pauses
        :raises ValueError: if a timer cannot keep it; the old rate stays
        """
        self._wanted = checked_rate(rate)
        self.update()

    def update_rate(self) -> None:
        """Call the rate function, if there is one, unless the gate is closed."""
        if callable(self._rate):
            self._wanted = self._rate
        self.update()

    def update(self) -> None:
        """Start or stop ticking, according to the gate."""
        ticks: Optional[bool] = None
        while ticks is not self._gate.ticks:  # the gate may change while the rate function runs
            ticks = self._gate.ticks
            if not ticks:
                self._timer.set_rate(0.0)
            elif callable(self._wanted):
                super().update_rate()
            else:
                with self._lock:  # so that the latest rate is set last
                    self._timer.set_rate(self._wanted)

    def close(self) -> None:
        """Stop the timer, and start no new calls."""
        self._gate.remove(self)
        super().close()
