"""What the figures depend on: the machine and its software."""

import os
import pathlib
import platform
import subprocess
from typing import Dict, Tuple

#: The share of the processors' time that the host may take from a virtual machine in a turn.
STOLEN = 0.02

PACKAGES = {"rospy": "python3-rospy", "roscpp": "libroscpp-dev", "topic_tools": "topic-tools"}


def describe() -> Dict[str, str]:
    """Return what is worth knowing, by name."""
    facts = {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GB",
        "kernel": platform.release(),
        "system": _system(),
        "python": platform.python_version(),
        "load before": load(),
    }
    facts.update((name, _version(package)) for name, package in PACKAGES.items())
    return facts


def load() -> str:
    """How many threads were running or waiting to run in the last minute, on average."""
    return f"{os.getloadavg()[0]:.2f}"


class Steal:
    """How much of the processors' time the host takes while something is measured.

    See proc(5): a virtual machine is told of it; elsewhere it is 0.
    """

    def __init__(self) -> None:
        self._stolen, self._all = _times()

    def share(self) -> float:
        """Return the share since this was made."""
        stolen, whole = _times()
        return (stolen - self._stolen) / max(whole - self._all, 1)


def _times() -> Tuple[int, int]:
    """Return the time that was stolen, and all of it, since the machine started, in ticks."""
    fields = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]
    times = [int(field) for field in fields]  # what follows is a part of these
    return times[7], sum(times)


def is_busy() -> bool:
    """Tell whether something else runs that would show in the figures."""
    return os.getloadavg()[0] > 0.5


def _processor() -> str:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def _system() -> str:
    for line in pathlib.Path("/etc/os-release").read_text().splitlines():
        if line.startswith("PRETTY_NAME="):
            return line.partition("=")[2].strip('"')
    return platform.system()


def _version(package: str) -> str:
    command = ["dpkg-query", "-W", "-f=${Version}", package]
    try:
        version = subprocess.run(command, capture_output=True, text=True).stdout
    except OSError:  # no Debian
        version = ""
    return version or "not from a package"
