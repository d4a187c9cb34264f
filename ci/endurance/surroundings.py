"""What every run is given, and what runs have in common."""

import pathlib
import subprocess
from typing import List, NamedTuple

from ..benchmark.peer_programs import WORKSPACE
from ..benchmark.processes import Session

EXECUTABLES = WORKSPACE / "devel" / "lib" / "basic_comms"


class Soak(NamedTuple):
    """The surroundings of a run."""

    session: Session
    #: how long the recording takes, s
    seconds: float
    #: how often nodes are killed or interrupted; 0 for as often as each run does by itself
    times: int
    #: seed of everything random
    seed: int

    def start(self, executable: str, *arguments: str) -> "subprocess.Popen[bytes]":
        """Start one of the nodes of basic_comms.

        :param arguments: parameters and remappings
        """
        return self.session.start([str(EXECUTABLES / executable), *arguments])


def logs(directory: pathlib.Path) -> List[str]:
    """Return the text of all logs below a directory."""
    return [
        path.read_text(errors="replace")
        for path in sorted(directory.rglob("*.log"))
        if not path.is_symlink() and "latest" not in path.parts
    ]
