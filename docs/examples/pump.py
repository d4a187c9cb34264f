#!/usr/bin/env python3
"""Run a pump, but only while others have this node active."""

from std_msgs.msg import Float32

from nodekit import FloatParameter, ManagedNode, NodeScope, ParameterSet, run


class Settings(ParameterSet):
    flow = FloatParameter(2.0, minimum=0.0, maximum=5.0, unit="l/min", help="while it runs")


class Pump(ManagedNode):
    def on_configure(self, scope: NodeScope) -> None:
        self.settings = scope.declare_parameters(Settings)
        self.command = scope.create_publisher("flow", Float32)

    def on_activate(self, scope: NodeScope) -> None:
        scope.create_timer(10.0, self.deliver)

    def on_deactivate(self) -> None:
        self.command.publish(0.0)

    def on_shutdown(self) -> None:
        if self.previous_state.label == "active":
            self.command.publish(0.0)

    def deliver(self, elapsed: float) -> None:
        self.command.publish(self.settings.values.flow)


run("pump", Pump)
