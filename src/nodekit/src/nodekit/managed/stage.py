"""What one callback of a managed node makes, and how long it lives."""

from typing import Any, Callable, Optional

from nodekit.groups.groups import Group, Outside
from nodekit.managed.gate import Gate, LastWord, ManagedPublisher, ManagedTimer
from nodekit.messaging.publisher import Publisher
from nodekit.node.lifetime import Lifetime, Part
from nodekit.node.opening import Opener
from nodekit.node.timers import NodeTimer
from nodekit.timing.scheduler import Scheduler

#: Attributes that a whole node has and a stage has not, and what a class does that uses them.
_OF_A_NODE = {"host": "hosts another node", "executor": "has an executor of its own"}


class CannotManage(AttributeError):
    """A class uses what no managed node can give it; the text says what it does."""


class Stage(Part):
    """Makes things that are opened together once the callback that makes them has succeeded.

    Its publishers publish and its timers tick only while the node is active.

    :param whole: what it is closed with
    :param gate: says whether the node is active
    :param made_at: label of the transition that makes it
    :param opener: opens what is made; one of its own by default
    """

    def __init__(
        self, whole: Lifetime, gate: Gate, made_at: str, opener: Optional[Opener] = None
    ) -> None:
        super().__init__(whole)
        self._made_at = made_at
        self._anew = f"at the next {made_at}"
        self._opener = opener or Opener()
        self._gate = gate

    def open(self) -> None:
        """Open what was made; what is made from now on is opened at once.

        :raises rospy.ROSException: if a topic is used with two types
        """
        self._opener.start()

    def publisher(
        self,
        name: str,
        data_class: type,
        latch: bool = False,
        queue_size: Optional[int] = None,
        lifespan: float = 0.0,
    ) -> Publisher:
        """Publish a topic while the node is active; see :meth:`.Maker.publisher`."""
        name = self.resolve(name)
        return self._open(ManagedPublisher(self._gate, name, data_class, latch, lifespan))

    def lifetime(self) -> Lifetime:
        """Return a maker of its own; see :meth:`.Maker.lifetime`."""
        return self.own(Stage(self, self._gate, self._made_at, self._opener))

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        """Have a function called before silence; see :meth:`.Maker.before_deactivate`."""
        self.own(LastWord(self._gate, callback, f"{self.name}: before_deactivate"))

    def __getattr__(self, name: str) -> Any:
        if name in _OF_A_NODE:
            raise CannotManage(_OF_A_NODE[name])
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def _timer(self, scheduler: Scheduler, group: Group, *options: Any) -> NodeTimer:
        if isinstance(group, Outside):  # the toolkit's own
            return super()._timer(scheduler, group, *options)
        return ManagedTimer(self._gate, scheduler, group, *options)
