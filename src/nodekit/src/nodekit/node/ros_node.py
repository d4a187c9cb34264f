"""Node: NodeScope of a whole node; starts it, and hosts other nodes in the same process."""

from typing import Any, Callable, Optional

from nodekit.argument_checks import check_function
from nodekit.node.names import Names
from nodekit.node.node_context import NodeContext
from nodekit.node.node_scope import NodeScope
from nodekit.node.start_queue import StartQueue


class Node(NodeScope):
    """A node, through which its class creates publishers, subscriptions, services and timers.

    The class receives it in its constructor. Parameters are read there; the rest is opened at the
    start, so no callback is called before the constructor has returned. :func:`nodekit.run` creates
    the node of a process and starts it.

    :param names: resolves its names; those of this process's own node by default
    :param start_queue: opens its resources; the hosting node's for a hosted one
    """

    def __init__(
        self, names: Optional[Names] = None, start_queue: Optional[StartQueue] = None
    ) -> None:
        super().__init__(NodeContext(names or Names.of_process(), start_queue or StartQueue()))
        self._guest: object = None
        #: The executor that makes its calls, set by :meth:`add_node`; None without one.
        self.executor: Any = None

    def start(self) -> None:
        """Open all resources of this node and of hosted ones, with a few requests.

        Subscriptions are opened before timers.

        :raises rospy.ROSException: if a topic is used with two types
        """
        self._start_queue.start()

    @property
    def is_up(self) -> bool:
        """Whether the node is started and not closed."""
        return self._start_queue.has_started and not self._closed

    def host(self, name: str, namespace: str, cls: Callable[["Node"], object]) -> "Node":
        """Create another node in this process.

        Its topics are in its namespace, its private names in ``namespace/name``. It starts with
        this node, or immediately if this one has started.

        :param name: base name
        :param namespace: its namespace; relative to that of this node
        :param cls: its class, called with the node
        :returns: the node, which this one owns
        :raises TypeError: if a name is not text, or the class not callable
        :raises ParameterError: if one of its parameters is rejected
        :raises Exception: from its class or its start; the node is closed then
        """
        names = self._context.names.of_member(namespace, name)
        check_function(cls, f"{names.node}: class", 1)
        node = Node(names, StartQueue() if self._start_queue.has_started else self._start_queue)
        try:
            node._guest = cls(node)
            if node._start_queue is not self._start_queue:
                node.start()
            return self.own(node)
        except BaseException:
            node.close()
            raise
