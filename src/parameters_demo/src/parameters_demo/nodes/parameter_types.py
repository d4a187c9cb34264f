"""Parameters of every type, and a dictionary."""

from typing import Any

import rospy

from nodekit import (
    BoolParameter,
    BytesParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    Node,
    ParameterSet,
    StringParameter,
    run,
)


class ParameterTypesParameters(ParameterSet):
    """Parameters of parameter_types."""

    flag = BoolParameter(True, help="a boolean")
    count = IntParameter(42, help="an integer")
    ratio = FloatParameter(0.5, help="a number")
    title = StringParameter("robot", help="a string")
    flags = ListParameter([True, False], element=BoolParameter(False, help=""), help="booleans")
    counts = ListParameter([1, 2, 3], element=IntParameter(0, help=""), help="integers")
    ratios = ListParameter([0.5, 1.5], element=FloatParameter(0.0, help=""), help="numbers")
    titles = ListParameter(["a", "b"], element=StringParameter("", help=""), help="strings")
    blob = BytesParameter(b"\x00\x7f\xff", help="bytes")


class ParameterTypes:
    """Logs each change of its parameters, and of a dictionary with arbitrary keys.

    On the parameter server, a dictionary is a namespace. If its keys are known, they are ordinary
    parameters; if not, the dictionary is observed as a whole.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ParameterTypesParameters`
        - ``~limits`` (a dictionary): read at run time, never written
    """

    def __init__(self, node: Node) -> None:
        node.declare_parameters(
            ParameterTypesParameters, on_change=self._on_change, exempt=["limits"]
        )
        node.on_parameter("~limits", self._on_limits)

    def _on_change(self, new: ParameterTypesParameters, old: ParameterTypesParameters) -> None:
        before = old.as_dict()
        for name, value in new.as_dict().items():
            if value != before[name]:
                rospy.loginfo("Parameter changed: %s = %r", name, value)

    def _on_limits(self, limits: Any) -> None:
        if isinstance(limits, dict):
            shown = ", ".join(f"{key} up to {value}" for key, value in sorted(limits.items()))
            rospy.loginfo("Limits: %s", shown)


def main() -> None:
    """Run the node until it is shut down."""
    run("parameter_types", ParameterTypes)
