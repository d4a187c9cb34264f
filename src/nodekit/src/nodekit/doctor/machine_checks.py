"""Checks of this machine: its address, ports open to the network, ignored roslaunch arguments."""

import contextlib
import glob
import os
import pwd
import re
import socket
import struct
import threading
import xmlrpc.server
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple
from urllib.parse import urlsplit
from xml.etree import ElementTree

import rosgraph
import rosgraph.network
import rospkg

from nodekit.doctor.findings import Finding, fault, note, ok
from nodekit.doctor.graph_snapshot import Snapshot
from nodekit.master import MasterClient
from nodekit.process import launch_arguments, own_address

#: Longest wait for the master's call [s].
_CALL_S = 3.0
_LISTENING = "0A"


def check_address(environ: Mapping[str, str]) -> List[Finding]:
    """Check that this machine reaches itself under the address that its nodes announce.

    :param environ: variables of the environment
    """
    findings = []
    if environ.get("ROS_HOSTNAME") and environ.get("ROS_IP"):
        given = f"both set; ROS takes ROS_HOSTNAME '{environ['ROS_HOSTNAME']}'"
        findings.append(note("ROS_HOSTNAME, ROS_IP", given, "unset one of them"))
    try:
        own_address.check()
    except own_address.AddressError as error:
        given, _, advice = str(error).partition("; ")
        return [*findings, fault("own address", given, advice)]
    return [*findings, ok("own address", rosgraph.network.get_host_name())]


def check_master_reaches(master_uri: str) -> List[Finding]:
    """Check that the master can call nodes on this machine, by subscribing a test node.

    :param master_uri: URI of the master
    """
    name = f"/doctor_{os.getpid()}"
    called = threading.Event()
    host = rosgraph.network.get_host_name()
    bind_address = rosgraph.network.get_bind_address()
    family = socket.AF_INET6 if ":" in bind_address else socket.AF_INET

    class Server(xmlrpc.server.SimpleXMLRPCServer):
        address_family = family

    def update(_caller: object, topic: object, _publishers: object) -> Any:
        if topic == name:
            called.set()
        return 1, "", 0

    with Server((bind_address, 0), logRequests=False) as server:
        uri = f"http://{host}:{server.server_address[1]}/"
        server.register_function(update, "publisherUpdate")
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        master = MasterClient(name, uri, master_uri=master_uri)
        try:
            master.request([("registerSubscriber", name, "std_msgs/Empty", uri)])
            master.request([("registerPublisher", name, "std_msgs/Empty", uri)])
            reached = called.wait(_CALL_S)
        finally:
            master.request([("unregisterPublisher", name, uri)])
            master.request([("unregisterSubscriber", name, uri)])
            server.shutdown()
    if reached:
        return [ok("master's way back", f"it reaches this machine as {host}")]
    return [
        fault(
            "master's way back",
            f"the master cannot reach nodes on this machine at {uri}",
            "set ROS_IP to this machine's address in the master's network, and check its firewall",
        )
    ]


def owner_of_master(uri: str, pid: int) -> Optional[str]:
    """Return the name of the user that runs the master on this machine.

    :param uri: URI of the master
    :param pid: its process id, as reported by the master
    :returns: None for a master elsewhere, as in a container
    """
    if not rosgraph.network.is_local_address(urlsplit(uri).hostname or ""):
        return None
    with contextlib.suppress(OSError, KeyError):
        with open(f"/proc/{pid}/cmdline") as file:
            if "rosmaster" in file.read():
                return pwd.getpwuid(os.stat(f"/proc/{pid}").st_uid).pw_name
    return None


