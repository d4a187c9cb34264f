"""Launch files started by a test, on the test's own master."""

import os
import shlex
from contextlib import contextmanager
from typing import Dict, Iterator, NamedTuple, Sequence, Set, Tuple

import rospkg
from roslaunch.parent import ROSLaunchParent

from nodekit.testing.graph import Graph
from nodekit.testing.waiting import wait_until


def launch_file(package: str, name: str) -> str:
    """Return the path of a launch file.

    :param package: package of the launch file
    :param name: path in its folder launch, e.g. ``features/remap.launch``
    :raises rospkg.ResourceNotFound: if the package does not exist
    """
    return os.path.join(rospkg.RosPack().get_path(package), "launch", name)


class Process(NamedTuple):
    """Process of a node at one moment.

    :param program: its program, e.g. talker.py; a launch-prefix until it has become the node (exec)
    :param pid: process id
    """

    program: str
    pid: int


class Launched:
    """Running launch files, and the part of the graph that they have added."""

    def __init__(self, parent: ROSLaunchParent, graph: Graph) -> None:
        self._parent = parent
        self.graph = graph

    def nodes(self) -> Set[str]:
        """Return the names of the nodes that the files start."""
        config = self._parent.config  # None until the files have been read
        return {node.namespace + node.name for node in config.nodes} if config else set()

    def owns_parameter(self, name: str) -> bool:
        """Return whether a parameter is set by the files, or private to one of their nodes."""
        config = self._parent.config
        private = any(name.startswith(node + "/") for node in self.nodes())
        return private or (config is not None and name in config.params)

    def wait_until_up(self) -> None:
        """Wait until all nodes have finished init_node."""
        wait_until(
            lambda: self.graph.initialised(*self.nodes()),
            lambda: f"missing: {sorted(self.nodes() - self.graph.nodes())}",
        )

    def ended(self) -> bool:
        """Return whether roslaunch has ended the launch by itself."""
        return bool(self._parent.pm.is_shutdown)

    def processes(self) -> Dict[str, Process]:
        """Return the running processes by the names of their nodes."""
        processes = {}
        for process in list(self._parent.pm.procs):
            try:
                with open(f"/proc/{process.pid}/cmdline") as line:
                    words = [os.path.basename(word) for word in line.read().split("\0")]
            except OSError:
                continue  # just ended
            script = words[0].startswith("python") and len(words) > 1
            node = "/" + process.name.rpartition("-")[0]
            processes[node] = Process(words[1] if script else words[0], process.pid)
        return processes

    def wait_for_new_process(self, node: str, old: Process) -> None:
        """Wait until a node has a new process."""
        wait_until(
            lambda: self.processes().get(node, old).pid != old.pid,
            lambda: f"the processes are {self.processes()}",
        )

    def machines(self) -> Dict[str, str]:
        """Return the name of the machine of each node; empty for local ones."""
        return {node.namespace + node.name: node.machine.name for node in self._parent.config.nodes}


@contextmanager
def launched(*commands: str) -> Iterator[Launched]:
    """Start launch files as roslaunch does; on exit, end their nodes and delete their parameters.

    Starting several together takes little longer than one; ``__ns:=`` keeps their nodes apart.

    :param commands: arguments of ``roslaunch``: ``basic_comms cw1.launch ns:=a``, or
        a path and arguments
    """
    graph = Graph()
    parameters = graph.parameters()
    run_id = graph.parameter("/run_id")
    files = [_file_and_arguments(*shlex.split(command)) for command in commands]
    parent = ROSLaunchParent(run_id, files, show_summary=False)
    launch = Launched(parent, graph)
    try:
        parent.start(auto_terminate=False)
        yield launch
    finally:
        parent.shutdown()
        wait_until(
            lambda: not launch.nodes() & graph.nodes(),
            lambda: f"still there: {sorted(launch.nodes() & graph.nodes())}",
        )
        for name in graph.parameters() - parameters:
            if launch.owns_parameter(name):
                graph.delete_parameter(name)


def _file_and_arguments(first: str, *rest: str) -> Tuple[str, Sequence[str]]:
    if os.path.isfile(first):
        return first, rest
    return launch_file(first, rest[0]), rest[1:]
