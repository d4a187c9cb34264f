"""Adapter that turns any node class into a managed node, which creates its object at configure."""

import functools
from typing import Any, Callable

import rospy

from nodekit.managed.lifecycle_scope import CannotManage
from nodekit.managed.managed_node import ManagedNode
from nodekit.node.ros_node import Node
from nodekit.node.node_scope import NodeScope
from nodekit.parameters.parameter_types import ParameterError


class ManagedAdapter(ManagedNode):
    """Managed node that creates an object of another class at configure.

    Publishers and timers of that object wait until the node is active.

    :param cls: the class, called with a scope that is closed at cleanup
    :param node: the node
    """

    def __init__(self, cls: Callable[[NodeScope], object], node: Node) -> None:
        super().__init__(node)
        self._cls = cls
        self._guest: object = None
        rospy.loginfo("%s is managed: waiting to be configured", node.name)

    def on_configure(self, scope: NodeScope) -> bool:
        """Create the object; fail with one log line if its parameters or class are rejected."""
        try:
            self._guest = self._cls(scope)
            return True
        except ParameterError as rejected:
            error = rejected
        except CannotManage as reason:
            allowed = f"false for a class that {reason}"
            error = ParameterError("managed", True, allowed).in_namespace(self.node.name)
        rospy.logerr("%s; %s stays unconfigured", error, self.node.name)
        return False

    def on_cleanup(self) -> None:
        """Drop the object; its resources are closed in any case."""
        self._guest = None

    on_shutdown = on_error = on_cleanup


def managed_class(cls: Callable[[Any], object]) -> Callable[[Node], object]:
    """Return a managed node's class for a class; a managed node's class itself.

    :param cls: the class, or a function that returns its object; called with a scope, which
        rejects the attributes that only a Node has
    """
    if isinstance(cls, type) and issubclass(cls, ManagedNode):
        return cls
    return functools.partial(ManagedAdapter, cls)
