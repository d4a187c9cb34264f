"""Copy of parameters from the course's names, such as ``/system_param_K``, to private ones."""

from typing import Type

import rospy

from nodekit import NodeScope, ParameterSet
from nodekit.master import MISSING, MasterClient


def adopt_course_names(node: NodeScope, declaration: Type[ParameterSet]) -> None:
    """Copy values from the course's names to private parameters that are unset.

    The course loads its YAML file at the root: ``/system_param_K`` is
    ``/system/system_param_K`` for the node ``/system``. In a namespace both names are in it. A log
    line lists the copied values, which are validated like any other; a warning lists values that
    were ignored because the private parameter is set, as after an earlier run on the same master.

    :param node: owner of the parameters
    :param declaration: the declared parameters
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
        rospy.loginfo("%s: parameters copied from the course's names: %s", node.name, text)
    for private, course in places.values():
        if MISSING not in (held[private], held[course]) and held[private] != held[course]:
            rospy.logwarn(
                "%s: %s is ignored, because %s: %s is set; to use it at the next start: "
                "rosparam delete %s",
                *(course, held[course], private, held[private], private),
            )
