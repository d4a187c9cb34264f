"""What a node makes, and how long it lives."""

import contextlib
from functools import partial
from typing import Any, Callable, Collection, Iterator, List, Optional, Type

import rospy
from std_srvs.srv import Trigger

from nodekit.call_arguments import judge_function, judge_name, judge_service_class
from nodekit.groups.groups import Group, Outside, ReentrantGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.messaging.finite import is_finite
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.service import Service
from nodekit.messaging.stream_log import StreamLog, shortened
from nodekit.messaging.subscription import Latest, Subscription
from nodekit.messaging.throttle import Throttle
from nodekit.node.callbacks import DEPTH, MOST_KEPT, Answering, Callback, Receiving
from nodekit.node.clients import Client
from nodekit.node.maker import Maker, Thing
from nodekit.node.names import Names
from nodekit.node.opening import Opener
from nodekit.node.ownership import Owner
from nodekit.node.parameter_callbacks import ChangeCallback, FollowCallback
from nodekit.node.timers import NodeTimer, Rate, RateFollowers
from nodekit.parameter_server import reconfigure
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.services import change_handler, description_handler
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.class_rules import judge_rules
from nodekit.parameters.declaration import OwnParameters, ParameterSet, Rule, Snapshot
from nodekit.parameters.schema import AT_START
from nodekit.rospy_internals.shutdown import Ending, at_end
from nodekit.timing.scheduler import Scheduler, get_scheduler
from nodekit_msgs.srv import SetParameters

#: Least time between two warnings about messages that are left out, s.
_WARN_EVERY_S = 10.0


class Surroundings:
    """What all lifetimes of a node have in common.

    :param names: where its names are
    :param opener: opens what they make

    :ivar group: the group of callbacks that are given none
    :ivar rates: timers whose rates follow the node's parameters
    :ivar ready: the queue of the executor that makes their calls, None without one
    :ivar live: the parameters that were made last, None before
    """

    __slots__ = ("names", "opener", "group", "rates", "ready", "live")

    def __init__(self, names: Names, opener: Opener) -> None:
        self.names, self.opener = names, opener
        self.group, self.rates = Group(), RateFollowers()
        self.ready: Optional[ReadyQueue] = None
        self.live: Optional[LiveParameters[Any]] = None


