"""Stop a subscriber for a minute while others listen at 1 kHz."""

import os
import signal
import time
from typing import List

from .checks import Check, at_least, at_most, reported
from .control import Control, silences
from .surroundings import Soak
from .usage import Usage, settled_usage
from .watching import ANSWER, SIGNAL, Watch

RATE = 1000.0
#: how long the subscriber stands still, s
STOPPED = 60.0
#: how long everything has to come back to what it was, s
RECOVERY = 10.0
#: longest silence for everybody else, s
UNDISTURBED = 0.1


def run(soak: Soak) -> List[Check]:
    """Stop a subscriber of both topics, and let it go on."""
    session = soak.session
    process = soak.start("process.py")
    generator = soak.start("signal_generator.py", f"_rate:={RATE:g}")
    session.wait_for("/signal_generator")
    sleeper = session.start(["rostopic", "hz", "/signal", "/proc_signal"])
    pids = {"signal_generator": generator.pid, "process": process.pid}
    with session.node() as node:
        watches = [Watch(node, "/signal", SIGNAL, RATE), Watch(node, "/proc_signal", ANSWER)]
        time.sleep(5.0)
        before = {name: settled_usage(pid) for name, pid in pids.items()}
        for watch in watches:
            watch.restart()
        control = Control(session)
        os.killpg(sleeper.pid, signal.SIGSTOP)
        time.sleep(STOPPED)
        during = {name: settled_usage(pid) for name, pid in pids.items()}
        os.killpg(sleeper.pid, signal.SIGCONT)
        time.sleep(RECOVERY)
        after = {name: settled_usage(pid) for name, pid in pids.items()}
        checks = undisturbed(watches, control)
    log = session.log_of(sleeper)
    checks.append(at_least("reports of the stopped one after its return", log.count("rate"), 1))
    session.stop(sleeper, generator, process)
    for name in pids:
        during_mb = f"{during[name].memory / 1024.0:.1f} MB"
        checks += [reported(f"memory of {name} meanwhile", during_mb)]
        checks += returned(name, before[name], after[name])
    return checks


def undisturbed(watches: List[Watch], control: Control) -> List[Check]:
    """Check that a good subscriber got everything, and soon.

    :param watches: its topics; that of a signal first
    """
    checks = []
    for watch in watches:
        longest = round(1e3 * watch.arrivals.longest_gap, 1)
        what = f"longest silence of {watch.topic} for a good one"
        checks.append(at_most(what, longest, 1e3 * UNDISTURBED, "ms"))
        checks.append(reported("its silences", silences(watch.arrivals)))
    checks.append(reported("pauses of a loop that only sleeps", control.stop()))
    continuity = watches[0].continuity
    assert continuity is not None
    checks.append(at_most("missing for a good one", continuity.missing, 0))
    return checks


def returned(name: str, before: Usage, after: Usage) -> List[Check]:
    """Check that a node holds no more than before."""
    figure = f"{before.memory / 1024.0:.1f} MB, {after.memory / 1024.0:.1f} MB"
    grown = 100.0 * (after.memory / before.memory - 1.0)
    return [
        reported(f"memory of {name} before and after", figure),
        at_most("growth of its memory", round(grown, 2), 1.0, "%"),
        at_most("its new threads", after.threads - before.threads, 0),
        at_most("its new descriptors", after.descriptors - before.descriptors, 0),
    ]
