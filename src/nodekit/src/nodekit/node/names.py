"""Where the names of a node are, so that one process can host many nodes."""

from typing import NamedTuple

import rospy

from nodekit.node.name_rules import judged
from nodekit.validation import check_name


class Names(NamedTuple):
    """Turns the names that a node's class uses into global ones.

    :param node: global name of the node
    :param is_hosted: whether another node's process hosts it; otherwise it is the process's own,
        whose names rospy resolves
    """

    node: str
    is_hosted: bool

    @classmethod
    def of_process(cls) -> "Names":
        """Return the names of this process's own node; it must have been initialised."""
        return cls(rospy.get_name(), False)

    @classmethod
    def hosted(cls, namespace: str, name: str) -> "Names":
        """Return the names of a node that another one hosts.

        :param namespace: namespace of the node; a relative one is in that of the process
        :param name: base name of the node
        :raises TypeError: if one of them is no text
        :raises IllegalName: if ROS does not allow that name
        """
        check_name(namespace, "namespace")
        check_name(name, "node name")
        node = f"{rospy.resolve_name(namespace).rstrip('/')}/{name}"
        return cls(judged(node, "node name"), True)

    def resolve(self, name: str) -> str:
        """Return the global name of a topic, a service or a parameter.

        :param name: relative, global, or private (``~name``)
        :raises IllegalName: if ROS does not allow that name, as it is or as it was remapped
        """
        if self.is_hosted and not name.startswith("/"):
            private = name.startswith("~")
            namespace = self.node if private else self.node.rpartition("/")[0]
            name = f"{namespace}/{name[1:] if private else name}"
        return judged(str(rospy.resolve_name(name)))
