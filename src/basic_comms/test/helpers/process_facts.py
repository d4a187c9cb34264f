"""Kernel's figures of a process: memory, threads, descriptors and listening sockets."""

import os
import socket
import struct
from typing import NamedTuple, Set, Tuple

_LISTENING = "0A"


class Usage(NamedTuple):
    """Resources that a process holds at a moment.

    :param threads: how many
    :param descriptors: how many are open
    :param memory: resident set, bytes
    """

    threads: int
    descriptors: int
    memory: int


def usage(pid: int) -> Usage:
    """Return the resources of a process.

    :raises OSError: if there is no such process
    """
    with open(f"/proc/{pid}/statm") as statm:
        pages = int(statm.read().split()[1])
    return Usage(
        threads=len(os.listdir(f"/proc/{pid}/task")),
        descriptors=len(os.listdir(f"/proc/{pid}/fd")),
        memory=pages * os.sysconf("SC_PAGE_SIZE"),
    )


def listening(pid: int) -> Set[Tuple[str, int]]:
    """Return address and port of each TCP socket on which a process listens.

    :raises OSError: if there is no such process
    """
    mine = {_link(f"/proc/{pid}/fd/{name}") for name in os.listdir(f"/proc/{pid}/fd")}
    found = set()
    for table in ("tcp", "tcp6"):
        with open(f"/proc/{pid}/net/{table}") as lines:
            for words in map(str.split, lines.readlines()[1:]):
                if words[3] == _LISTENING and f"socket:[{words[9]}]" in mine:
                    address, _, port = words[1].partition(":")
                    found.add((_readable(address), int(port, 16)))
    return found


def _link(path: str) -> str:
    try:
        return os.readlink(path)
    except OSError:
        return ""  # closed meanwhile


def _readable(address: str) -> str:
    """Turn an address of /proc/net, 32 bit words in the machine's order, into the usual form."""
    words = [int(address[start : start + 8], 16) for start in range(0, len(address), 8)]
    packed = struct.pack(f"={len(words)}I", *words)
    return socket.inet_ntop(socket.AF_INET if len(words) == 1 else socket.AF_INET6, packed)
