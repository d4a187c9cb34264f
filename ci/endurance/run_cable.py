"""Generator on one host, process on the other, and the cable between them pulled."""

import subprocess
import time
from typing import Dict, List

from ..benchmark import record
from ..benchmark.analysis import Sample
from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import module
from . import ssh_server
from .checks import Check, at_least, at_most, reported
from .hosts import ADDRESSES, Hosts
from .outage import Outage, counted_losses, outage, reported_lateness
from .watching import ANSWER, SIGNAL

#: samples a second, 1/s: what the course uses, and more than fits into a socket's buffers
RATES = (10.0, 1000.0)
#: longest time from the cable's return until samples flow, s: TCP tries again ever more rarely,
#: after as long as it has been trying already at most
BACK_WITHIN = 60.0
#: how long the streams run before and after, s
STEADY = 5.0


def run(hosts: Hosts) -> List[Check]:
    """Pull the cable at a rate at which nothing need be lost, and at one at which much must be."""
    ssh_server.start(hosts)
    launch = hosts.start(
        "near",
        ["roslaunch", "basic_comms", "cw1_two_hosts.launch"]
        + ["host:=" + ADDRESSES["far"], "user:=root"],
    )
    wait_until(lambda: "/process" in nodes(hosts), 60.0, "process on the other host")
    checks = []
    for rate in RATES:
        hosts.run("near", ["rosparam", "set", "/signal_generator/rate", f"{rate:g}"])
        checks += pull(hosts, rate, hosts.outage)
    hosts.stop(launch)
    checks.append(at_most("exit status of roslaunch", abs(launch.returncode), 0))
    remaining = hosts.run("far", ["ss", "-Hltn", "sport != 22"]).splitlines()
    checks.append(at_most("ports still open on the other host", len(remaining), 0))
    return checks


def nodes(hosts: Hosts) -> str:
    """Return the names of all nodes, as rosnode lists them; none without a master."""
    try:
        return hosts.run("near", ["rosnode", "list"])
    except subprocess.SubprocessError:
        return ""


def pull(hosts: Hosts, rate: float, seconds: float) -> List[Check]:
    """Pull the cable and plug it in again, while both topics are recorded on both sides."""
    wanted = {
        "made": ("near", "/signal", SIGNAL),
        "crossed": ("far", "/signal", SIGNAL),
        "answers": ("near", "/proc_signal", ANSWER),
    }
    files = {name: hosts.directory / f"{name}-{rate:g}" for name in wanted}
    observers = {
        name: hosts.start(host, module("endurance.observe", topic, kind, str(files[name])))
        for name, (host, topic, kind) in wanted.items()
    }
    lost_before = counted_losses(hosts.logs())
    late_before = len(reported_lateness(hosts.logs()))
    time.sleep(STEADY)
    hosts.set_cable(False)
    time.sleep(seconds)
    hosts.set_cable(True)
    plugged = time.monotonic()
    wait_until(
        lambda: len(reported_lateness(hosts.logs())) > late_before,
        2.0 * BACK_WITHIN,
        "word of late samples from process",
    )
    time.sleep(STEADY)
    for observer in observers.values():
        hosts.stop(observer)
    seen: Dict[str, List[Sample]] = {name: record.read(file) for name, file in files.items()}
    crossing = outage(1.0 / rate, seen["crossed"])
    log = hosts.logs()
    losses = {name: total - lost_before.get(name, 0) for name, total in counted_losses(log).items()}
    return report(rate, seconds, plugged, seen, crossing, losses, reported_lateness(log)[-1])


def report(
    rate: float,
    seconds: float,
    plugged: float,
    seen: Dict[str, List[Sample]],
    crossing: Outage,
    losses: Dict[str, int],
    lateness: float,
) -> List[Check]:
    """Return the figures of one outage."""
    local = outage(1.0 / rate, seen["made"])
    back = min(sample.moment for sample in seen["crossed"] if sample.moment > plugged)
    answered = min(sample.moment for sample in seen["answers"] if sample.moment > plugged)
    unaccounted = crossing.lost - sum(
        lost for name, lost in losses.items() if "/observe" in name and name.startswith("/signal ")
    )
    counts = (
        "; ".join(f"{what}: {count}" for what, count in sorted(losses.items()) if count) or "none"
    )
    head = f"{rate:g} Hz, cable out for {seconds:g} s: "
    return [
        at_most(head + "/signal crosses again after", round(back - plugged, 1), BACK_WITHIN, "s"),
        at_most("/proc_signal is back after", round(answered - plugged, 1), BACK_WITHIN, "s"),
        reported("made meanwhile and before and after", f"{crossing.made} samples"),
        # At the first rate all of it fits into the socket's buffers.
        at_most("lost of them", crossing.lost, 0 if rate == RATES[0] else crossing.made),
        reported("lost, by the publishers' own count", counts),
        at_most("lost without being counted", unaccounted, 0),
        at_least("process: samples are late by", lateness, 0.9 * seconds, "s"),
        reported("the latest sample was late by", f"{crossing.lateness:.1f} s"),
        at_most("lost on the generator's own host", local.lost, 0),
        reported("longest silence there", f"{1000.0 * local.silence:.0f} ms"),
    ]
