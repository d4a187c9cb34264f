"""NodeScope: creates the publishers, subscriptions, services and timers of a node."""

import contextlib
from typing import Any, Callable, Collection, Iterator, List, Optional, Type

from std_srvs.srv import Trigger

from nodekit.argument_checks import check_function, check_name, check_service_class
from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.messaging.publisher import Publisher
from nodekit.messaging.rate_limited_log import RateLimitedLog
from nodekit.messaging.service import Service
from nodekit.messaging.subscription import LatestMessage, Subscription
from nodekit.node.action_methods import ActionMethods
from nodekit.node.callbacks import (
    Callback,
    ServiceCallback,
    SubscriptionCallback,
    check_queue_size,
    finite_only,
)
from nodekit.node.clients import Client
from nodekit.node.node_context import NodeContext
from nodekit.node.old_methods import OldMethods
from nodekit.node.parameter_callbacks import ChangeCallback, ParameterCallback
from nodekit.node.resource_owner import ResourceOwner, Thing
from nodekit.node.timers import NodeTimer, Rate
from nodekit.parameter_server import reconfigure
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.parameter_services import change_handler, description_handler
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.declaration import OwnParameters, ParameterSet, Rule, Snapshot
from nodekit.parameters.declaration_checks import check_rules
from nodekit.parameters.schema import AT_START
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.timing.scheduler import Scheduler, get_scheduler
from nodekit_msgs.srv import SetParameters


