#!/usr/bin/env python3
"""Publish a beat whose tempo can be changed while it runs."""

import rospy
from basic_comms.live_parameters import LiveParameters
from basic_comms.node_main import run
from basic_comms.parameters import FloatParameter, ParameterSet, StringParameter
from basic_comms.scheduling import Scheduler
from std_msgs.msg import String


class MetronomeParameters(ParameterSet):
    tempo = FloatParameter(120.0, minimum=20.0, maximum=400.0, unit="1/min", help="beats a minute")
    sound = StringParameter("tick", help="what each beat says")


class Metronome:
    def __init__(self) -> None:
        self.parameters = LiveParameters(MetronomeParameters)
        self.publisher = rospy.Publisher("beat", String, queue_size=10)
        self.task = Scheduler().every(self.parameters.values.tempo / 60.0, self.beat)
        self.parameters.start(on_change=lambda new, old: self.task.set_rate(new.tempo / 60.0))

    def beat(self, elapsed: float) -> None:
        self.publisher.publish(self.parameters.values.sound)


run("metronome", Metronome)
