#!/usr/bin/env python3
"""The process node on the wire, fed sample by sample."""

import math
import struct
import time
import unittest
from typing import List, Optional

import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

W, RATE = 7.3, 50.0


def float32(value: float) -> float:
    """Return a value rounded to float32, as in a message."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


class Stopwatch:
    """Stopwatch that starts at its creation."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def seconds(self) -> float:
        """Return the time passed [s]."""
        return time.monotonic() - self._began


class ProcessNode(unittest.TestCase):
    """A process node that answers immediately, and one that repeats its output at 50 Hz."""

    answers: MessageRecorder
    steady_answers: MessageRecorder
    log: MessageRecorder

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_process")
        cls.log = MessageRecorder("/rosout", Log)
        cls.answers = MessageRecorder("proc_signal", Float32)
        cls.steady_answers = MessageRecorder("steady/proc_signal", Float32)
        cls.publisher = rospy.Publisher("signal", signal_msg, queue_size=100)
        wait_until(
            lambda: cls.publisher.get_num_connections() == 2,
            lambda: "the nodes did not subscribe to signal",
        )
        for node in ("process", "steady/steady"):
            wait_until(
                lambda: rospy.has_param(f"/{node}/amplitude_scale"),
                lambda: node + " did not start",
            )
        cls.time = 0.0
        cls.heard_before_any_input = cls.listen_for_ten_periods()

    @classmethod
    def listen_for_ten_periods(cls) -> List[Float32]:
        """Return the published messages of ten periods of the node with a rate."""
        beats = MessageRecorder("/beats", Float32)
        metronome = rospy.Publisher("/beats", Float32, queue_size=10)
        timer = rospy.Timer(rospy.Duration(1.0 / RATE), lambda event: metronome.publish(0.0))
        wait_until(lambda: len(beats.messages()) >= 10, lambda: "no beats")
        timer.shutdown()
        return cls.answers.messages() + cls.steady_answers.messages()

    def test_nothing_is_published_before_the_first_input(self) -> None:
        self.assertEqual(self.heard_before_any_input, [])

    def setUp(self) -> None:
        self.set(amplitude_scale=0.5, phase_shift=math.pi / 2.0, offset=0.0)
        self.set(keep_positive=True, input_offset=0.0)

    def set(self, **values: object) -> None:
        """Set parameters of the node that answers immediately."""
        for name, value in values.items():
            rospy.set_param("process/" + name, value)

    def send(self, time_x: float, y: Optional[float] = None, amplitude: float = 2.0) -> None:
        """Publish a sample; of a sine if no value is given."""
        value = amplitude * math.sin(W * time_x) if y is None else y
        self.publisher.publish(signal_msg(amplitude, W, time_x, value))

    def ask(self, time_x: float, y: Optional[float] = None, amplitude: float = 2.0) -> float:
        """Publish a sample and return the answer to it."""
        self.answers.clear()
        self.send(time_x, y, amplitude)
        return float(self.answers.wait_for(lambda answer: True).data)

    def run_on(self, count: int) -> List[float]:
        """Send some more samples of the sine; return their times."""
        times = []
        for _ in range(count):
            type(self).time += 1.0 / RATE
            times.append(self.time)
            self.ask(self.time)
        return times

    def settled(self, expected: float, time_x: float, y: float) -> None:
        """Wait until a change of parameters shows in the answer to a sample."""
        seen: List[float] = []

        def matches() -> bool:
            seen.append(self.ask(time_x, y))
            return abs(seen[-1] - expected) < 1e-6

        wait_until(matches, lambda: f"answered {seen[-1]}, not {expected}")

    def test_sine_is_scaled_shifted_and_lifted(self) -> None:
        self.run_on(3)
        for _ in range(100):
            type(self).time += 1.0 / RATE
            exact = 0.5 * 2.0 * math.sin(W * self.time + math.pi / 2.0) + 1.0
            self.assertAlmostEqual(self.ask(self.time), exact, delta=2e-5)

    def test_without_a_shift_any_input_passes(self) -> None:
        self.set(phase_shift=0.0, keep_positive=False, offset=0.25)
        self.settled(0.5 * 0.7 + 0.25, self.time + 1.0, 0.7)
        type(self).time += 2.0
        for y in (0.1, -1.3, 5.0, 0.0):
            type(self).time += 1.0 / RATE
            self.assertEqual(self.ask(self.time, y), float32(0.5 * float32(y) + 0.25))

    def test_what_is_not_finite_is_dropped_and_counted(self) -> None:
        self.run_on(3)
        for bad in (math.nan, math.inf):
            self.send(self.time + 0.001, bad)
        line = self.log.wait_for(lambda heard: "samples dropped" in heard.msg)
        self.assertEqual(line.level, Log.WARN)
        type(self).time += 1.0 / RATE
        exact = math.sin(W * self.time + math.pi / 2.0) + 1.0
        self.assertAlmostEqual(self.ask(self.time), exact, delta=2e-5)

    def test_time_that_goes_back_starts_the_phase_anew(self) -> None:
        self.run_on(3)
        type(self).time = 1.0
        self.assertTrue(math.isfinite(self.ask(self.time)))
        line = self.log.wait_for(lambda heard: "went back" in heard.msg)
        self.assertEqual(line.level, Log.WARN)
        self.run_on(5)
        type(self).time += 1.0 / RATE
        exact = math.sin(W * self.time + math.pi / 2.0) + 1.0
        self.assertAlmostEqual(self.ask(self.time), exact, delta=2e-5)

    def test_samples_that_were_held_back_are_called_late(self) -> None:
        self.run_on(3)
        silence = Stopwatch()
        wait_until(lambda: silence.seconds() > 1.5, lambda: "time does not pass")
        self.run_on(1)
        line = self.log.wait_for(lambda heard: "s late" in heard.msg)
        self.assertEqual(line.level, Log.WARN)

        def is_in_time() -> bool:
            nonlocal silence
            type(self).time += silence.seconds()
            silence = Stopwatch()
            self.run_on(1)
            return any("in time again" in line.msg for line in self.log.messages())

        wait_until(is_in_time, lambda: str(self.log.messages()[-3:]))

    def test_at_a_rate_it_repeats_the_latest_output(self) -> None:
        self.ask(self.time, 0.5)
        type(self).time += 1.0
        self.steady_answers.clear()
        wait_until(
            lambda: len(self.steady_answers.messages()) >= 20,
            lambda: f"only {len(self.steady_answers.messages())} answers",
        )
        self.assertEqual(len({answer.data for answer in self.steady_answers.messages()}), 1)


if __name__ == "__main__":
    rosrun("basic_comms", "process_on_the_wire", ProcessNode)
