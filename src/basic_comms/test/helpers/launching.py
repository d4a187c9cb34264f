"""Start launch files from within a test, on the test's own master."""

import os
from contextlib import contextmanager
from typing import Dict, Iterator

import rosgraph
import rospkg
from roslaunch.parent import ROSLaunchParent

from helpers.graph import Graph
from helpers.waiting import wait_until


def launch_file(name: str) -> str:
    """Return the path of a launch file of basic_comms, e.g. features/remap.launch."""
    return os.path.join(rospkg.RosPack().get_path("basic_comms"), "launch", name)


class Launched:
    """A launch file that is running, and the part of the graph that came with it."""

    def __init__(self, parent: ROSLaunchParent, graph: Graph) -> None:
        self._parent = parent
        self.graph = graph

    def ended(self) -> bool:
        """Return whether roslaunch has ended the launch by itself."""
        return bool(self._parent.pm.is_shutdown)

    def processes(self) -> Dict[str, int]:
        """Return the process ids by the program that each process runs at this moment.

        A launch-prefix is the program until it has become the node (exec).
        """
        programs = {}
        for process in list(self._parent.pm.procs):
            try:
                with open("/proc/%d/cmdline" % process.pid) as line:
                    words = [os.path.basename(word) for word in line.read().split("\0")]
            except OSError:
                continue  # it has just ended
            script = words[0].startswith("python") and len(words) > 1
            programs[words[1] if script else words[0]] = process.pid
        return programs

    def wait_for_new_process(self, program: str, pid: int) -> None:
        """Wait until a program runs with another process id than this one."""
        wait_until(
            lambda: self.processes().get(program, pid) != pid,
            lambda: "the processes are %s" % self.processes(),
        )

    def machines(self) -> Dict[str, str]:
        """Return the name of the machine of each node; local ones need none."""
        return {node.namespace + node.name: node.machine.name for node in self._parent.config.nodes}


@contextmanager
def launched(path: str, *arguments: str) -> Iterator[Launched]:
    """Start a launch file as roslaunch does; on exit, end its nodes and delete its parameters.

    :param path: path of the file
    :param arguments: as on the command line, e.g. ``"rate:=5"``
    """
    graph = Graph()
    parameters = graph.parameters()
    run_id = rosgraph.Master("/launched").getParam("/run_id")
    parent = ROSLaunchParent(run_id, [(path, list(arguments))], show_summary=False)
    parent.start(auto_terminate=False)
    try:
        yield Launched(parent, graph)
    finally:
        graph.wait_until_settled()
        parent.shutdown()
        wait_until(lambda: not graph.nodes(), lambda: "still there: %s" % sorted(graph.nodes()))
        for name in graph.parameters() - parameters:
            graph.delete_parameter(name)
