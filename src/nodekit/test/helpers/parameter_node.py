#!/usr/bin/env python3
"""Node with a parameter of every type; prints its values and executes lines of JSON on stdin."""

import json
import sys
import threading
from typing import Any, Dict

import rospy

from nodekit import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    MasterUnreachable,
    Node,
    ParameterError,
    ParameterSet,
    StringParameter,
    rule,
    run,
)
from nodekit.parameters import reconciler
from nodekit.parameters.parameter_types import to_wire


class GaugeParameters(ParameterSet):
    """A parameter of every type, and a rule about two of them."""

    level = FloatParameter(1.0, minimum=0.0, maximum=1e10, unit="V", help="a level")
    count = IntParameter(3, minimum=0, help="a count")
    on = BoolParameter(False, help="a switch")
    title = StringParameter("gauge", help="a title")
    shape = EnumParameter("round", choices=("round", "flat"), help="a shape")
    marks = ListParameter([1.0, 2.0], element=FloatParameter(0.0, help=""), help="marks")
    low = FloatParameter(0.0, help="lower limit")
    high = FloatParameter(10.0, help="upper limit")

    @rule("low", "high")
    def ordered(self) -> None:
        """Keep the limits in order."""
        if self.low > self.high:
            raise ValueError("low <= high")


class Gauge:
    """Prints ``{"changes": n, "values": {…}}`` at the start and with each change."""

    def __init__(self, node: Node) -> None:
        self._changes = 0
        self._broken = False
        self._parameters = node.declare_parameters(GaugeParameters, on_change=self._on_change)
        self._parameters.add_listener(self._fail_if_broken)
        # Once, when the parameters are followed: later changes of a test are seen.
        node.create_timer(1e-6, lambda elapsed: self._print(self._parameters.values))
        threading.Thread(target=self._obey, daemon=True).start()

    def _on_change(self, new: GaugeParameters, _old: GaugeParameters) -> None:
        self._changes += 1
        self._print(new)

    def _fail_if_broken(self) -> None:
        if self._broken:
            sys.exit("broken listener")

    def _print(self, values: GaugeParameters) -> None:
        wire = {name: to_wire(value) for name, value in values.as_dict().items()}
        # One write: lines of several threads must not mix.
        sys.stdout.write(json.dumps({"changes": self._changes, "values": wire}) + "\n")
        sys.stdout.flush()

    def _obey(self) -> None:
        for line in sys.stdin:
            command: Dict[str, Any] = json.loads(line)
            for name, value in command.get("set_param", {}).items():
                rospy.set_param(name, value)
            self._broken = command.get("broken", self._broken)
            if "update" in command:
                try:
                    self._parameters.update(**command["update"])
                except (ParameterError, MasterUnreachable) as error:
                    rospy.logwarn("update: %s", error)


if __name__ == "__main__":
    # A busy machine may set values that belong together further apart than nodes wait as a rule.
    reconciler.HALF_DONE_S = 2.0
    run("gauge", Gauge)
