"""Hosting of many nodes in one process, which start together."""

import resource
from collections import Counter
from typing import Collection, List, Mapping, Sequence, Tuple

import rospy

from nodekit.node.name_rules import IllegalName
from nodekit.node.ros_node import Node
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.parameter_types import ParameterError
from nodekit.process.run import NodeClass, run, selected_class
from nodekit.rospy_internals import parameter_cache

#: Base name, namespace and class of a node.
Member = Tuple[str, str, NodeClass]


def host(name: str, members: Sequence[Member]) -> None:
    """Run nodes in one process until it is shut down, as :func:`.run` does with one.

    :param name: name of the process's own node, which only hosts the others
    :param members: base name, namespace and class of each
    :raises TypeError: if the members are not a list of these
    """
    _check_members(members)
    run(name, lambda node: host_all(node, members))


def host_all(node: Node, members: Sequence[Member]) -> List[Node]:
    """Host many nodes in one; read their parameters with a few requests.

    A node whose parameters are rejected is not started, and the log has the reason.

    :param node: the hosting node
    :param members: base name, namespace and class of each
    :returns: the nodes that are up
    :raises TypeError: if the members are not a list of names, namespaces and classes
    :raises IllegalName: if ROS does not allow a member's name, or two have the same
    :raises MasterUnreachable: if the master does not respond
    """
    _check_members(members)
    _allow_many_connections()
    # Otherwise rospy sends the names of all topics, including theirs, with each log line.
    parameter_cache.cache(parameter_cache.ROSOUT_PARAMETER, True)
    up = []
    hosting = node._context.names
    names = [hosting.of_member(namespace, base).node for base, namespace, _ in members]
    for name, count in Counter(names).items():
        if count > 1:
            raise IllegalName(f"node name '{name}': {count} members use it")
    with get_watcher().reading_ahead(names) as held:
        for name, (base, namespace, cls) in zip(names, members):
            try:
                up.append(node.host(base, namespace, selected_class(cls, name, held[name])))
            except ParameterError as error:
                rospy.logerr("%s; %s is not started", error, name)
    return up


def _check_members(members: object) -> None:
    must = "must be (name, namespace, class), such as ('talker', 'robot1', Talker)"
    if not isinstance(members, Collection) or isinstance(members, (str, bytes, Mapping)):
        raise TypeError(f"host: members: refused {members!r:.80}: must be a list; each {must}")
    for member in members:
        if not isinstance(member, (tuple, list)) or len(member) != 3:
            raise TypeError(f"host: member: refused {member!r:.80}: {must}")


def _allow_many_connections() -> None:
    """Raise the limit of open files as far as allowed: each connection takes one."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