def check_launch_arguments() -> List[Finding]:
    """Report arguments that a roslaunch of this master ignores: no launch file declares them."""
    findings = []
    unreadable = (OSError, ValueError, ElementTree.ParseError, rospkg.ResourceNotFound)
    for pid, words in _processes():
        names = [os.path.basename(word) for word in words[:2]]
        if "roslaunch" not in names:
            continue
        given = words[names.index("roslaunch") + 1 :]
        with contextlib.suppress(*unreadable):
            if _master_of(pid, words) != rosgraph.get_master_uri().rstrip("/"):
                continue
            for problem in launch_arguments.ignored(given, os.readlink(f"/proc/{pid}/cwd")):
                subject = f"roslaunch (process {pid})"
                findings.append(fault(subject, problem, "correct or remove it"))
    return findings


def _master_of(pid: int, words: List[str]) -> str:
    """Return the URI of the master that a process uses.

    :param words: its command line
    """
    with open(f"/proc/{pid}/environ", encoding="utf-8", errors="replace") as file:
        entries = [entry.partition("=") for entry in file.read().split("\0")]
    environ = {name: value for name, _, value in entries}
    return str(rosgraph.get_master_uri(environ, words)).rstrip("/")


def _processes() -> Iterator[Tuple[int, List[str]]]:
    """Yield the process id and the command line of each process that this user may read."""
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            with open(path, errors="replace") as file:
                yield int(path.split("/")[2]), file.read().split("\0")[:-1]


def check_listening(graph: Snapshot, master_pid: Optional[int]) -> List[Finding]:
    """Report processes of the graph on this machine that listen to other machines.

    :param graph: the graph
    :param master_pid: process of the master, None if it is on another machine
    """
    pids = {
        node.pid: name
        for name, node in graph.nodes.items()
        if node.is_local and node.pid is not None
    }
    if master_pid is not None:
        pids[master_pid] = "the master"
    open_to_all, unreadable = [], []
    listening = _listening_sockets()
    for pid, name in sorted(pids.items(), key=lambda item: item[1]):
        try:
            ports = {listening[inode] for inode in _socket_inodes(pid) if inode in listening}
        except OSError:  # of another user, or in a container
            unreadable.append(name)
        else:
            open_to_all += [name] if ports else []
    findings = []
    if "/rosout" in open_to_all:  # written in C++, it follows no setting
        open_to_all.remove("/rosout")
        problem = "every machine in the network can connect to /rosout, whatever the settings"
        findings.append(note("ports", problem, "block its port with a firewall if that matters"))
    if open_to_all:
        names = ", ".join(open_to_all[:4]) + (" …" if len(open_to_all) > 4 else "")
        findings.append(
            note(
                "ports",
                f"every machine in the network can connect to {names}",
                "set ROS_HOSTNAME=localhost before the start if no other machine takes part",
            )
        )
    if unreadable:
        findings.append(
            note("ports", f"unknown for {', '.join(unreadable[:4])}: another user's process")
        )
    return findings or [ok("ports", "reached from this machine only")]


def _socket_inodes(pid: int) -> Iterator[int]:
    folder = f"/proc/{pid}/fd"
    for name in os.listdir(folder):
        with contextlib.suppress(OSError):  # closed meanwhile
            found = re.fullmatch(r"socket:\[(\d+)\]", os.readlink(f"{folder}/{name}"))
            if found:
                yield int(found[1])


def _listening_sockets() -> Dict[int, int]:
    """Return the ports of sockets that listen beyond the loopback device, by inode."""
    found = {}
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with contextlib.suppress(OSError):  # a kernel without IPv6
            with open(table) as file:
                for line in file.readlines()[1:]:
                    words = line.split()
                    address, _, port = words[1].partition(":")
                    if words[3] == _LISTENING and not _is_loopback(address):
                        found[int(words[9])] = int(port, 16)
    return found


def _is_loopback(address: str) -> bool:
    """Return whether an address of the kernel's table, words in its byte order, is loopback."""
    words = [int(address[start : start + 8], 16) for start in range(0, len(address), 8)]
    packed = b"".join(struct.pack("=I", word) for word in words)
    is_ipv4 = len(packed) == 4 or packed.startswith(bytes(10) + b"\xff\xff")
    return packed[-4] == 127 if is_ipv4 else packed == bytes(15) + b"\x01"
