"""Resolution of a node's names, so that one process can host many nodes."""

from typing import NamedTuple

import rospy

from nodekit.argument_checks import check_name
from nodekit.node.name_rules import checked


class Names(NamedTuple):
    """Resolver of the names that a node's class uses.

    :param node: global name of the node
    :param is_hosted: whether it is hosted; otherwise it is the process's own node, and rospy
        resolves its names
    """

    node: str
    is_hosted: bool

    @classmethod
    def of_process(cls) -> "Names":
        """Return the names of this process's own node, which must be initialised."""
        return cls(rospy.get_name(), False)

    @classmethod
    def hosted(cls, namespace: str, name: str) -> "Names":
        """Return the names of a hosted node.

        :param namespace: namespace of the node; relative to that of the process
        :param name: base name of the node
        :raises TypeError: if one of them is not text
        :raises IllegalName: if ROS does not allow that name
        """
        check_name(namespace, "namespace")
        check_name(name, "node name")
        node = f"{rospy.resolve_name(namespace).rstrip('/')}/{name}"
        return cls(checked(node, "node name"), True)

    def of_member(self, namespace: str, name: str) -> "Names":
        """Return the names of a node that this one hosts.

        :param namespace: namespace of the member; relative to that of this node
        :param name: base name of the member
        :raises TypeError: if one of them is not text
        :raises IllegalName: if ROS does not allow that name
        """
        check_name(namespace, "namespace")
        if self.is_hosted and not namespace.startswith(("/", "~")):
            namespace = f"{self.node.rpartition('/')[0]}/{namespace}"
        return Names.hosted(namespace, name)

    def resolve(self, name: str) -> str:
        """Return the global name of a topic, a service or a parameter.

        :param name: relative, global, or private (``~name``)
        :raises IllegalName: if ROS does not allow that name, before or after remapping
        """
        if self.is_hosted and not name.startswith("/"):
            private = name.startswith("~")
            namespace = self.node if private else self.node.rpartition("/")[0]
            name = f"{namespace}/{name[1:] if private else name}"
        return checked(str(rospy.resolve_name(name)))
