"""Try from another host to reach nodes that it should not reach."""

import re
import socket
import subprocess
import sys
from typing import Dict, List, Set

from ..benchmark.peer_programs import WORKSPACE
from ..benchmark.recorder import wait_until
from . import ssh_server
from .checks import Check, none_of, reported
from .hosts import ADDRESSES, Hosts

#: Admits only ssh; docs/security.md has the same line.
FIREWALL = "iptables -I INPUT ! -i lo -p tcp --syn ! --dport 22 -j DROP"
LAUNCH = ["roslaunch", "basic_comms", "cw1.launch"]
ECHO = ["rostopic", "echo", "-n", "1", "/proc_signal"]
_USER = re.compile(r'users:\(\("([^"]+)"')


def run(hosts: Hosts) -> List[Check]:
    """Try to reach the main job from the other host, with each protection of docs/security.md."""
    ssh_server.start(hosts)
    return bound_to_localhost(hosts) + in_own_network(hosts)


def bound_to_localhost(hosts: Hosts) -> List[Check]:
    """Start the main job as ci/exec does: for its own host only."""
    launch = hosts.start_on("far", LAUNCH, local_environment(hosts))
    for program in ("process.py", "rosout"):
        wait_until(lambda: program in listening(hosts).values(), 60.0, program + " that listens")
    open_before = reachable(hosts, listening(hosts))
    hosts.run_on("far", FIREWALL.split())
    open_behind = reachable(hosts, listening(hosts))
    through_ssh = ssh_server.command(hosts, str(WORKSPACE / "ci" / "exec"), *ECHO)
    checks = [
        reported("listening there", ", ".join(sorted(set(listening(hosts).values())))),
        reported("of them reachable from here", ", ".join(sorted(set(open_before.values())))),
        none_of("reachable and neither sshd nor rosout", others(open_before, {"sshd", "rosout"})),
        none_of("reachable behind the firewall and not sshd", others(open_behind, {"sshd"})),
        none_of("rostopic echo through ssh fails", failures(hosts, "near", through_ssh)),
    ]
    hosts.run_on("far", ["iptables", "-F"])
    hosts.stop(launch)
    return checks


def in_own_network(hosts: Hosts) -> List[Check]:
    """Start the main job in a network without a way out, and join it from the same host."""
    alone = ["unshare", "--map-root-user", "--net"]
    command = "ip link set lo up && exec " + " ".join(LAUNCH)
    launch = hosts.start_on("far", [*alone, "sh", "-c", command], local_environment(hosts))
    join = ["nsenter", "--target", str(launch.pid), "--user", "--net", "--preserve-credentials"]
    wait_until(lambda: not failures(hosts, "far", join + ECHO), 60.0, "answer in its own network")
    found = failures(hosts, "far", join + ECHO)
    checks = [
        none_of("own network: reachable and not sshd", others(listening(hosts), {"sshd"})),
        none_of("own network: rostopic echo through nsenter fails", found),
    ]
    hosts.stop(launch)
    return checks


def local_environment(hosts: Hosts) -> Dict[str, str]:
    """Return the far host's environment for nodes reachable only there, as in ci/exec."""
    environment = hosts.environment_of("far")
    del environment["ROS_IP"]
    return {**environment, "ROS_MASTER_URI": "http://localhost:11311", "ROS_HOSTNAME": "localhost"}


def failures(hosts: Hosts, host: str, command: List[str]) -> List[str]:
    """Run rostopic echo, and return the errors; empty if it prints a message."""
    environment = local_environment(hosts) if host == "far" else None
    try:
        printed = hosts.run_on(host, command, environment)
    except subprocess.SubprocessError as error:
        return [repr(error)]
    return [] if printed.startswith("data:") else [printed or "nothing received"]


def listening(hosts: Hosts) -> Dict[int, str]:
    """Return the programs that listen on the far host, by port."""
    found = {}
    for line in hosts.run_on("far", ["ss", "-Hltnp"]).splitlines():
        user = _USER.search(line)
        found[int(line.split()[3].rpartition(":")[2])] = user.group(1) if user else "unknown"
    return found


def reachable(hosts: Hosts, ports: Dict[int, str]) -> Dict[int, str]:
    """Return the ports that accept a connection from the near host."""
    script = f"from ci.endurance.run_closed import knock; knock({sorted(ports)!r})"
    environment = dict(hosts.environment_of("near"), PYTHONPATH=":".join(sys.path))
    answers = hosts.run_on("near", [sys.executable, "-c", script], environment).split()
    return {int(port): ports[int(port)] for port in answers}


def knock(ports: List[int]) -> None:
    """Print the ports of the far host that accept a connection."""
    for port in ports:
        try:
            with socket.create_connection((ADDRESSES["far"], port), 1.0):
                print(port)
        except OSError:
            continue


def others(found: Dict[int, str], expected: Set[str]) -> List[str]:
    """Return the programs that are not expected."""
    return sorted(set(found.values()) - expected)
