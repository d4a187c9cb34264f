#!/usr/bin/env python3
"""Publish a beat whose tempo can be changed while it runs."""

from nodekit import FloatParameter, Node, ParameterSet, StringParameter, run
from std_msgs.msg import String


class Settings(ParameterSet):
    tempo = FloatParameter(120.0, minimum=20.0, maximum=400.0, unit="1/min", help="beats a minute")
    sound = StringParameter("tick", help="what each beat says")


class Metronome:
    def __init__(self, node: Node) -> None:
        self.settings = node.declare_parameters(Settings)
        self.publisher = node.create_publisher("beat", String)
        node.create_timer(lambda: self.settings.values.tempo / 60.0, self.beat)

    def beat(self, elapsed: float) -> None:
        self.publisher.publish(self.settings.values.sound)


run("metronome", Metronome)
