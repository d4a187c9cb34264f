"""The front door: what a node's class is given, and makes everything through."""

from typing import Any, Callable, Optional

from nodekit.call_arguments import judge_function
from nodekit.node.names import Names
from nodekit.node.node_context import NodeContext
from nodekit.node.node_scope import NodeScope
from nodekit.node.opening import Opener


class Node(NodeScope):
    """A node: a name, and all that is made under it.

    A class that is a node takes one in its constructor, and makes publishers, subscriptions,
    services, timers and parameters through it. Parameters are read there; the rest is only noted,
    so no callback is called before the constructor has returned. :func:`nodekit.run` makes the node
    of a process and starts it.

    :param names: where its names are; those of this process's own node by default
    :param opener: what starts it; another node's where that hosts it
    """

    def __init__(self, names: Optional[Names] = None, opener: Optional[Opener] = None) -> None:
        super().__init__(NodeContext(names or Names.of_process(), opener or Opener()))
        self._guest: object = None
        #: The executor that makes its calls, if any; set by that.
        self.executor: Any = None

    def start(self) -> None:
        """Open all that was made, here and by nodes that this one hosts, with a few requests.

        Subscriptions come before timers.

        :raises rospy.ROSException: if a topic is used with two types
        """
        self._opener.start()

    @property
    def is_up(self) -> bool:
        """Whether it was started and is not closed."""
        return self._opener.has_started and not self._closed

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
        judge_function(cls, f"{names.node}: class")
        node = Node(names, Opener() if self._opener.has_started else self._opener)
        try:
            node._guest = cls(node)
            if node._opener is not self._opener:
                node.start()
            return self.own(node)
        except BaseException:
            node.close()
            raise
