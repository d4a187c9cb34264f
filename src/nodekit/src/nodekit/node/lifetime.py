"""What a node makes, and how long it lives."""

import contextlib
from functools import partial
from typing import Any, Callable, Collection, Optional, Type

from std_srvs.srv import Trigger

from nodekit.groups.groups import Group, Outside, ReentrantGroup
from nodekit.messaging.service import Service
from nodekit.messaging.stream_log import StreamLog
from nodekit.node.callbacks import Callback
from nodekit.node.telling import Change, Followed
from nodekit.node.timers import NodeTimer, Rate
from nodekit.node.topics import TopicMaker
from nodekit.parameter_server import reconfigure
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.services import change_handler, description_handler
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.declaration import ParameterSet, Snapshot
from nodekit.parameters.kinds import BoolParameter
from nodekit.parameters.schema import AT_START
from nodekit.rospy_internals.shutdown import before_shutdown
from nodekit.timing.scheduler import Scheduler, get_scheduler
from nodekit_msgs.srv import SetParameters


class OwnParameters(ParameterSet):
    """Private parameters of every node; read once, before its class is made."""

    managed = BoolParameter(False, help="wait until others configure and activate the node")


class Lifetime(TopicMaker):
    """Makes all that a node uses, and closes it together.

    What is made before the node's start is opened with it; what is made later, at once.
    """

    #: When it is made anew: then changes of parameters that are read once take effect.
    _anew = AT_START

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
        group = group or self._surroundings.group
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
    ) -> "LiveParameters[Snapshot]":
        """Read and judge the node's private parameters now, and follow them from the start on.

        :param declaration: the class that declares them
        :param on_change: called with the new and the old values after a change
        :param exempt: names beside them that are used but not declared
        :param group: the callback's group; the node's own by default
        :returns: an object whose ``values`` are those in force
        :raises ParameterError: if a value on the server is not allowed
        """
        used = (*exempt, *OwnParameters.declared)
        live = LiveParameters(declaration, self.name, get_watcher(), used, self._anew)
        live.add_listener(self._surroundings.rates.follow)
        if on_change is not None:
            self._open(Change(group or self._surroundings.group, live, on_change))
        self._serve("~describe", Trigger, description_handler(live))
        self._serve("~change", SetParameters, change_handler(live))
        if reconfigure.AVAILABLE:
            # The toolkit's own publishers: a managed node's are heard in any state.
            publisher = partial(TopicMaker.publisher, self)
            self.own(reconfigure.ReconfigureInterface(live, publisher, self._serve))
        return self._open(live)

    def _serve(self, name: str, service_class: type, handler: Callable[[Any], Any]) -> None:
        """Offer a service in no group: a callback that takes its time holds up no user."""
        self._open(Service(self.resolve(name), service_class, handler))

    def follow(
        self, key: str, callback: Callable[[Any], Any], group: Optional[Group] = None
    ) -> None:
        """Follow a parameter that is not declared, or not this node's.

        :param key: name of the parameter
        :param callback: called with its value, None where it is not set: once at the start and
            after each change
        :param group: the callback's group; the node's own by default
        """
        group = group or self._surroundings.group
        self._open(Followed(group, self.resolve(key), get_watcher(), callback))

    def stream_log(self, per_second: int = 10) -> StreamLog:
        """Log lines at info, of a quick stream a part.

        :param per_second: how many lines a second are logged, 1/s
        """
        log = StreamLog(per_second)
        # By the machine's clock: /clock may stand still while messages come.
        self.every(1.0, log.end_second, steady=True, group=Outside())
        return log

    def before_end(self, callback: Callable[[], Any]) -> None:
        """Have a function called when the process is told to end, while all of it still works.

        :param callback: what to call, in no group; it has less than 2 s
        """
        last = self.own(Callback(Outside(), callback, f"{self.name}: before_end"))
        forgetting = self.own(contextlib.ExitStack())
        forgetting.callback(before_shutdown(last.call))

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        """Have a function called whenever the node stops being active, while it still publishes.

        Only a managed node ever does, on its way through shutdown too; of any other it is not
        called.

        :param callback: what to call, in the node's default group
        """

    def group(self, exclusive: bool = True, urgent: bool = False) -> Group:
        """Make a callback group.

        :param exclusive: whether its callbacks exclude each other
        :param urgent: whether an executor makes its calls before those of all other groups
        """
        return Group(urgent) if exclusive else ReentrantGroup(urgent)

    def lifetime(self) -> "Lifetime":
        """Return a maker of its own, whose ``close`` ends only what was made through it."""
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
