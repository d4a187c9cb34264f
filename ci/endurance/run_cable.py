"""Generator on one host, process on the other, and the cable between them pulled."""

import re
import subprocess
import time
from typing import Dict, List, NamedTuple, Sequence

from ..benchmark import record
from ..benchmark.peer_programs import module
from ..benchmark.record import Sample
from ..benchmark.recorder import wait_until
from . import ssh_server
from .checks import Check, at_least, at_most, reported
from .hosts import ADDRESSES, Hosts
from .streams import Continuity
from .watching import ANSWER, SIGNAL

#: Rates of the samples [Hz]: the course's, and one that exceeds a socket's buffers.
RATES = (10.0, 1000.0)
#: Longest time from the cable's return until samples flow [s]: TCP retries ever more rarely, after
#: as long as it has been retrying already at most.
BACK_WITHIN = 60.0
#: Time before and after the outage [s].
STEADY = 5.0

_LOSS = re.compile(r"(\S+): subscriber (\S+) (?:does not keep|keeps) up.* (\d+) in all")
_LATE = re.compile(r"in time again; (\d+) were late, by up to ([0-9.]+) s")


class Outage(NamedTuple):
    """Samples made and lost between the first and the last arrival, silence and delay [s]."""

    made: int
    lost: int
    silence: float
    lateness: float


def outage(period: float, there: Sequence[Sample]) -> Outage:
    """Return the figures of what crossed the network.

    :param period: from one sample to the next [s]
    :param there: moment of arrival on the other side and time_x of each sample
    """
    continuity = Continuity(period)
    for sample in there:
        continuity.add(sample.value)
    silence = max(later.moment - earlier.moment for earlier, later in zip(there, there[1:]))
    delays = [sample.moment - sample.value for sample in there]
    made = len(there) + continuity.missing
    return Outage(made, continuity.missing, silence, max(delays) - min(delays))


def counted_losses(log: str) -> Dict[str, int]:
    """Return how many messages publishers say that they lost, by "topic subscriber"."""
    losses: Dict[str, int] = {}
    for topic, subscriber, total in _LOSS.findall(log):
        key = f"{topic} {subscriber}"
        losses[key] = max(losses.get(key, 0), int(total))
    return losses


def reported_lateness(log: str) -> List[float]:
    """Return the delays that a node reports after each outage [s]."""
    return [float(worst) for _, worst in _LATE.findall(log)]


def run(hosts: Hosts) -> List[Check]:
    """Pull the cable at a rate at which nothing need be lost, and at one at which much must be."""
    ssh_server.start(hosts)
    command = ["roslaunch", "basic_comms", "cw1_two_hosts.launch"]
    launch = hosts.start_on("near", [*command, "host:=" + ADDRESSES["far"], "user:=root"])
    wait_until(lambda: "/process" in nodes(hosts), 60.0, "process on the other host")
    checks = []
    for rate in RATES:
        hosts.run_on("near", ["rosparam", "set", "/signal_generator/rate", f"{rate:g}"])
        checks += pull(hosts, rate)
    hosts.stop(launch)
    checks.append(at_most("exit status of roslaunch", abs(launch.returncode), 0))
    remaining = hosts.run_on("far", ["ss", "-Hltn", "sport != 22"]).splitlines()
    return [*checks, at_most("ports still open on the other host", len(remaining), 0)]


def nodes(hosts: Hosts) -> str:
    """Return the names of all nodes; nothing without a master."""
    try:
        return hosts.run_on("near", ["rosnode", "list"])
    except subprocess.SubprocessError:
        return ""


def pull(hosts: Hosts, rate: float) -> List[Check]:
    """Pull the cable and plug it in again, while both topics are recorded on both sides."""

    def log() -> str:
        return "\n".join(hosts.logs())

    wanted = {
        "made": ("near", "/signal", SIGNAL),
        "crossed": ("far", "/signal", SIGNAL),
        "answers": ("near", "/proc_signal", ANSWER),
    }
    files = {name: hosts.directory / f"{name}-{rate:g}" for name in wanted}
    observers = [
        hosts.start_on(host, module("endurance.observe", topic, kind, str(files[name])))
        for name, (host, topic, kind) in wanted.items()
    ]
    lost_before, late_before = counted_losses(log()), len(reported_lateness(log()))
    time.sleep(STEADY)
    hosts.set_cable(False)
    time.sleep(hosts.outage)
    hosts.set_cable(True)
    plugged = time.monotonic()
    wait_until(
        lambda: len(reported_lateness(log())) > late_before,
        2.0 * BACK_WITHIN,
        "report of late samples from process",
    )
    time.sleep(STEADY)
    hosts.stop(*observers)
    seen = {name: record.read(file) for name, file in files.items()}
    losses = {
        name: total - lost_before.get(name, 0) for name, total in counted_losses(log()).items()
    }
    back = {
        name: round(min(one.moment for one in of_one if one.moment > plugged) - plugged, 1)
        for name, of_one in seen.items()
    }
    head = f"{rate:g} Hz, cable out for {hosts.outage:g} s: "
    return [
        at_most(head + "/signal is back after", back["crossed"], BACK_WITHIN, "s"),
        at_most("/proc_signal is back after", back["answers"], BACK_WITHIN, "s"),
        at_least(
            "process: samples are late by", reported_lateness(log())[-1], 0.9 * hosts.outage, "s"
        ),
        *report(
            rate, outage(1.0 / rate, seen["made"]), outage(1.0 / rate, seen["crossed"]), losses
        ),
    ]


def report(rate: float, local: Outage, crossing: Outage, losses: Dict[str, int]) -> List[Check]:
    """Return the losses of one outage.

    :param local: the stream on the generator's host
    :param losses: the publishers' own counts
    """
    counts = "; ".join(f"{what}: {count}" for what, count in sorted(losses.items()) if count)
    counted = sum(
        lost for name, lost in losses.items() if "/observe" in name and name.startswith("/signal ")
    )
    # At the first rate all of it fits into the socket's buffers.
    most = 0 if rate == RATES[0] else crossing.made
    return [
        reported("the latest sample was late by", f"{crossing.lateness:.1f} s"),
        reported("made meanwhile and before and after", f"{crossing.made} samples"),
        at_most("lost of them", crossing.lost, most),
        reported("lost, by the publishers' own count", counts or "none"),
        at_most("lost without being counted", crossing.lost - counted, 0),
        at_most("lost on the generator's own host", local.lost, 0),
        reported("longest silence there", f"{1000.0 * local.silence:.0f} ms"),
    ]
