"""LifecycleScope: the NodeScope that on_configure or on_activate of a managed node receives."""

from typing import Any, Callable, Optional

from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.managed.activation_gate import (
    ActivationGate,
    DeactivateHook,
    ManagedPublisher,
    ManagedTimer,
)
from nodekit.messaging.publisher import Publisher
from nodekit.node.node_scope import NodeScope
from nodekit.node.start_queue import StartQueue
from nodekit.node.timers import NodeTimer
from nodekit.timing.scheduler import Scheduler

#: Attributes of a Node that a scope lacks, with the reason for the error.
_ONLY_OF_NODE = {"host": "hosts another node", "executor": "has its own executor"}


class CannotManage(AttributeError):
    """Error of a class that cannot be managed; the text has the reason."""


class LifecycleScope(NodeScope):
    """A scope whose resources are opened together once the callback that creates them succeeds.

    Its publishers publish and its timers tick only while the node is active.

    :param parent: the scope that this one is closed with
    :param gate: holds whether the node is active
    :param created_at: label of the transition that creates it
    :param start_queue: opens what is created; a new one by default
    """

    def __init__(
        self,
        parent: NodeScope,
        gate: ActivationGate,
        created_at: str,
        start_queue: Optional[StartQueue] = None,
    ) -> None:
        super().__init__(parent._context, parent)
        self._created_at = created_at
        self._rereads_at = f"at the next {created_at}"
        self._start_queue = start_queue or StartQueue()
        self._gate = gate

    def open(self) -> None:
        """Open all created resources; later ones are opened immediately.

        :raises rospy.ROSException: if a topic is used with two types
        """
        self._start_queue.start()

    def create_scope(self) -> NodeScope:
        """Return another scope of the same transition; see :meth:`.NodeScope.create_scope`."""
        return self.own(LifecycleScope(self, self._gate, self._created_at, self._start_queue))

    def before_deactivate(self, callback: Callable[[], Any]) -> None:
        """Call a function before each deactivation; see :meth:`.NodeScope.before_deactivate`."""
        self.own(DeactivateHook(self._gate, callback, f"{self.name}: before_deactivate"))

    def __getattr__(self, name: str) -> Any:
        if name in _ONLY_OF_NODE:
            raise CannotManage(_ONLY_OF_NODE[name])
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def _is_active(self) -> bool:
        return self._gate.ticks

    def _new_publisher(self, name: str, data_class: type, *options: Any) -> Publisher:
        return ManagedPublisher(self._gate, name, data_class, *options)

    def _new_timer(self, scheduler: Scheduler, group: CallbackGroup, *options: Any) -> NodeTimer:
        if isinstance(group, NoGroup):  # an internal timer of nodekit
            return super()._new_timer(scheduler, group, *options)
        return ManagedTimer(self._gate, scheduler, group, *options)
