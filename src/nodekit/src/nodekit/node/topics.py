"""The topics and services of a node."""

from typing import Any, Callable, Iterator, List, Optional

import rospy

from nodekit.groups.groups import Group
from nodekit.groups.line import Line
from nodekit.messaging.finite import is_finite
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.seldom import Seldom
from nodekit.messaging.service import Service
from nodekit.messaging.stream_log import shortened
from nodekit.messaging.subscription import Latest, Subscription
from nodekit.node.callbacks import DEPTH, MOST_KEPT, Answering, Callback, Receiving
from nodekit.node.clients import Client
from nodekit.node.names import Names
from nodekit.node.opening import Opener
from nodekit.node.ownership import Owner, Thing
from nodekit.node.timers import RateFollowers

#: Least time between two warnings about messages that are left out, s.
_WARN_EVERY_S = 10.0


class Surroundings:
    """What all lifetimes of a node have in common.

    :param names: where its names are
    :param opener: opens what they make

    :ivar group: the group of callbacks that are given none
    :ivar rates: timers whose rates follow the node's parameters
    :ivar line: the executor's that makes their calls, None without one
    """

    __slots__ = ("names", "opener", "group", "rates", "line")

    def __init__(self, names: Names, opener: Opener) -> None:
        self.names, self.opener = names, opener
        self.group, self.rates = Group(), RateFollowers()
        self.line: Optional[Line] = None


class TopicMaker(Owner):
    """Makes publishers, subscriptions and services for a node.

    Names are relative, private (``~name``) or global. Callbacks are called in the node's own group,
    one at a time, unless another ``group`` is given.

    :param surroundings: the node's
    """

    def __init__(self, surroundings: Surroundings) -> None:
        super().__init__(surroundings.opener)
        self._surroundings = surroundings

    @property
    def name(self) -> str:
        """Global name of the node."""
        return self._surroundings.names.node

    @property
    def default_group(self) -> Group:
        """The group of callbacks that are given none."""
        return self._surroundings.group

    def __str__(self) -> str:
        return self.name

    def own(self, thing: Thing) -> Thing:
        """Close something with the rest; see :meth:`.Owner.own`."""
        if isinstance(thing, Callback):
            thing.attach(self._surroundings.line)
        return super().own(thing)

    def attach(self, line: Optional[Line]) -> None:
        """Have an executor make the calls of this node from now on, or rospy's threads.

        :param line: the executor's, None for none
        """
        self._surroundings.line = line
        for callback in self.callbacks():
            callback.attach(line)

    def callbacks(self) -> Iterator[Callback]:
        """Return the callbacks of this node, but not those of nodes that it hosts."""
        for thing in list(self._made):
            if isinstance(thing, Callback):
                yield thing
            elif isinstance(thing, TopicMaker) and thing._surroundings is self._surroundings:
                yield from thing.callbacks()

    def publisher(
        self,
        name: str,
        data_class: type,
        latch: bool = False,
        queue_size: Optional[int] = None,
        lifespan: float = 0.0,
    ) -> Publisher:
        """Publish a topic.

        :param name: topic
        :param data_class: message class
        :param latch: whether later subscribers get the last message
        :param queue_size: not used, as there is no queue; taken because rospy's users give it
        :param lifespan: for how long later subscribers get the last message, s, where it is not
            latched; it must not be changed after it was published
        """
        return self._open(Publisher(self.resolve(name), data_class, latch, lifespan))

    def subscribe(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        queue_size: Optional[int] = None,
        finite: bool = False,
        group: Optional[Group] = None,
    ) -> Subscription:
        """Hear a topic.

        :param name: topic
        :param data_class: message class
        :param callback: called with each message
        :param queue_size: with an executor, how many messages wait for it, :data:`.DEPTH` by
            default, the newest ones; -1, as with rospy, for as many as may be,
            :data:`.MOST_KEPT`. Not used without one: while the callback is busy, messages wait
            with the sender
        :param finite: leave out, with a warning, messages that have NaN or infinity in a field
        :param group: the callback's group; the node's own by default
        :raises ValueError: if the queue size is none
        """

        resolved, seldom = self.resolve(name), Seldom(_WARN_EVERY_S)

        def only_finite(message: Any) -> None:
            if is_finite(message):
                callback(message)
            elif seldom.is_due():
                text = shortened(" ".join(str(message).split()))
                rospy.logwarn("%s: %s is not finite and is left out", resolved, text)

        depth = _depth(queue_size)
        return self._hear(name, data_class, only_finite if finite else callback, depth, group)

    def subscribe_batches(
        self,
        name: str,
        data_class: type,
        callback: Callable[[List[Any]], Any],
        group: Optional[Group] = None,
    ) -> Subscription:
        """Hear a topic, all messages that have arrived together at once.

        After a busy moment they are many, which are then handled and answered together: that is
        what makes up for the delay.

        :param name: topic
        :param data_class: message class
        :param callback: called with a list of messages, oldest first
        :param group: the callback's group; the node's own by default
        """
        return self._hear(name, data_class, callback, MOST_KEPT, group, batches=True)

    def latest(self, name: str, data_class: type) -> Latest:
        """Keep the latest message of a topic.

        :param name: topic
        :param data_class: message class
        :returns: an object with ``message``, None before the first, and its ``age`` in s
        """
        latest = Latest(self.resolve(name), data_class)
        self._open(latest.subscription)
        return latest

    def service(
        self,
        name: str,
        service_class: type,
        handler: Callable[[Any], Any],
        group: Optional[Group] = None,
    ) -> Service:
        """Offer a service.

        :param name: name
        :param service_class: its type
        :param handler: returns the answer to a request
        :param group: the handler's group; the node's own by default
        """
        resolved = self.resolve(name)
        callback = self.own(Answering(group or self._surroundings.group, handler, resolved))
        return self._open(Service(resolved, service_class, callback.answer))

    def client(self, name: str, service_class: type, group: Optional[Group] = None) -> Client:
        """Call a service.

        :param name: name
        :param service_class: its type
        :param group: of callbacks that are told of answers; the node's own by default
        """
        resolved = self.resolve(name)
        group = group or self._surroundings.group
        done = self.own(Callback(group, lambda function, future: function(future), resolved))
        return self.own(Client(resolved, service_class, done))

    def _hear(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        depth: int,
        group: Optional[Group],
        batches: bool = False,
    ) -> Subscription:
        resolved = self.resolve(name)
        group = group or self._surroundings.group
        receiving = Receiving(group, callback, resolved, batches, depth)
        return self._open(Subscription(resolved, data_class, self.own(receiving).receive))

    def resolve(self, name: str) -> str:
        """Return a global name.

        :param name: relative, private (``~name``) or global
        """
        return self._surroundings.names.resolve(name)


def _depth(queue_size: Optional[int]) -> int:
    """Return how many messages wait for an executor."""
    if queue_size is None:
        return DEPTH
    if queue_size == -1:
        return MOST_KEPT
    if isinstance(queue_size, int) and queue_size > 0:
        return queue_size
    allowed = "must be a whole number from 1 on, or -1 for no limit of its own"
    raise ValueError(f"queue_size: refused {queue_size!r}: {allowed}")
