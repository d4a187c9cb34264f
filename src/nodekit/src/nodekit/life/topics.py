"""The topics and services of a node."""

from typing import Any, Callable, List, NamedTuple, Optional

import rospy

from nodekit.life.callbacks import Answering, Receiving
from nodekit.life.groups import Group
from nodekit.life.names import Names
from nodekit.life.opening import Opener
from nodekit.life.ownership import Owner
from nodekit.life.timers import RateFollowers
from nodekit.messaging.finite import is_finite
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.service import Service
from nodekit.messaging.subscription import Latest, Subscription

#: Least time between two warnings about messages that are left out, s.
_WARN_EVERY_S = 10.0


class Surroundings(NamedTuple):
    """What all lifetimes of a node have in common.

    :param names: where its names are
    :param opener: opens what they make
    :param group: the group of callbacks that are given none
    :param rates: timers whose rates follow the node's parameters
    """

    names: Names
    opener: Opener
    group: Group
    rates: RateFollowers


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

    def __str__(self) -> str:
        return self.name

    def publisher(
        self, name: str, data_class: type, latch: bool = False, queue_size: Optional[int] = None
    ) -> Publisher:
        """Publish a topic.

        :param name: topic
        :param data_class: message class
        :param latch: whether later subscribers get the last message
        :param queue_size: not used, as there is no queue; taken because rospy's users give it
        """
        return self._open(Publisher(self.resolve(name), data_class, latch))

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
        :param queue_size: not used: while the callback is busy, messages wait with the sender;
            taken because rospy's users give it
        :param finite: leave out, with a warning, messages that have NaN or infinity in a field
        :param group: the callback's group; the node's own by default
        """

        resolved = self.resolve(name)

        def only_finite(message: Any) -> None:
            if is_finite(message):
                callback(message)
            else:
                text = "%s: %s is not finite and is left out"
                rospy.logwarn_throttle_identical(
                    _WARN_EVERY_S, text % (resolved, " ".join(str(message).split()))
                )

        return self._hear(name, data_class, only_finite if finite else callback, False, group)

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
        return self._hear(name, data_class, callback, True, group)

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

    def _hear(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        batches: bool,
        group: Optional[Group],
    ) -> Subscription:
        resolved = self.resolve(name)
        receiving = Receiving(group or self._surroundings.group, callback, resolved, batches)
        return self._open(Subscription(resolved, data_class, self.own(receiving).receive))

    def resolve(self, name: str) -> str:
        """Return a global name.

        :param name: relative, private (``~name``) or global
        """
        return self._surroundings.names.resolve(name)
