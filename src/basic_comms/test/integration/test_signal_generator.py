#!/usr/bin/env python3
"""Signal generator node: its samples, its services, and its rejection of invalid values."""

import math
import os
import tempfile
import unittest
from typing import List

import numpy as np
import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from basic_comms.msg import signal_msg
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

RATE = 500.0
#: A generator that a busy machine holds up for longer skips the samples of that time [s].
CATCH_UP_S = 0.5
#: Number of tries on a busy machine.
ATTEMPTS = 10


def is_running(sample: signal_msg) -> bool:
    """Return whether a sample belongs to a running signal."""
    return bool(sample.amplitude > 0.0)


class SignalGeneratorNode(unittest.TestCase):
    """One generator at 500 Hz, reset before each test."""

    samples: MessageRecorder
    log: MessageRecorder

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_signal_generator")
        cls.log = MessageRecorder("/rosout", Log)
        cls.samples = MessageRecorder("signal", signal_msg)
        rospy.wait_for_service("generator/reset", TIMEOUT_S)
        cls.enable = rospy.ServiceProxy("generator/enable", SetBool)
        cls.reset = rospy.ServiceProxy("generator/reset", Trigger)

    def setUp(self) -> None:
        self.set(waveform="sine", frequency=2.0 * math.pi * 10.0, amplitude=2.0, duration=0.0)
        self.enable(True)
        self.samples.clear()
        self.samples.wait_for(
            lambda sample: sample.amplitude == 2.0 and abs(sample.frequency - 62.83185) < 1e-3
        )
        self.samples.clear()
        self.reset()
        self.samples.wait_for(lambda sample: sample.time_x == 0.0)
        self.log.clear()
        self.samples.clear()

    def set(self, **values: object) -> None:
        """Set parameters of the generator."""
        for name, value in values.items():
            rospy.set_param("generator/" + name, value)

    def record(self, count: int) -> List[signal_msg]:
        """Return consecutive samples; fewer than those of 0.5 s must never be missing."""
        for _ in range(ATTEMPTS):
            self.samples.clear()
            wait_until(
                lambda: len(self.samples.messages()) >= count,
                lambda: f"only {len(self.samples.messages())} samples",
            )
            samples = self.samples.messages()[:count]
            steps = [later.time_x - one.time_x for one, later in zip(samples, samples[1:])]
            gaps = [step for step in steps if round(step * RATE, 3) != 1.0]
            self.assertEqual([gap for gap in gaps if gap <= CATCH_UP_S], [])
            if not gaps:
                return samples
        raise AssertionError(f"{ATTEMPTS} times without samples: {gaps}")

    def test_each_sample_belongs_to_exactly_its_time(self) -> None:
        samples = self.record(200)
        self.assertEqual(len(samples), 200)
        for sample in samples:
            exact = 2.0 * math.sin(2.0 * math.pi * 10.0 * sample.time_x)
            self.assertAlmostEqual(sample.signal_y, exact, delta=2.5e-7)

    def test_no_sample_is_missing(self) -> None:
        numbers = [sample.time_x * RATE for sample in self.record(int(RATE))]
        self.assertEqual(len(numbers), RATE)
        for before, number in zip(numbers, numbers[1:]):
            self.assertAlmostEqual(number - before, 1.0, places=6)

    def test_the_spectrum_is_one_line_above_float32_noise(self) -> None:
        record = [sample.signal_y for sample in self.record(int(RATE))]
        spectrum = np.abs(np.fft.rfft(record)) / (len(record) / 2.0)
        self.assertAlmostEqual(spectrum[10], 2.0, delta=1e-6)
        harmonics = np.sqrt(np.sum(spectrum[20::10] ** 2)) / spectrum[10]
        self.assertLess(harmonics, 1e-7)
        self.assertLess(np.max(np.delete(spectrum, 10)), 1e-7)

    def test_a_change_of_frequency_does_not_make_the_phase_jump(self) -> None:
        self.set(frequency=50.0)
        self.samples.wait_for(lambda sample: sample.frequency == 50.0)
        self.set(frequency=80.0)
        self.samples.wait_for(lambda sample: sample.frequency == 80.0)
        phase = 0.0
        heard = self.samples.messages()
        for before, sample in zip(heard, heard[1:]):
            step = sample.time_x - before.time_x
            if before is heard[0] or step <= 0.0:
                phase = 2.0 * math.pi * 10.0 * sample.time_x  # since the reset
            else:
                phase += sample.frequency * step
            self.assertAlmostEqual(sample.signal_y, 2.0 * math.sin(phase), delta=1e-5)
        self.assertEqual({50.0, 80.0} - {sample.frequency for sample in heard}, set())

    def test_stopped_it_sends_the_stop_value_and_its_time_stands_still(self) -> None:
        self.set(stop_value=0.25)
        self.assertEqual(self.enable(False).message, "stopped")
        self.assertEqual(self.enable(False).message, "stopped already")
        idle = self.samples.wait_for(lambda sample: sample.signal_y == 0.25)
        self.assertEqual((idle.amplitude, idle.frequency), (0.0, 0.0))
        late_joiner = MessageRecorder("generator/status", String)
        status = late_joiner.wait_for(lambda heard: heard.data.startswith("idle "))
        self.assertEqual(status.data, f"idle {idle.time_x:.3f}")
        late_joiner.close()
        self.samples.clear()
        self.assertEqual(self.enable(True).message, "enabled")
        running = self.samples.wait_for(is_running)
        self.assertAlmostEqual(running.time_x, idle.time_x, delta=0.5 / RATE)

    def test_reset_starts_time_and_phase_again(self) -> None:
        self.samples.wait_for(lambda sample: sample.time_x > 0.2)
        self.samples.clear()
        self.assertTrue(self.reset().success)
        first = self.samples.wait_for(lambda sample: sample.time_x == 0.0)
        self.assertEqual(first.signal_y, 0.0)

    def test_it_finishes_after_its_duration(self) -> None:
        status = MessageRecorder("generator/status", String)
        self.enable(False)
        self.set(duration=0.1, stop_value=0.5)
        self.samples.wait_for(lambda sample: sample.signal_y == 0.5)
        self.reset()
        self.enable(True)
        status.wait_for(lambda heard: heard.data == "finished 0.100")
        self.set(duration=0.0)
        status.wait_for(lambda heard: heard.data.startswith("running "))
        status.close()

    def test_a_broken_file_is_refused_and_the_signal_goes_on(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "broken.csv")
            with open(path, "w") as file:
                file.write("0,1\n1,2\n1,3\n")
            self.set(file=path)
            line = self.log.wait_for(lambda heard: "broken.csv" in heard.msg).msg
        self.assertIn("/generator/file", line)
        self.assertIn("line 3", line)
        self.samples.clear()
        self.samples.wait_for(is_running)
        self.assertEqual(rospy.get_param("generator/file"), "")

    def test_it_replays_a_file(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "steps.csv")
            with open(path, "w") as file:
                file.write("time,value\n0,0\n0.1,0.5\n0.2,-1\n0.3,0\n")
            self.set(amplitude=3.0, file_mode="hold", file_loop=True, file=path)
            self.set(waveform="file")
            self.samples.wait_for(lambda sample: sample.signal_y == 1.5)
            self.samples.wait_for(lambda sample: sample.signal_y == -3.0)

    def test_it_warns_above_the_nyquist_frequency(self) -> None:
        self.set(frequency=2000.0)
        line = self.log.wait_for(lambda heard: "Nyquist" in heard.msg)
        self.assertEqual(line.level, Log.WARN)
        self.assertIn("2000 rad/s", line.msg)


if __name__ == "__main__":
    rosrun("basic_comms", "signal_generator_on_the_wire", SignalGeneratorNode)
