"""A managed node of a class that knows nothing of it."""

import functools
from typing import Any, Callable

import rospy

from nodekit.managed.lifecycle_scope import CannotManage
from nodekit.managed.managed_node import ManagedNode
from nodekit.node.node import Node
from nodekit.node.node_scope import NodeScope
from nodekit.parameters.kinds import ParameterError


class ManagedAdapter(ManagedNode):
    """Makes a node's class at configure; its publishers and timers wait until the node is active.

    :param cls: the class, called with what makes things until cleanup
    :param node: the node
    """

    def __init__(self, cls: Callable[[NodeScope], object], node: Node) -> None:
        super().__init__(node)
        self._cls = cls
        self._guest: object = None
        rospy.loginfo("%s is managed: waiting to be configured", node.name)

    def on_configure(self, made: NodeScope) -> bool:
        """Make the class; it fails with a sentence where parameters are refused, or the class."""
        try:
            self._guest = self._cls(made)
            return True
        except ParameterError as refused:
            error = refused
        except CannotManage as reason:
            allowed = f"false for a class that {reason}"
            error = ParameterError("managed", True, allowed).in_namespace(self.node.name)
        rospy.logerr("%s; %s stays unconfigured", error, self.node.name)
        return False

    def on_cleanup(self) -> None:
        """Give the class up; what it has made is closed without further ado."""
        self._guest = None

    on_shutdown = on_error = on_cleanup


def managed_class(cls: Callable[[Any], object]) -> Callable[[Node], object]:
    """Return the class of a managed node for a class; for one of a managed node, that itself.

    :param cls: the class, or a function that returns its object; called with a scope, which
        refuses what only a whole node has
    """
    if isinstance(cls, type) and issubclass(cls, ManagedNode):
        return cls
    return functools.partial(ManagedAdapter, cls)
