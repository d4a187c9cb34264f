"""Where the names of a node are, so that one process can host many nodes."""

from typing import NamedTuple

import rospy


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
        """
        return cls("%s/%s" % (rospy.resolve_name(namespace).rstrip("/"), name), True)

    def resolve(self, name: str) -> str:
        """Return the global name of a topic, a service or a parameter.

        :param name: relative, global, or private (``~name``)
        """
        if not self.is_hosted or name.startswith("/"):
            return str(rospy.resolve_name(name))
        if name.startswith("~"):
            return str(rospy.resolve_name("%s/%s" % (self.node, name[1:])))
        return str(rospy.resolve_name("%s/%s" % (self.node.rpartition("/")[0], name)))
