"""The course's place for a motor's parameters: beside the node, not below its name."""

from typing import Type

import rospy

from nodekit import NodeScope, ParameterSet
from nodekit.master import MISSING, MasterClient


def adopt_course_names(node: NodeScope, declaration: Type[ParameterSet]) -> None:
    """Set each private parameter that is not set, but its course's name is, to that one's value.

    The course loads its YAML file at the root: ``/system_param_K`` is what the node ``/system`` has
    as ``/system/system_param_K``. In a namespace both stand in it. A line of the log says which
    values were taken; they are judged as any other. A warning says which were not, as where the
    node has run before on the same master.

    :param node: whose parameters they are
    :param declaration: declares them
    :raises MasterUnreachable: if the master does not answer
    """
    places = {name: (f"{node.name}/{name}", node.resolve(name)) for name in declaration.declared}
    with MasterClient(node.name) as master:
        held = master.read([key for place in places.values() for key in place]).values
        found = {
            name: held[course]
            for name, (private, course) in places.items()
            if held[private] is MISSING and held[course] is not MISSING
        }
        master.write({places[name][0]: value for name, value in found.items()})
    if found:
        text = ", ".join(f"{places[name][1]}: {value}" for name, value in found.items())
        rospy.loginfo("%s takes the course's names: %s", node.name, text)
    for private, course in places.values():
        if MISSING not in (held[private], held[course]) and held[private] != held[course]:
            rospy.logwarn(
                "%s: %s is not read, as %s: %s is set; to have it read at the next start: "
                "rosparam delete %s",
                *(course, held[course], private, held[private], private),
            )
