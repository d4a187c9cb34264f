"""What a node's class is given, and makes everything through."""

from typing import Any, Callable, Collection, List, Optional, Protocol, Type, TypeVar

from nodekit.groups.groups import Group
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.service import Service
from nodekit.messaging.stream_log import StreamLog
from nodekit.messaging.subscription import Latest, Subscription
from nodekit.node.clients import Client
from nodekit.node.timers import NodeTimer, Rate
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameters.declaration import Rule, Snapshot

Thing = TypeVar("Thing")


class Maker(Protocol):
    """Makes all that a node uses, and owns it.

    A :class:`.Node` is one; so is a :class:`.Lifetime`, and what a managed node's callbacks are
    given. A class that asks for no more than a Maker can be run, hosted and managed; one that hosts
    other nodes, or has an executor, needs a whole Node.

    Names are relative, private (``~name``) or global. Callbacks are called in the node's own group,
    one at a time, unless another ``group`` is given. What is not of the kind that is asked for is
    refused at once with a TypeError: a callback that is none or ``async def``, a class that is not
    a message's or a service's.
    """

    @property
    def name(self) -> str:
        """Global name of the node."""
        ...

    @property
    def default_group(self) -> Group:
        """The group of callbacks that are given none."""
        ...

    def resolve(self, name: str) -> str:
        """Return a global name.

        :param name: relative, private (``~name``) or global
        :raises IllegalName: if ROS does not allow that name, as it is or as it was remapped
        """
        ...

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
        ...

    def subscribe(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        queue_size: Optional[int] = None,
        finite: bool = False,
        group: Optional[Group] = None,
    ) -> Subscription:
        """Subscribe to a topic.

        :param name: topic
        :param data_class: message class
        :param callback: called with each message
        :param queue_size: with an executor, how many messages wait for it, :data:`.DEPTH` by
            default, the newest ones; -1, as with rospy, for as many as may be,
            :data:`.MOST_KEPT`. Not used without one: while the callback is busy, messages wait
            with the sender
        :param finite: leave out, with a warning, messages that have NaN or infinity in a field
        :param group: the callback's group; the node's own by default
        :raises ValueError: if the queue size is not one to keep
        """
        ...

    def subscribe_batches(
        self,
        name: str,
        data_class: type,
        callback: Callable[[List[Any]], Any],
        group: Optional[Group] = None,
    ) -> Subscription:
        """Subscribe to a topic, and get all messages that have arrived together at once.

        After a busy moment they are many, which are then handled and answered together: that is
        what makes up for the delay.

        :param name: topic
        :param data_class: message class
        :param callback: called with a list of messages, oldest first
        :param group: the callback's group; the node's own by default
        """
        ...

    def latest(self, name: str, data_class: type) -> Latest:
        """Keep the latest message of a topic.

        :param name: topic
        :param data_class: message class
        :returns: an object with ``message``, None before the first, and its ``age`` in s
        """
        ...

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
        ...

    def client(self, name: str, service_class: type, group: Optional[Group] = None) -> Client:
        """Call a service.

        :param name: name
        :param service_class: its type
        :param group: of callbacks that are told of answers; the node's own by default
        """
        ...

    def every(
        self,
        rate: Rate,
        callback: Callable[[float], Any],
        catch_up: float = 0.0,
        steady: bool = False,
        group: Optional[Group] = None,
    ) -> NodeTimer:
        """Call a function at a rate, the first time at once, without drift.

        :param rate: calls a second, Hz; 0 pauses. Of a function the result: it is asked at the
            start and after each change of parameters of this node
        :param callback: called with the time since the first call, s; short
        :param catch_up: lateness up to which calls are made up for, s; never on a simulated clock
        :param steady: go by the machine's clock also where /use_sim_time is set
        :param group: the callback's group; the node's own by default
        :raises ValueError: if the rate is a number that no timer can keep
        """
        ...

    def parameters(
        self,
        declaration: Type[Snapshot],
        on_change: Optional[Callable[[Snapshot, Snapshot], Any]] = None,
        exempt: Collection[str] = (),
        group: Optional[Group] = None,
        rules: Collection[Rule] = (),
    ) -> "LiveParameters[Snapshot]":
        """Read and judge the node's private parameters now, and follow them from the start on.

        :param declaration: the class that declares them
        :param on_change: called with the new and the old values after a change; short, without an
            executor, since the changes of all other nodes of the process wait for it
        :param exempt: names beside them that are used but not declared
        :param group: the callback's group; the node's own by default
        :param rules: methods of the node's class that are marked by :func:`nodekit.rule`, and
            judge beside those of the declaration, at the start and each change
        :returns: an object whose ``values`` are those in force
        :raises ValueError: if this node has parameters already
        :raises ParameterError: if a value on the server is not allowed
        """
        ...

    def follow(
        self, key: str, callback: Callable[[Any], Any], group: Optional[Group] = None
    ) -> None:
        """Follow a parameter that is not declared, or not this node's.

        :param key: name of the parameter
        :param callback: called with its value, None where it is not set: once at the start and
            after each change; short, without an executor, as of :meth:`parameters`
        :param group: the callback's group; the node's own by default
        """
        ...

    def stream_log(self, per_second: int = 10) -> StreamLog:
        """Log lines at info, of a quick stream a part.

        :param per_second: how many lines a second are logged, 1/s
        """
        ...

    def group(self, exclusive: bool = True, urgent: bool = False) -> Group:
        """Make a callback group.

        :param exclusive: whether its callbacks exclude each other
        :param urgent: whether an executor makes its calls before those of all other groups
        """
        ...

    def lifetime(self) -> "Maker":
        """Return another maker, whose ``close`` ends only what was made through it."""
        ...

    def own(self, thing: Thing) -> Thing:
        """Close something together with what was made through this.

        :param thing: anything with a method ``close``
        :returns: the thing
        :raises Closed: if this is closed
        """
        ...

    def close(self) -> None:
        """Close all that was made through this, the latest first; see :meth:`.Owner.close`."""
        ...

    def before_end(self, callback: Callable[[], Any]) -> None:
        """Have a function called when the process is told to end, while all of it still works.

        These functions come first, those that were given last before the others. Then managed nodes
        go through shutdown; then calls of services are cancelled, and executors and timers stop.

        :param callback: what to call, in no group; it has less than 2 s
        """
        ...

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        """Have a function called whenever the node stops being active, while it still publishes.

        A managed node does so on its way through shutdown too. Any other is active until the
        process is told to end: then it is called as those of :meth:`before_end` are.

        :param callback: what to call; of a managed node, in its default group
        """
        ...
