#!/usr/bin/env python3
"""Publish a beat whose tempo can be changed while it runs."""

from nodekit.live.live_parameters import LiveParameters
from nodekit.process.run import run
from nodekit.parameters.declaration import FloatParameter, ParameterSet, StringParameter
from nodekit.messaging.publisher import Publisher
from nodekit.timing.scheduler import get_scheduler
from std_msgs.msg import String


class MetronomeParameters(ParameterSet):
    tempo = FloatParameter(120.0, minimum=20.0, maximum=400.0, unit="1/min", help="beats a minute")
    sound = StringParameter("tick", help="what each beat says")


class Metronome:
    def __init__(self) -> None:
        self.parameters = LiveParameters(MetronomeParameters)
        self.publisher = Publisher("beat", String)
        self.task = get_scheduler().every(self.parameters.values.tempo / 60.0, self.beat)
        self.parameters.start(on_change=lambda new, old: self.task.set_rate(new.tempo / 60.0))

    def beat(self, elapsed: float) -> None:
        self.publisher.publish(String(self.parameters.values.sound))


run("metronome", Metronome)
