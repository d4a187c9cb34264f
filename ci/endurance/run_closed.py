"""What another host can reach of nodes that were not meant to be reached."""

import re
import socket
import subprocess
import sys
from typing import Dict, List, Set

import ssh_server
from checks import Check, none_of, told
from hosts import ADDRESSES, Hosts
from observers import wait_until
from peers import WORKSPACE

#: lets nobody in but by ssh; docs/security.md has the same line
FIREWALL = "iptables -I INPUT ! -i lo -p tcp --syn ! --dport 22 -j DROP"
_USER = re.compile(r'users:\(\("([^"]+)"')


def run(hosts: Hosts, _seconds: float) -> List[Check]:
    """Start the main job as ci/exec does, for this host alone, and try it from the other one."""
    ssh_server.start(hosts)
    environment = dict(
        hosts.environment("far"), ROS_MASTER_URI="http://localhost:11311", ROS_HOSTNAME="localhost"
    )
    del environment["ROS_IP"]
    hosts.start("far", ["roslaunch", "basic_comms", "cw1.launch"], environment)
    wait_until(lambda: "process.py" in listening(hosts).values(), 60.0, "node that listens")
    wait_until(lambda: "rosout" in listening(hosts).values(), 60.0, "rosout that listens")
    open_before = reachable(hosts, listening(hosts))
    hosts.run("far", FIREWALL.split())
    open_after = reachable(hosts, listening(hosts))
    expected = {"sshd", "rosout"}
    checks = [
        told("listening there", ", ".join(sorted(set(listening(hosts).values())))),
        told("of them reachable from here", ", ".join(sorted(set(open_before.values())))),
        none_of("reachable and neither sshd nor rosout", others(open_before, expected)),
        none_of("reachable behind the firewall and not sshd", others(open_after, {"sshd"})),
    ]
    words = [str(WORKSPACE / "ci" / "exec"), "rostopic", "echo", "-n", "1", "/proc_signal"]
    try:
        heard = hosts.run("near", ssh_server.command(hosts, *words)).split()
    except subprocess.SubprocessError as error:
        heard = [repr(error)]
    missing = [] if heard[:1] == ["data:"] else heard or ["nothing heard"]
    checks.append(none_of("rostopic echo through ssh fails", missing))
    return checks


def listening(hosts: Hosts) -> Dict[int, str]:
    """Return what listens on the far host: port and program."""
    found = {}
    for line in hosts.run("far", ["ss", "-Hltnp"]).splitlines():
        user = _USER.search(line)
        found[int(line.split()[3].rpartition(":")[2])] = user.group(1) if user else "unknown"
    return found


def reachable(hosts: Hosts, ports: Dict[int, str]) -> Dict[int, str]:
    """Return those ports that a connection from the near host comes through to."""
    script = "import run_closed; run_closed.knock(%r)" % sorted(ports)
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
