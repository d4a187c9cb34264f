"""Stop a subscriber for a minute while another one listens at 1 kHz."""

import os
import signal
import time
from typing import List

from .checks import Check, at_least, reported
from .context import Soak, signal_pair

#: How long the subscriber is stopped, and time for everything to recover [s].
STOPPED, RECOVERY = 60.0, 10.0


def run(soak: Soak) -> List[Check]:
    """Stop a subscriber of both topics, and let it continue."""
    session = soak.session
    with signal_pair(soak) as pair:
        stalled = session.start(["rostopic", "hz", "/signal", "/proc_signal"])
        time.sleep(5.0)
        pair.begin()
        os.killpg(stalled.pid, signal.SIGSTOP)
        time.sleep(STOPPED)
        during = pair.usage()
        os.killpg(stalled.pid, signal.SIGCONT)
        time.sleep(RECOVERY)
        checks = pair.end()
        rates = session.log_of(stalled).count("rate")
    return [
        *checks,
        at_least("reports of the stopped subscriber after its return", rates, 1),
        *(
            reported(f"memory of {name} meanwhile", f"{usage.memory / 1024.0:.1f} MB")
            for name, usage in during.items()
        ),
    ]
