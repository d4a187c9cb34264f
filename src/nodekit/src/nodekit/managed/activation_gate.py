"""What speaks only while its node is active: publishers and timers."""

import threading
from typing import Any, Callable, List, Optional, Sequence, Set, Union

import rospy

from nodekit.groups.callback_groups import NoGroup
from nodekit.messaging.publisher import Publisher
from nodekit.node.callbacks import Callback
from nodekit.node.timers import NodeTimer
from nodekit.timing.scheduler import checked_rate


class ActivationGate:
    """What a managed node's publishers and timers ask, and are told by.

    :ivar publishes: whether messages pass
    :ivar ticks: whether timers tick
    :ivar closings: how often it has kept messages from passing
    :ivar deactivate_hooks: what is called before it does so
    """

    def __init__(self) -> None:
        self.publishes = self.ticks = False
        self.closings = 0
        self.deactivate_hooks: List[DeactivateHook] = []
        self._lock = threading.Lock()
        self._told: Set[Union[ManagedPublisher, ManagedTimer]] = set()

    def add(self, thing: "Union[ManagedPublisher, ManagedTimer]") -> None:
        """Tell a publisher or a timer from now on.

        :param thing: one that is held
        """
        with self._lock:
            self._told.add(thing)

    def forget(self, thing: "Union[ManagedPublisher, ManagedTimer]") -> None:
        """Tell one nothing any more.

        :param thing: one that was added
        """
        with self._lock:
            self._told.discard(thing)

    def allow_publishing(self, publishes: bool) -> None:
        """Let messages pass, or keep them.

        :param publishes: whether they pass
        """
        if self.publishes and not publishes:
            self.closings += 1
            for word in list(self.deactivate_hooks):
                word.call()
        self.publishes = publishes
        self._notify()

    def allow_ticking(self, ticks: bool) -> None:
        """Let timers tick, the first time at once, or hold them.

        :param ticks: whether they tick
        """
        self.ticks = ticks
        self._notify()

    def _notify(self) -> None:
        with self._lock:
            told = list(self._told)
        for thing in told:  # without the lock: a timer asks the node's code for its rate
            thing.update()


class DeactivateHook(Callback):
    """A function that is called while messages pass, just before they do no more.

    :param gate: calls it; within a transition, so in the node's default group already
    :param function: the function
    :param what: names it in the log
    """

    def __init__(self, gate: ActivationGate, function: Callable[[], Any], what: str) -> None:
        super().__init__(NoGroup(), function, what)
        self._gate = gate
        gate.deactivate_hooks.append(self)

    def close(self) -> None:
        """Make no call any more."""
        self._gate.deactivate_hooks.remove(self)
        super().close()


class ManagedPublisher(Publisher):
    """A publisher that publishes only while its node is active.

    What it is given at other times is dropped; of a latched topic, which tells a state, the last
    message is kept and sent when the node becomes active.

    :param gate: says whether it is
    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: for how long they get it where it is not latched, s

    :ivar dropped: how many messages were not sent
    """

    def __init__(
        self, gate: ActivationGate, name: str, data_class: type, latch: bool, lifespan: float = 0.0
    ) -> None:
        super().__init__(name, data_class, latch, lifespan)
        self.dropped = 0
        self._gate = gate
        self._kept: Any = None
        self._keeping, self._sending = threading.Lock(), threading.Lock()
        self._warned_of: Optional[int] = None
        gate.add(self)

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Send a message, see :meth:`.Publisher.publish`, or drop it if the node is not active."""
        if self._passes:
            super().publish(*args, **kwds)
        elif self._latch:
            self._keep(rospy.msg.args_kwds_to_message(self.data_class, args, kwds))
        else:
            self._drop(1)

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send messages, see :meth:`.Publisher.publish_all`, or drop them likewise."""
        if self._passes:
            super().publish_all(messages)
        elif not self._latch:
            self._drop(len(messages))
        elif messages:
            self._keep(messages[-1])

    @property
    def _passes(self) -> bool:
        """Whether a message goes out at once: the gate is open, and none is before it."""
        return self._is_closed or (self._gate.publishes and self._kept is None)

    def update(self) -> None:
        """Send what was kept, if the gate is open; what comes meanwhile goes out after it."""
        # One thread sends, and none waits for it: who hears a message may publish one in turn.
        while self._gate.publishes and self._kept is not None and self._sending.acquire(False):
            kept = self._kept
            try:
                if kept is not None:  # another thread may have sent it just before
                    super().publish(kept)
            finally:
                with self._keeping:
                    if self._kept is kept:
                        self._kept = None
                self._sending.release()

    def close(self) -> None:
        """Publish no longer."""
        self._gate.forget(self)
        self._kept = None
        super().close()

    def _keep(self, message: Any) -> None:
        with self._keeping:
            self._kept = message
        self.update()  # it may have been opened meanwhile

    def _drop(self, count: int) -> None:
        self.dropped += count
        if self._warned_of != self._gate.closings:  # once in a while of silence
            self._warned_of = self._gate.closings
            text = "%s: messages are dropped because the node is not active; %d in all"
            rospy.logwarn(text, self.resolved_name, self.dropped)


class ManagedTimer(NodeTimer):
    """A timer that ticks only while its node is active.

    :param gate: says whether it is
    :param options: as for :class:`.NodeTimer`
    """

    def __init__(self, gate: ActivationGate, *options: Any) -> None:
        super().__init__(*options)
        self._gate = gate
        self._wanted = self._rate
        gate.add(self)
        self.update()

    def set_rate(self, rate: float) -> None:
        """Change the rate, at once or from when the node is active again.

        :param rate: calls a second, Hz; 0 pauses
        :raises ValueError: if it is not one to keep; the old one stays
        """
        self._wanted = checked_rate(rate)
        self.update()

    def follow(self) -> None:
        """Ask for the rate, where it is a function, unless the timer is held."""
        if callable(self._rate):
            self._wanted = self._rate
        self.update()

    def update(self) -> None:
        """Tick or do not, as the gate has it."""
        ticks: Optional[bool] = None
        while ticks is not self._gate.ticks:  # it may change while the rate is asked for
            ticks = self._gate.ticks
            if not ticks:
                self._timer.set_rate(0.0)
            elif callable(self._wanted):
                super().follow()
            else:
                with self._lock:  # so that what is wanted last is set last
                    self._timer.set_rate(self._wanted)

    def close(self) -> None:
        """Make no call any more."""
        self._gate.forget(self)
        super().close()
