"""What the figures depend on: the machine and its software."""

import os
import pathlib
import platform
import subprocess
from typing import Dict

PACKAGES = {"rospy": "python3-rospy", "roscpp": "libroscpp-dev", "topic_tools": "topic-tools"}


def describe() -> Dict[str, str]:
    """Return what is worth knowing, by name."""
    facts = {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2 ** 30:.0f} GB",
        "kernel": platform.release(),
        "system": _system(),
        "python": platform.python_version(),
        "load before": f"{os.getloadavg()[0]:.2f}",
    }
    facts.update((name, _version(package)) for name, package in PACKAGES.items())
    return facts


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
    result = subprocess.run(
        ["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True
    )
    return result.stdout or "not from a package"
