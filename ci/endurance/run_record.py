"""Record a signal of 1 kHz in a bag, for long: no sample may be missing, and nothing may grow.

The recorder is one without a queue, unlike ``rosbag record``. A subscriber beside it shows whether
what is missing in the bag was ever sent.
"""

import pathlib
import struct
import sys
import time
from typing import List, Sequence, Tuple

import numpy as np
import rosbag

from .checks import Check, at_least, at_most, reported
from .context import RATE, Soak, signal_pair
from .streams import Continuity, unanswered
from .usage import Sampler, not_grown, size_of

#: Angular frequency of the signal [rad/s]: a period is not a whole number of samples.
FREQUENCY = 1.0
AMPLITUDE = 2.0
#: The phase is known from the second sample on, so the first answers are not compared.
FIRST_ANSWERS = 5
RECORDER = [sys.executable, str(pathlib.Path(__file__).with_name("recorder.py"))]
#: Longest time to warm up [s].
WARM_UP = 60.0


def run(soak: Soak) -> List[Check]:
    """Record for the given time, and check the bag."""
    session, bag = soak.session, soak.session.directory / "record.bag"
    recorder = session.start([*RECORDER, str(bag), "/signal", "/proc_signal"])
    session.wait_for("/record")
    arguments = [f"_frequency:={FREQUENCY:g}", f"_amplitude:={AMPLITUDE:g}"]
    with signal_pair(soak, *arguments) as pair:
        time.sleep(min(WARM_UP, 0.2 * soak.seconds))
        pair.begin()
        logs, began = size_of(session.directory / "ros"), time.monotonic()
        with Sampler({**pair.pids, "record": recorder.pid}) as sampler:
            time.sleep(soak.seconds)
        lasted = time.monotonic() - began
        rate = pair.signal.arrivals.count / lasted
        log_growth = (size_of(session.directory / "ros") - logs) / lasted
        session.stop(pair.generator)
        time.sleep(1.0)  # for what is on the way to the recorder
        checks = [at_least("samples a second", rate, 0.999 * RATE, "1/s"), *pair.silences()]
    session.stop(recorder)
    checks += check_bag(bag)
    bag.unlink()
    for name in pair.pids:
        checks += not_grown(name, sampler.samples[name])
    checks += not_grown("the recorder", sampler.samples["record"])[:1]
    return [*checks, at_most("growth of all logs", log_growth, 100.0, "bytes/s")]


def check_bag(bag: pathlib.Path) -> List[Check]:
    """Check that a bag holds each sample and each answer."""
    times, answers = read(bag)
    # What process does by default: half the amplitude, a lead of pi / 2, lifted above 0.
    expected = 0.5 * AMPLITUDE * (1.0 + np.cos(FREQUENCY * np.asarray(times)))
    continuity = Continuity(1.0 / RATE)
    for time_x in times:
        continuity.add(time_x)
    checks = [
        reported("samples in the bag", str(len(times))),
        at_most("missing in the bag", continuity.missing + continuity.repeated, 0),
    ]
    if all(check.passed for check in checks):
        # If samples are missing, the answers cannot be compared.
        missing = abs(unanswered(expected, answers[FIRST_ANSWERS:]))
        checks.append(at_most("answers in the bag too few or too many", missing, 0))
    return checks


def read(bag: pathlib.Path) -> Tuple[Sequence[float], Sequence[float]]:
    """Return the time of each sample, and each answer."""
    numbers: Tuple[List[float], List[float]] = ([], [])
    with rosbag.Bag(str(bag)) as opened:
        for topic, raw, _ in opened.read_messages(raw=True):
            layout = "<8xd" if topic == "/signal" else "<f"
            numbers[topic != "/signal"].extend(struct.unpack_from(layout, raw[1]))
    return numbers
