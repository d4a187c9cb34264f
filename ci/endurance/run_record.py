"""Record a signal of 1 kHz in a bag for long, without a missing sample or growing memory.

The recorder does not queue, unlike ``rosbag record``.
"""

import pathlib
import struct
import sys
import time
from typing import Any, List, Tuple

import numpy as np
import rosbag

from ..benchmark.peer_programs import executable
from .checks import Check, at_least, at_most, reported
from .context import Soak
from .usage import Sampler, not_grown

RATE = 1000.0
#: Angular frequency of the signal [rad/s]: a period is not a whole number of samples.
FREQUENCY = 1.0
AMPLITUDE = 2.0
#: The phase is known from the second sample on, so the first answers are not compared.
FIRST_ANSWERS = 5
RECORDER = [sys.executable, str(pathlib.Path(__file__).with_name("recorder.py"))]
#: Most samples that the recorder may miss of one topic before the first of the other.
MISSED = 500
#: Longest time to warm up [s].
WARM_UP = 60.0


def run(soak: Soak) -> List[Check]:
    """Record for the given time, and check the bag."""
    session, bag = soak.session, soak.session.directory / "record.bag"
    settings = [f"_rate:={RATE:g}", f"_frequency:={FREQUENCY:g}", f"_amplitude:={AMPLITUDE:g}"]
    commands = {
        "record": [*RECORDER, str(bag), "/signal", "/proc_signal"],
        "process": executable("basic_comms", "process.py"),
        "signal_generator": executable("basic_comms", "signal_generator.py", *settings),
    }
    running = {}
    for name, command in commands.items():
        running[name] = session.start(command)
        session.wait_for("/" + name)
    time.sleep(min(WARM_UP, 0.2 * soak.seconds))
    logs, began = size_of(session.directory / "ros"), time.monotonic()
    with Sampler({name: process.pid for name, process in running.items()}) as sampler:
        time.sleep(soak.seconds)
    log_growth = (size_of(session.directory / "ros") - logs) / (time.monotonic() - began)
    session.stop(running["signal_generator"])
    time.sleep(1.0)  # for messages on the way to the recorder
    session.stop(*running.values())
    checks = check_bag(bag)
    for name in ("signal_generator", "process"):
        checks += not_grown(name, sampler.samples[name])
    checks += not_grown("the recorder", sampler.samples["record"])[:1]
    return [*checks, at_most("growth of all logs", log_growth, 100.0, "bytes/s")]


def check_bag(bag: pathlib.Path) -> List[Check]:
    """Check that a bag holds each sample and each answer."""
    (received, times), (_, answers) = read(bag, "/signal", "<8xd"), read(bag, "/proc_signal", "<f")
    steps = np.round(np.diff(times) * RATE).astype(int)
    # The process node's default: half the amplitude, a lead of pi / 2, an offset above 0.
    expected = 0.5 * AMPLITUDE * (1.0 + np.cos(FREQUENCY * times))
    # The recorder may have missed the first messages of either topic.
    both = max(1, min(len(times), len(answers)) - FIRST_ANSWERS)
    wrong = np.count_nonzero(np.abs(expected[-both:] - answers[-both:]) > 1e-4)
    return [
        reported("samples in the bag", str(len(times))),
        at_least("samples a second", len(times) / np.ptp(received), 0.999 * RATE, "1/s"),
        reported("longest silence", f"{1e3 * np.diff(received).max():.1f} ms"),
        at_most("missing or repeated in the bag", np.count_nonzero(steps != 1), 0),
        at_most("answers missing, or not to their samples", wrong, 0),
        at_least("answers compared", both, len(times) - MISSED),
    ]


def read(bag: pathlib.Path, topic: str, layout: str) -> Tuple[Any, Any]:
    """Return the times at which messages of a topic were recorded [s], and a number of each."""
    with rosbag.Bag(str(bag)) as opened:
        found = [
            (moment.to_sec(), *struct.unpack_from(layout, raw[1]))
            for _, raw, moment in opened.read_messages(topic, raw=True)
        ]
    moments, numbers = np.array(found).T
    return moments, numbers


def size_of(directory: pathlib.Path) -> int:
    """Return the total length of the files below a directory [bytes]."""
    files = [path for path in directory.rglob("*") if path.is_file() and not path.is_symlink()]
    return sum(path.stat().st_size for path in files)
