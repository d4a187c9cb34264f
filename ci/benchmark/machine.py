"""Description of the machine and its software, on which the figures depend."""

import datetime
import os
import pathlib
import platform
from typing import Dict, Tuple

#: Largest share of processor time that the host may take from a virtual machine in a turn.
STOLEN = 0.02


def describe() -> Dict[str, str]:
    """Return the facts by name."""
    return {
        "date": datetime.date.today().isoformat(),
        "processor": _field("/proc/cpuinfo", "model name", ":") or platform.machine(),
        "cores": str(os.cpu_count()),
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GB",
        "kernel": platform.release(),
        "system": _field("/etc/os-release", "PRETTY_NAME", "=") or platform.system(),
        "python": platform.python_version(),
        "load before": f"{os.getloadavg()[0]:.2f}",
    }


def is_busy() -> bool:
    """Return whether other programs would affect the figures."""
    return os.getloadavg()[0] > 0.5


class Steal:
    """The share of the processors' time that the host takes from a virtual machine, see proc(5)."""

    def __init__(self) -> None:
        self._stolen, self._all = _times()

    def share(self) -> float:
        """Return the share since this object was created."""
        stolen, whole = _times()
        return (stolen - self._stolen) / max(whole - self._all, 1)


def _times() -> Tuple[int, int]:
    """Return the stolen time and the total since the start of the machine [ticks]."""
    fields = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]
    times = [int(field) for field in fields]  # later fields are parts of these
    return times[7], sum(times)


def _field(file: str, name: str, separator: str) -> str:
    for line in pathlib.Path(file).read_text().splitlines():
        if line.startswith(name):
            return line.partition(separator)[2].strip(' "')
    return ""
