"""Where the names of a node are, so that one process can host many nodes."""

from typing import NamedTuple


class NodeScope(NamedTuple):
    """Turns the names that a node's class uses into names for rospy.

    A node in a process of its own leaves both parts to rospy, which resolves
    relative and private names. A hosted one gives the names it would have had.

    :param group: prefix of topic names; ends with a slash unless empty
    :param private: prefix of private names: ``~``, or the node's name and a slash
    """

    group: str = ""
    private_prefix: str = "~"

    @classmethod
    def hosted(cls, group: str, node: str) -> "NodeScope":
        """Return the scope of a node that another process hosts.

        :param group: global namespace of the node
        :param node: base name of the node
        """
        return cls(group.rstrip("/") + "/", "%s/%s/" % (group.rstrip("/"), node))

    def topic(self, name: str) -> str:
        """Return the name of a topic of the node."""
        return self.group + name

    def private(self, name: str) -> str:
        """Return the name of a private topic or service of the node."""
        return self.private_prefix + name

    @property
    def parameters(self) -> str:
        """The namespace of the node's private parameters."""
        return self.private_prefix.rstrip("/")
