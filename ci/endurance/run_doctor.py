"""Ask doctor on both hosts of a healthy system, and of one with a node that announced localhost."""

import subprocess
from typing import List

from ..benchmark.recorder import wait_until
from . import ssh_server
from .checks import Check, none_of, reported
from .hosts import ADDRESSES, Hosts

DOCTOR = ["rosrun", "nodekit", "doctor"]
LISTENER = ["rosrun", "basic_comms", "listener.py"]


def run(hosts: Hosts) -> List[Check]:
    """Ask while both hosts have nodes, and then beside a node that announced localhost."""
    ssh_server.start(hosts)
    command = ["roslaunch", "basic_comms", "cw1_two_hosts.launch"]
    launch = hosts.start_on("near", [*command, "host:=" + ADDRESSES["far"], "user:=root"])
    wait_until(lambda: "/process" in hosts.nodes(), 60.0, "process on the other host")
    hosts.run_on("near", ["rostopic", "echo", "-n", "1", "/proc_signal"])  # all are connected
    checks = [none_of(f"faults found on {host}", faults(hosts, host)) for host in ADDRESSES]
    local = {**hosts.environment_of("far"), "ROS_HOSTNAME": "localhost"}
    del local["ROS_IP"]
    wrong = hosts.start_on("far", LISTENER, local)
    wait_until(lambda: "/listener" in hosts.nodes(), 60.0, "listener that announced localhost")
    found = [one for one in faults(hosts, "near") if one.startswith("/listener: ")]
    checks.append(reported("fault of a node that announced localhost", "; ".join(found)))
    checks.append(none_of("not found", [] if found else ["/listener"]))
    hosts.stop(wrong, launch)
    return checks


def faults(hosts: Hosts, host: str) -> List[str]:
    """Return the faults that doctor finds on a host.

    :raises RuntimeError: if its exit status does not agree
    :raises subprocess.TimeoutExpired: if it does not end
    """
    done = subprocess.run(
        hosts.within(host, DOCTOR),
        env=hosts.environment_of(host),
        cwd=str(hosts.directory),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        timeout=60.0,
        universal_newlines=True,
    )
    lines = done.stdout.splitlines()
    found = [line.partition(" ")[2].strip() for line in lines if line.startswith("fault ")]
    if bool(found) is not bool(done.returncode) or not lines:
        raise RuntimeError(f"doctor ended with {done.returncode}: {lines[-3:]}")
    return found