class Lifetime(Owner, Maker):
    """Makes what a node uses, and closes it together; :class:`.Maker` says what it makes.

    What is made before the node's start is opened with it; what is made later, at once.

    :param surroundings: the node's
    """

    #: When it is made anew: then changes of parameters that are read once take effect.
    _anew = AT_START

    def __init__(self, surroundings: Surroundings) -> None:
        super().__init__(surroundings.opener)
        self._surroundings = surroundings

    @property
    def name(self) -> str:
        return self._surroundings.names.node

    @property
    def default_group(self) -> Group:
        return self._surroundings.group

    def __str__(self) -> str:
        return self.name

    def own(self, thing: Thing) -> Thing:
        """Close something with the rest; see :meth:`.Owner.own`."""
        if isinstance(thing, Callback):
            thing.attach(self._surroundings.ready)
        return super().own(thing)

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Have an executor make the calls of this node from now on, or rospy's threads.

        :param ready: the executor's queue, None for none
        """
        self._surroundings.ready = ready
        for callback in self.callbacks():
            callback.attach(ready)

    def callbacks(self) -> Iterator[Callback]:
        """Return the callbacks of this node, but not those of nodes that it hosts."""
        for thing in list(self._made):
            if isinstance(thing, Callback):
                yield thing
            elif isinstance(thing, Lifetime) and thing._surroundings is self._surroundings:
                yield from thing.callbacks()

    def publisher(
        self,
        name: str,
        data_class: type,
        latch: bool = False,
        queue_size: Optional[int] = None,
        lifespan: float = 0.0,
    ) -> Publisher:
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
        resolved, throttle = self.resolve(name), Throttle(_WARN_EVERY_S)
        judge_function(callback, resolved)

        def only_finite(message: Any) -> None:
            if is_finite(message):
                callback(message)
            elif throttle.is_due():
                text = shortened(" ".join(str(message).split()))
                rospy.logwarn("%s: %s is not finite and is ignored", resolved, text)

        depth = _depth(queue_size)
        return self._subscribe(name, data_class, only_finite if finite else callback, depth, group)

    def subscribe_batches(
        self,
        name: str,
        data_class: type,
        callback: Callable[[List[Any]], Any],
        group: Optional[Group] = None,
    ) -> Subscription:
        return self._subscribe(name, data_class, callback, MOST_KEPT, group, batches=True)

    def latest(self, name: str, data_class: type) -> Latest:
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
        resolved = self.resolve(name)
        judge_service_class(service_class, resolved)
        callback = self.own(Answering(group or self.default_group, handler, resolved))
        return self._open(Service(resolved, service_class, callback.answer))

    def client(self, name: str, service_class: type, group: Optional[Group] = None) -> Client:
        resolved = self.resolve(name)
        group = group or self.default_group
        done = Callback(group, lambda function, future: function(future), resolved)
        client = Client(resolved, service_class, done)
        self.own(done)
        return self.own(client)

    def _subscribe(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        depth: int,
        group: Optional[Group],
        batches: bool = False,
    ) -> Subscription:
        resolved = self.resolve(name)
        group = group or self.default_group
        receiving = Receiving(group, callback, resolved, batches, depth)
        subscription = Subscription(resolved, data_class, receiving.receive)
        self.own(receiving)
        return self._open(subscription)

    def resolve(self, name: str) -> str:
        judge_name(name, "name, which comes first")
        return self._surroundings.names.resolve(name)

    def every(
        self,
        rate: Rate,
        callback: Callable[[float], Any],
        catch_up: float = 0.0,
        steady: bool = False,
        group: Optional[Group] = None,
    ) -> NodeTimer:
        group = group or self.default_group
        if callable(rate):
            judge_function(rate, f"{self.name}: rate")
        what = f"{self.name}: {getattr(callback, '__qualname__', 'a timer')}"
        timer = self._timer(get_scheduler(steady), group, rate, callback, catch_up, what)
        if callable(rate):
            self._surroundings.rates.add(timer)
        return self._open(timer)

    def parameters(
        self,
        declaration: Type[Snapshot],
        on_change: Optional[Callable[[Snapshot, Snapshot], Any]] = None,
        exempt: Collection[str] = (),
        group: Optional[Group] = None,
        rules: Collection[Rule] = (),
    ) -> "LiveParameters[Snapshot]":
        self._judge_declaration(declaration)
        judge_rules(declaration.__name__, rules, declaration.declared)
        used = (*exempt, *OwnParameters.declared)
        live = LiveParameters(declaration, self.name, get_watcher(), used, self._anew, rules)
        self._surroundings.live = live
        live.add_listener(self._surroundings.rates.follow)
        if on_change is not None:
            self._open(ChangeCallback(group or self.default_group, live, on_change))
        self._serve("~describe", Trigger, description_handler(live))
        self._serve("~change", SetParameters, change_handler(live))
        if reconfigure.AVAILABLE:
            # The toolkit's own publishers: a managed node's are heard in any state.
            publisher = partial(Lifetime.publisher, self)
            self.own(reconfigure.ReconfigureInterface(live, publisher, self._serve))
        return self._open(live)

    def _judge_declaration(self, declaration: Any) -> None:
        if not (isinstance(declaration, type) and issubclass(declaration, ParameterSet)):
            must = "must be a class that derives from ParameterSet"
            raise TypeError(f"{self.name}: parameters: refused {declaration!r:.80}: {must}")
        live = self._surroundings.live
        if live is not None and not live.is_closed:
            must = "must all be declared in one class, which may derive from several"
            what = f"{declaration.__name__} beside {live.declaration.__name__}"
            raise ValueError(f"{self.name}: parameters: refused {what}: {must}")

    def _serve(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        """Offer a service in no group: a callback that takes its time holds up no user."""
        self._open(Service(self.resolve(name), service_class, handler))

    def follow(
        self, key: str, callback: Callable[[Any], Any], group: Optional[Group] = None
    ) -> None:
        group = group or self.default_group
        self._open(FollowCallback(group, self.resolve(key), get_watcher(), callback))

    def stream_log(self, per_second: int = 10) -> StreamLog:
        log = StreamLog(per_second)
        # By the machine's clock: /clock may stand still while messages come.
        self.every(1.0, log.end_second, steady=True, group=Outside())
        return log

    def before_end(self, callback: Callable[[], Any]) -> None:
        self._call_at_end(callback, "before_end")

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        self._call_at_end(callback, "before_deactivate")

    def _call_at_end(self, callback: Callable[[], Any], what: str) -> None:
        last = self.own(Callback(Outside(), callback, f"{self.name}: {what}"))
        forgetting = self.own(contextlib.ExitStack())
        forgetting.callback(at_end(Ending.NODES, last.call))

    def group(self, exclusive: bool = True, urgent: bool = False) -> Group:
        return Group(urgent) if exclusive else ReentrantGroup(urgent)

    def lifetime(self) -> "Lifetime":
        return self.own(Part(self))

    def _timer(self, scheduler: Scheduler, group: Group, *options: Any) -> NodeTimer:
        return NodeTimer(scheduler, group, *options)


class Part(Lifetime):
    """A part of what a node makes.

    :param whole: what it is closed with
    """

    def __init__(self, whole: Lifetime) -> None:
        super().__init__(whole._surroundings)
        self._whole = whole

    def close(self) -> None:
        """Close what was made through this; see :meth:`.Owner.close`."""
        super().close()
        self._whole.disown(self)


def _depth(queue_size: Optional[int]) -> int:
    """Return how many messages wait for an executor."""
    if queue_size is None:
        return DEPTH
    if queue_size == -1:
        return MOST_KEPT
    if isinstance(queue_size, int) and queue_size > 0:
        return queue_size
    allowed = "must be a whole number of at least 1, or -1 for no limit of its own"
    raise ValueError(f"queue_size: refused {queue_size!r}: {allowed}")
