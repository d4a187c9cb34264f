"""Record a signal of 1 kHz in a bag, for long: nothing may be missing, and nothing may grow.

The recorder is one without a queue, unlike ``rosbag record``. An observer listens beside it, so
that what is missing in the bag can be told from what was never sent.
"""

import array
import math
import pathlib
import struct
import sys
import time
from typing import List, Sequence, Tuple

import rosbag

from .checks import Check, at_least, at_most, reported
from .control import Control, silences
from .streams import Continuity, unanswered
from .surroundings import Soak
from .usage import Sampler, Usage, added, growth, size_of
from .watching import ANSWER, SIGNAL, Watch

RATE = 1000.0
#: angular frequency of the signal, rad/s: a period is no whole number of samples
FREQUENCY = 1.0
AMPLITUDE = 2.0
#: the phase is known from the second sample on, so the first answers say nothing
FIRST_ANSWERS = 5
RECORDER = [sys.executable, str(pathlib.Path(__file__).with_name("recorder.py"))]
#: longest time that everything is left to warm up, s
WARM_UP = 60.0
#: by how much the logs may grow, bytes/s: a line now and then
LOG_GROWTH = 100.0


def run(soak: Soak) -> List[Check]:
    """Record for as long as was asked for, and look at the bag."""
    session = soak.session
    bag = session.directory / "record.bag"
    recorder = session.start([*RECORDER, str(bag), "/signal", "/proc_signal"])
    session.wait_for("/record")
    process = soak.start("process.py")
    session.wait_for("/process")
    with session.node() as node:
        signal = Watch(node, "/signal", SIGNAL, RATE)
        answers = Watch(node, "/proc_signal", ANSWER)
        generator = soak.start(
            "signal_generator.py",
            f"_rate:={RATE:g}",
            f"_frequency:={FREQUENCY:g}",
            f"_amplitude:={AMPLITUDE:g}",
        )
        session.wait_for("/signal_generator")
        time.sleep(min(WARM_UP, 0.2 * soak.seconds))
        for watch in (signal, answers):
            watch.restart()
        log_size = size_of(session.directory / "ros")
        pids = {"signal_generator": generator.pid, "process": process.pid}
        control = Control(session)
        began = time.monotonic()
        with Sampler({**pids, "record": recorder.pid}) as sampler:
            time.sleep(soak.seconds)
        lasted = time.monotonic() - began
        log_growth = (size_of(session.directory / "ros") - log_size) / lasted
        session.stop(generator)
        time.sleep(1.0)  # for the recorder to take in what is under way
        checks = [
            at_least("samples a second", signal.arrivals.count / lasted, 0.999 * RATE, "1/s"),
            reported("silences of /signal", silences(signal.arrivals)),
            reported("silences of /proc_signal", silences(answers.arrivals)),
            reported("pauses of a loop that only sleeps", control.stop()),
        ]
        assert signal.continuity is not None
        checks.append(at_most("missing at an observer", signal.continuity.missing, 0))
    session.stop(process, recorder)
    checks += recorded(bag)
    for name in pids:
        checks += grown(name, sampler.samples[name])
    checks.append(reported("growth of the recorder", memory(sampler.samples["record"])))
    checks.append(at_most("growth of all logs", log_growth, LOG_GROWTH, "bytes/s"))
    bag.unlink()
    return checks


def recorded(bag: pathlib.Path) -> List[Check]:
    """Look whether a bag holds each sample and each answer."""
    times, answers = read(bag)
    # What process does by default: half the amplitude, a lead of pi / 2, lifted above 0.
    expected = array.array(
        "d", (0.5 * AMPLITUDE * (1.0 + math.cos(FREQUENCY * time_x)) for time_x in times)
    )
    continuity = Continuity(1.0 / RATE)
    for time_x in times:
        continuity.add(time_x)
    checks = [
        reported("samples in the bag", str(len(times))),
        at_most("missing in the bag", continuity.missing + continuity.repeated, 0),
        reported("in so many places", f"{continuity.holes}, at most {continuity.largest_hole}"),
    ]
    if all(check.passed for check in checks):
        # Where samples are missing, the answers cannot be laid on them.
        missing = abs(unanswered(expected, answers[FIRST_ANSWERS:]))
        checks.append(at_most("answers in the bag too few or too many", missing, 0))
    return checks


def read(bag: pathlib.Path) -> Tuple[Sequence[float], Sequence[float]]:
    """Return the time of each sample, and each answer."""
    times, answers = array.array("d"), array.array("f")  # of hours, millions of each
    with rosbag.Bag(str(bag)) as opened:
        for topic, raw, _ in opened.read_messages(raw=True):
            if topic == "/signal":
                times.append(struct.unpack_from("<8xd", raw[1])[0])
            else:
                answers.append(struct.unpack_from("<f", raw[1])[0])
    return times, answers


def grown(name: str, seen: List[Usage]) -> List[Check]:
    """Check that a node's memory, threads and descriptors have stayed what they were."""
    return [
        reported("memory of " + name, memory(seen)),
        at_most(
            "growth of its memory", round(100.0 * growth([one.memory for one in seen]), 2), 1.0, "%"
        ),
        at_most("its new threads", added([one.threads for one in seen]), 0),
        at_most("its new descriptors", added([one.descriptors for one in seen]), 0),
    ]


def memory(seen: List[Usage]) -> str:
    """Tell how a process's memory went."""
    return f"{seen[0].memory / 1024.0:.1f} MB, then {seen[-1].memory / 1024.0:.1f} MB"
