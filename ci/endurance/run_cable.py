"""Pull the cable between a generator on one host and a process node on the other."""

import re
import time
from typing import Any, Dict, List

import numpy as np

from ..benchmark.recorder import wait_until
from . import ssh_server
from .checks import Check, at_least, at_most, reported
from .hosts import ADDRESSES, Hosts

#: Rates of the samples [Hz]: the course's, and one that exceeds a socket's buffers.
RATES = (10.0, 1000.0)
#: Longest time from the cable's return until samples flow [s]: TCP's pause between two retries is
#: at most the time of all retries before.
BACK_WITHIN = 60.0
#: Time before and after the outage [s].
STEADY = 5.0
#: Column of time_x in rostopic's output for /signal.
TIME_X = 3
#: Host and topic of each observer.
OBSERVED = {
    "made": ("near", "/signal"),
    "crossed": ("far", "/signal"),
    "answers": ("near", "/proc_signal"),
}

_LOSS = re.compile(r"(\S+): subscriber (\S+) (?:does not keep|keeps) up.* (\d+) in all")
_LATE = re.compile(r"in time again; \d+ were late, by up to ([0-9.]+) s")


def lost(times: Any, rate: float) -> int:
    """Return how many samples are missing between the first and the last.

    :param times: the time of each sample [s]
    :param rate: of the samples [Hz]
    """
    steps = np.round(np.diff(times) * rate)
    return int((steps[steps > 1] - 1).sum())


def counted_losses(log: str) -> Dict[str, int]:
    """Return the number of lost messages that publishers report, by "topic subscriber"."""
    losses: Dict[str, int] = {}
    for topic, subscriber, total in _LOSS.findall(log):
        key = f"{topic} {subscriber}"
        losses[key] = max(losses.get(key, 0), int(total))
    return losses


def reported_lateness(log: str) -> List[float]:
    """Return the delays that a node reports after each outage [s]."""
    return [float(worst) for worst in _LATE.findall(log)]


def run(hosts: Hosts) -> List[Check]:
    """Pull the cable at a rate without necessary losses, and at a rate with many."""
    ssh_server.start(hosts)
    command = ["roslaunch", "basic_comms", "cw1_two_hosts.launch"]
    launch = hosts.start_on("near", [*command, "host:=" + ADDRESSES["far"], "user:=root"])
    wait_until(lambda: "/process" in hosts.nodes(), 60.0, "process on the other host")
    checks = []
    for rate in RATES:
        hosts.run_on("near", ["rosparam", "set", "/signal_generator/rate", f"{rate:g}"])
        checks += pull(hosts, rate)
    hosts.stop(launch)
    checks.append(at_most("exit status of roslaunch", abs(launch.returncode), 0))
    remaining = hosts.run_on("far", ["ss", "-Hltn", "sport != 22"]).splitlines()
    return [*checks, at_most("ports still open on the other host", len(remaining), 0)]


def pull(hosts: Hosts, rate: float) -> List[Check]:
    """Pull the cable and plug it in again, while both topics are observed on both sides."""

    def log() -> str:
        return "\n".join(hosts.logs())

    def late() -> List[float]:
        return reported_lateness(log())[late_before:]

    observers = {
        name: hosts.start_on(host, ["rostopic", "echo", "-p", topic])
        for name, (host, topic) in OBSERVED.items()
    }
    lost_before, late_before = counted_losses(log()), len(reported_lateness(log()))
    time.sleep(STEADY)
    hosts.set_cable(False)
    time.sleep(hosts.outage)
    hosts.set_cable(True)
    plugged = time.time()
    wait_until(late, 2.0 * BACK_WITHIN, "report of late samples from process")
    time.sleep(STEADY)
    hosts.stop(*observers.values())
    # Each line has the moment of a message's arrival [ns], and its fields.
    lines = {name: hosts.log_of(one).splitlines()[1:] for name, one in observers.items()}
    rows = {name: np.loadtxt(of_one, delimiter=",") for name, of_one in lines.items()}
    moments = {name: 1e-9 * of_one[:, 0] for name, of_one in rows.items()}
    back = {name: np.round(one[one > plugged][0] - plugged, 1) for name, one in moments.items()}
    times = {name: rows[name][:, TIME_X] for name in ("made", "crossed")}
    losses = {
        name: total - lost_before.get(name, 0) for name, total in counted_losses(log()).items()
    }
    counted = sum(count for name, count in losses.items() if name.startswith("/signal /rostopic"))
    counts = "; ".join(f"{what}: {count}" for what, count in sorted(losses.items()) if count)
    crossing, delays = lost(times["crossed"], rate), moments["crossed"] - times["crossed"]
    made = len(times["crossed"]) + crossing
    head = f"{rate:g} Hz, cable out for {hosts.outage:g} s: "
    return [
        at_most(head + "/signal is back after", back["crossed"], BACK_WITHIN, "s"),
        at_most("/proc_signal is back after", back["answers"], BACK_WITHIN, "s"),
        at_least("process: samples are late by", late()[-1], 0.9 * hosts.outage, "s"),
        reported("the latest sample was late by", f"{np.ptp(delays):.1f} s"),
        reported("made meanwhile and before and after", f"{made} samples"),
        # At the first rate all of it fits into the socket's buffers.
        at_most("lost of them", crossing, 0 if rate == RATES[0] else made),
        reported("lost, by the publishers' own count", counts or "none"),
        at_most("lost without being counted", crossing - counted, 0),
        at_most("lost on the generator's own host", lost(times["made"], rate), 0),
        reported("longest silence there", f"{1000.0 * np.diff(moments['made']).max():.0f} ms"),
    ]