class NodeScope(ActionMethods, OldMethods, ResourceOwner):
    """Factory and owner of a node's publishers, subscriptions, services and timers.

    A :class:`.Node` is a scope; :meth:`create_scope` returns one, and callbacks of a managed node
    receive one. A class that needs only a NodeScope can be run, hosted and managed; a class that
    hosts other nodes or has an executor needs a Node.

    Resources created before the node's start are opened with it, later ones immediately. Names are
    relative, private (``~name``) or global. Callbacks run in the node's default group, one at a
    time, unless another ``group`` is given. An argument of the wrong type raises a TypeError: a
    callback that is not a function or is ``async def``, a class that is not a message or service
    class.

    :param context: the node's
    :param parent: the scope that this one is closed with, None for a node
    """

    #: When changes of parameters that are read once take effect.
    _rereads_at = AT_START

    def __init__(self, context: NodeContext, parent: "Optional[NodeScope]" = None) -> None:
        super().__init__(context.start_queue)
        self._context = context
        self._parent = parent

    @property
    def name(self) -> str:
        """Global name of the node."""
        return self._context.names.node

    @property
    def default_group(self) -> CallbackGroup:
        """The group of callbacks that are created without one."""
        return self._context.group

    def __str__(self) -> str:
        return self.name

    def resolve(self, name: str) -> str:
        """Return a global name.

        :param name: relative, private (``~name``) or global
        :raises IllegalName: if ROS does not allow that name, before or after remapping
        """
        check_name(name, "name, which comes first")
        return self._context.names.resolve(name)

    def create_publisher(
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
        :param queue_size: how many messages are held for a subscriber that does not read, the
            newest; 0 or -1 for no limit. By default, such a subscriber delays one call
            by up to 50 ms, then gets the newest only
        :param lifespan: how long later subscribers get the last message of a topic that is not
            latched [s]; do not change that message after publishing it
        """
        resolved = self.resolve(name)
        return self._open(self._new_publisher(resolved, data_class, latch, lifespan, queue_size))

    def create_subscription(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        queue_size: Optional[int] = None,
        finite: bool = False,
        group: Optional[CallbackGroup] = None,
        views: bool = False,
    ) -> Subscription:
        """Subscribe to a topic.

        :param name: topic
        :param data_class: message class
        :param callback: called with each message
        :param queue_size: how many messages wait while the callback is busy, the newest ones; -1
            is rospy's "no limit". By default, :data:`.DEPTH` wait for an executor, and without
            one, all wait at the sender
        :param finite: ignore, with a warning, messages with NaN or infinity in a field
        :param group: the callback's group; the node's default group by default
        :param views: whether fields of type ``uint8[]`` and ``char[]`` are read-only memoryviews,
            of shared memory if the publisher uses it: large messages are not copied. Keep at most
            one or two such messages: their publisher's memory is limited
        :raises ValueError: if the queue size is neither positive nor -1
        """
        check_function(callback, self.resolve(name), 1)
        check_queue_size(queue_size)
        function = finite_only(callback, self.resolve(name)) if finite else callback
        return self._subscribe(name, data_class, function, queue_size, group, views=views)

    def create_batch_subscription(
        self,
        name: str,
        data_class: type,
        callback: Callable[[List[Any]], Any],
        group: Optional[CallbackGroup] = None,
    ) -> Subscription:
        """Subscribe to a topic, with one call for all messages that have arrived.

        :param name: topic
        :param data_class: message class
        :param callback: called with a list of messages, oldest first
        :param group: the callback's group; the node's default group by default
        """
        return self._subscribe(name, data_class, callback, -1, group, batches=True)

    def _subscribe(
        self,
        name: str,
        data_class: type,
        callback: Callable[[Any], Any],
        queue_size: Optional[int],
        group: Optional[CallbackGroup],
        batches: bool = False,
        views: bool = False,
    ) -> Subscription:
        resolved = self.resolve(name)
        group = group or self.default_group
        handler = SubscriptionCallback(group, callback, resolved, batches, queue_size)
        subscription = Subscription(
            resolved, data_class, handler.receive, handler.newest_only, views
        )
        self.own(handler)
        return self._open(subscription)

    def create_latest_message(self, name: str, data_class: type) -> LatestMessage:
        """Keep the latest message of a topic.

        :param name: topic
        :param data_class: message class
        :returns: an object with ``message``, None before the first, and its ``age`` [s]
        """
        latest = LatestMessage(self.resolve(name), data_class)
        self._open(latest.subscription)
        return latest

    def create_service(
        self,
        name: str,
        service_class: type,
        handler: Callable[[Any], Any],
        group: Optional[CallbackGroup] = None,
    ) -> Service:
        """Offer a service.

        :param name: name of the service
        :param service_class: service class
        :param handler: returns the response to a request
        :param group: the handler's group; the node's default group by default
        """
        resolved = self.resolve(name)
        check_service_class(service_class, resolved)
        callback = self.own(ServiceCallback(group or self.default_group, handler, resolved))
        return self._open(Service(resolved, service_class, callback.respond))

    def create_client(
        self, name: str, service_class: type, group: Optional[CallbackGroup] = None
    ) -> Client:
        """Return a client of a service.

        :param name: name of the service
        :param service_class: service class
        :param group: the group of done callbacks; the node's default group by default
        """
        resolved = self.resolve(name)
        group = group or self.default_group
        done = Callback(group, lambda function, future: function(future), resolved)
        client = Client(resolved, service_class, done)
        self.own(done)
        return self.own(client)

    def create_timer(
        self,
        rate_hz: Rate,
        callback: Callable[[float], Any],
        catch_up: float = 0.0,
        steady: bool = False,
        group: Optional[CallbackGroup] = None,
    ) -> NodeTimer:
        """Call a function at a fixed rate without drift, the first time immediately.

        :param rate_hz: calls per second; 0 pauses. A function is called for the rate at the
            start and after each change of this node's parameters
        :param callback: called with the time since the first call [s]; must be short
        :param catch_up: lateness up to which missed calls are made up for [s]; not used with a
            simulated clock
        :param steady: use the monotonic clock even if /use_sim_time is set
        :param group: the callback's group; the node's default group by default
        :raises ValueError: if a timer cannot keep the rate
        """
        group = group or self.default_group
        if callable(rate_hz):
            check_function(rate_hz, f"{self.name}: rate", 0)
        what = f"{self.name}: {getattr(callback, '__qualname__', 'a timer')}"
        timer = self._new_timer(get_scheduler(steady), group, rate_hz, callback, catch_up, what)
        if callable(rate_hz):
            self._context.rates.add(timer)
        return self._open(timer)

    def declare_parameters(
        self,
        declaration: Type[Snapshot],
        on_change: Optional[Callable[[Snapshot, Snapshot], Any]] = None,
        exempt: Collection[str] = (),
        group: Optional[CallbackGroup] = None,
        rules: Collection[Rule] = (),
    ) -> "LiveParameters[Snapshot]":
        """Read and validate the node's private parameters now, and follow them after the start.

        :param declaration: the class that declares the parameters
        :param on_change: called with the new and the old values after a change; must be short
            without an executor, since changes of all other nodes in the process wait for it
        :param exempt: further names that are used; with ``*`` all but probable misspellings
        :param group: the callback's group; the node's default group by default
        :param rules: methods of the node's class, marked by :func:`nodekit.rule`, that validate
            the values besides the declaration's rules, at the start and at each change
        :returns: an object whose ``values`` are the current ones
        :raises ValueError: if this node has declared parameters already
        :raises ParameterError: if a value on the server is not allowed
        """
        self._check_declaration(declaration)
        check_rules(declaration.__name__, rules, declaration.declared)
        used = (*exempt, *OwnParameters.declared)
        live = LiveParameters(declaration, self.name, get_watcher(), used, self._rereads_at, rules)
        self._context.live = live
        live.add_listener(self._context.rates.update)
        if on_change is not None:
            self._open(ChangeCallback(group or self.default_group, live, on_change))
        self._serve("~describe", Trigger, description_handler(live))
        self._serve("~change", SetParameters, change_handler(live))
        if reconfigure.AVAILABLE:
            self.own(reconfigure.ReconfigureInterface(live, self._publish, self._serve))
        return self._open(live)

    def _check_declaration(self, declaration: Any) -> None:
        if not (isinstance(declaration, type) and issubclass(declaration, ParameterSet)):
            must = "must be a class that derives from ParameterSet"
            raise TypeError(f"{self.name}: parameters: refused {declaration!r:.80}: {must}")
        live = self._context.live
        if live is not None and not live.is_closed:
            must = "must all be declared in one class, which may derive from several"
            what = f"{declaration.__name__} beside {live.declaration.__name__}"
            raise ValueError(f"{self.name}: parameters: refused {what}: {must}")

    def _publish(
        self, name: str, data_class: type, latch: bool = False, queue_size: Optional[int] = None
    ) -> Publisher:
        """Publish an internal topic of nodekit, in any state of a managed node."""
        name = self.resolve(name)
        return self._open(Publisher(name, data_class, latch, queue_size=queue_size))

    def _serve(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        """Offer an internal service of nodekit, in no group: it never waits for a callback."""
        self._open(Service(self.resolve(name), service_class, handler))

    def on_parameter(
        self, key: str, callback: Callable[[Any], Any], group: Optional[CallbackGroup] = None
    ) -> None:
        """Follow a parameter that is not declared, or belongs to another node.

        :param key: name of the parameter
        :param callback: called with its value, None if it is not set, at the start and after each
            change; must be short without an executor, as for :meth:`declare_parameters`
        :param group: the callback's group; the node's default group by default
        """
        group = group or self.default_group
        self._open(ParameterCallback(group, self.resolve(key), get_watcher(), callback))

    def create_rate_limited_log(self, per_second: int = 10) -> RateLimitedLog:
        """Return a rate-limited logger, which logs at info level.

        :param per_second: how many lines are logged per second [1/s]
        """
        log = RateLimitedLog(per_second)
        # By the monotonic clock: /clock may stand still while messages arrive.
        self.create_timer(1.0, log.end_second, steady=True, group=NoGroup())
        return log

    def create_scope(self) -> "NodeScope":
        """Return another scope of the node, which can be closed separately."""
        return self.own(NodeScope(self._context, self))

    def own(self, thing: Thing) -> Thing:
        """Own an object: close it together with this scope's resources.

        :param thing: anything with a method ``close``
        :returns: the object
        :raises Closed: if the scope is closed
        """
        if isinstance(thing, Callback):
            thing.attach(self._context.ready)
        return super().own(thing)

    def close(self) -> None:
        """Close this scope's resources, the latest first; see :meth:`.ResourceOwner.close`."""
        super().close()
        if self._parent is not None:
            self._parent.disown(self)

    def on_shutdown(self, callback: Callable[[], Any]) -> None:
        """Call a function when the process has to end, while everything still works.

        These functions are called first, in reverse order of registration. Then managed nodes go
        through shutdown, calls of services are cancelled, and executors and timers stop.

        :param callback: the function, called in no group; it has less than 2 s
        """
        self._call_at_end(callback, "on_shutdown")

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        """Call a function whenever the node stops being active, while it still publishes.

        A managed node calls it on its way through shutdown too. Any other node is active until the
        process has to end: the function is then called as by :meth:`on_shutdown`.

        :param callback: the function; a managed node calls it in its default group
        """
        self._call_at_end(callback, "before_deactivate")

    def _call_at_end(self, callback: Callable[[], Any], what: str) -> None:
        check_function(callback, f"{self.name}: {what}", 0)
        hook = self.own(Callback(NoGroup(), callback, f"{self.name}: {what}"))
        unregistration = self.own(contextlib.ExitStack())
        unregistration.callback(at_end(ShutdownPhase.NODES, hook.call))

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Let an executor make the calls of this node from now on, or rospy's threads.

        :param ready: the executor's queue, None for rospy's threads
        """
        self._context.ready = ready
        for callback in self.callbacks():
            callback.attach(ready)

    def callbacks(self) -> Iterator[Callback]:
        """Return the callbacks of this node, without those of hosted nodes."""
        for thing in list(self._owned):
            if isinstance(thing, Callback):
                yield thing
            elif isinstance(thing, NodeScope) and thing._context is self._context:
                yield from thing.callbacks()

    def _new_publisher(self, name: str, data_class: type, *options: Any) -> Publisher:
        return Publisher(name, data_class, *options)

    def _new_timer(self, scheduler: Scheduler, group: CallbackGroup, *options: Any) -> NodeTimer:
        return NodeTimer(scheduler, group, *options)


#: Another name of :class:`NodeScope`, from nodekit 1.0.
Maker = NodeScope
