"""What another host can reach of nodes that were not meant to be reached."""

import re
import socket
import subprocess
import sys
from typing import Dict, List, Set

from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import WORKSPACE
from . import ssh_server
from .checks import Check, none_of, reported
from .hosts import ADDRESSES, Hosts

#: lets nobody in but by ssh; docs/security.md has the same line
FIREWALL = "iptables -I INPUT ! -i lo -p tcp --syn ! --dport 22 -j DROP"
LAUNCH = ["roslaunch", "basic_comms", "cw1.launch"]
_USER = re.compile(r'users:\(\("([^"]+)"')


def run(hosts: Hosts) -> List[Check]:
    """Try the main job from the other host, with each of the means of docs/security.md."""
    ssh_server.start(hosts)
    return bound_to_localhost(hosts) + in_a_network_of_its_own(hosts)


def bound_to_localhost(hosts: Hosts) -> List[Check]:
    """Start the main job as ci/exec does: for its own host alone."""
    launch = hosts.start("far", LAUNCH, for_itself(hosts))
    for program in ("process.py", "rosout"):
        wait_until(lambda: program in listening(hosts).values(), 60.0, program + " that listens")
    open_before = reachable(hosts, listening(hosts))
    hosts.run("far", FIREWALL.split())
    open_behind = reachable(hosts, listening(hosts))
    words = [str(WORKSPACE / "ci" / "exec"), "rostopic", "echo", "-n", "1", "/proc_signal"]
    through_ssh = heard(hosts, "near", ssh_server.command(hosts, *words))
    checks = [
        reported("listening there", ", ".join(sorted(set(listening(hosts).values())))),
        reported("of them reachable from here", ", ".join(sorted(set(open_before.values())))),
        none_of("reachable and neither sshd nor rosout", others(open_before, {"sshd", "rosout"})),
        none_of("reachable behind the firewall and not sshd", others(open_behind, {"sshd"})),
        none_of("rostopic echo through ssh fails", through_ssh),
    ]
    hosts.run("far", ["iptables", "-F"])
    hosts.stop(launch)
    return checks


def in_a_network_of_its_own(hosts: Hosts) -> List[Check]:
    """Start the main job in a network that has no way out, and join it from the same host."""
    alone = ["unshare", "--map-root-user", "--net"]
    command = "ip link set lo up && exec " + " ".join(LAUNCH)
    launch = hosts.start("far", [*alone, "sh", "-c", command], for_itself(hosts))
    join = ["nsenter", "--target", str(launch.pid), "--user", "--net", "--preserve-credentials"]
    echo = ["rostopic", "echo", "-n", "1", "/proc_signal"]
    wait_until(lambda: not heard(hosts, "far", join + echo), 60.0, "answer in its own network")
    checks = [
        none_of("own network: reachable and not sshd", others(listening(hosts), {"sshd"})),
        none_of(
            "own network: rostopic echo through nsenter fails", heard(hosts, "far", join + echo)
        ),
    ]
    hosts.stop(launch)
    return checks


def for_itself(hosts: Hosts) -> Dict[str, str]:
    """Return the far host's environment for nodes that only it can reach, as ci/exec has it."""
    environment = dict(
        hosts.environment("far"), ROS_MASTER_URI="http://localhost:11311", ROS_HOSTNAME="localhost"
    )
    del environment["ROS_IP"]
    return environment


def heard(hosts: Hosts, host: str, command: List[str]) -> List[str]:
    """Run rostopic echo.

    :returns: nothing if it prints a message, or else what is wrong
    """
    try:
        printed = hosts.run(host, command, for_itself(hosts) if host == "far" else None)
    except subprocess.SubprocessError as error:
        return [repr(error)]
    return [] if printed.startswith("data:") else [printed or "nothing received"]


def listening(hosts: Hosts) -> Dict[int, str]:
    """Return what listens on the far host: port and program."""
    found = {}
    for line in hosts.run("far", ["ss", "-Hltnp"]).splitlines():
        user = _USER.search(line)
        found[int(line.split()[3].rpartition(":")[2])] = user.group(1) if user else "unknown"
    return found


def reachable(hosts: Hosts, ports: Dict[int, str]) -> Dict[int, str]:
    """Return those ports that a connection from the near host comes through to."""
    script = f"from ci.endurance.run_closed import knock; knock({sorted(ports)!r})"
    environment = dict(hosts.environment("near"), PYTHONPATH=":".join(sys.path))
    answers = hosts.run("near", [sys.executable, "-c", script], environment).split()
    return {int(port): ports[int(port)] for port in answers}


def knock(ports: List[int]) -> None:
    """Print those ports of the far host that take a connection."""
    for port in ports:
        try:
            with socket.create_connection((ADDRESSES["far"], port), 1.0):
                print(port)
        except OSError:
            continue


def others(found: Dict[int, str], expected: Set[str]) -> List[str]:
    """Return the programs that are not among those expected."""
    return sorted(set(found.values()) - expected)
