#!/usr/bin/env python3
"""Keep a robot one metre from a wall."""

from nodekit import FloatParameter, Node, ParameterSet, RateParameter, run
from std_msgs.msg import Float32
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse


class Settings(ParameterSet):
    rate = RateParameter(20.0, help="how often the speed is published")
    gain = FloatParameter(0.5, minimum=0.0, unit="1/s", help="speed for each metre of error")


class RangeKeeper:
    def __init__(self, node: Node) -> None:
        self.settings = node.declare_parameters(Settings)
        self.enabled = True
        self.speed = node.create_publisher("speed", Float32)
        self.range = node.create_latest_message("range", Float32)
        node.create_service("~enable", SetBool, self.enable)
        node.create_timer(lambda: self.settings.values.rate, self.control)

    def enable(self, request: SetBoolRequest) -> SetBoolResponse:
        self.enabled = request.data
        return SetBoolResponse(True, "")

    def control(self, elapsed: float) -> None:
        if self.enabled and self.range.age < 1.0:
            self.speed.publish(self.settings.values.gain * (self.range.message.data - 1.0))


if __name__ == "__main__":
    run("range_keeper", RangeKeeper)
