"""The front door: what a node's class is given, and makes everything through."""

from typing import Any, Callable, Optional

from nodekit.node.names import Names
from nodekit.node.node_context import NodeContext
from nodekit.node.node_scope import NodeScope
from nodekit.node.start_queue import StartQueue
from nodekit.validation import check_function


class Node(NodeScope):
    """A node: a name, and all that is made under it.

    A class that is a node takes one in its constructor, and makes publishers, subscriptions,
    services, timers and parameters through it. Parameters are read there; the rest is only noted,
    so no callback is called before the constructor has returned. :func:`nodekit.run` makes the node
    of a process and starts it.

    :param names: where its names are; those of this process's own node by default
    :param start_queue: what starts it; another node's where that hosts it
    """

    def __init__(
        self, names: Optional[Names] = None, start_queue: Optional[StartQueue] = None
    ) -> None:
        super().__init__(NodeContext(names or Names.of_process(), start_queue or StartQueue()))
        self._guest: object = None
        #: The executor that makes its calls, if any; set by that.
        self.executor: Any = None

    def start(self) -> None:
        """Open all that was made, here and by nodes that this one hosts, with a few requests.

        Subscriptions come before timers.

        :raises rospy.ROSException: if a topic is used with two types
        """
        self._start_queue.start()

    @property
    def is_up(self) -> bool:
        """Whether it was started and is not closed."""
        return self._start_queue.has_started and not self._closed

    def host(self, name: str, namespace: str, cls: Callable[["Node"], object]) -> "Node":
        """Have another node in this process.

        It looks like a node of its own: its topics stand in its namespace, its private names in
        ``namespace/name``. It starts with this one or, if that has been, at once.

        :param name: base name
        :param namespace: its namespace; a relative one is in that of the process
        :param cls: its class, called with the node
        :returns: the node, which is closed with this one
        :raises TypeError: if a name is no text, or the class cannot be called
        :raises ParameterError: if one of its parameters is refused
        :raises Exception: what its class or its start raises; nothing of it stays then either
        """
        names = Names.hosted(namespace, name)
        check_function(cls, f"{names.node}: class")
        node = Node(names, StartQueue() if self._start_queue.has_started else self._start_queue)
        try:
            node._guest = cls(node)
            if node._start_queue is not self._start_queue:
                node.start()
            return self.own(node)
        except BaseException:
            node.close()
            raise
