"""Type what a page of the documentation shows without its output, in blocks of the language sh.

A line is right when it ends with status 0 and names no error. What the page itself calls refused
(``# refused``) has to be. Nodes and launch files go on: they have to come up, and to end at Ctrl-C.
One of them runs at a time, until the page has the next or ends; rostopic and the oscilloscope go on
beside it.
"""

import os
import re
import shlex
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Set, Type
from xml.etree import ElementTree

import rospy
import yaml
from job import Job
from master import PrivateMaster
from pages import WORKSPACE, environment_of_reader
from reader import PageError
from warm_python import WarmPython

from nodekit.testing.graph import Graph
from nodekit.testing.launching import launch_file
from nodekit.testing.processes import free_port
from nodekit.testing.waiting import wait_until
from nodekit_msgs.srv import SetParameters

_FENCE = re.compile(r"^ *```(\S*)")
_REFUSED = "# refused"
_LAUNCHES = re.compile(
    r"(\./ci/exec )?(roslaunch (?!-)|rosrun nodekit host|rosrun \w+ (?!scope|plot_bag|mask)\w+\.py"
    r"|rosrun (diff_drive_sim|executors_demo|lifecycle_demo|motor_control|my_robot_package"
    r"|parameters_demo|robot_interfaces_demo) (?!timeline|fleet_report)\w+)"
)
_GOES_ON_BESIDE = re.compile(r"rostopic (echo|pub)|rosrun topic_scope scope|roslaunch topic_scope")
_NODE_OF_LAUNCH = re.compile(r"^ +\S+ \(\w+/\S+\)$", re.MULTILINE)
_ARGUMENTS = re.compile(r"roslaunch (\w+) (\w+\.launch)(.*)")
_ERROR = re.compile(r"^.*(?:ERROR|FATAL|Traceback|success: False|not used).*$", re.MULTILINE)
# In logs there is also what rospy says to itself.
_LOGGED_ERROR = re.compile(
    r"^(?:.*\[rosout\]\[(?:(?:ERROR|FATAL)\]|.*not used)|Traceback).*$", re.MULTILINE
)
#: How much of a log is shown where something is wrong with it.
_LINES_OF_A_TRACEBACK = 40


class Line(NamedTuple):
    """A command on a page.

    :param number: of the line
    :param command: what stands there, with its comment
    """

    number: int
    command: str


def lines_of(page: str, language: str = "sh") -> List[Line]:
    """List the lines of all blocks of a language.

    :param page: the text of the page, Markdown
    """
    lines: List[Line] = []
    inside: Optional[str] = None
    for number, line in enumerate(page.splitlines(), 1):
        fence = _FENCE.match(line)
        if fence:
            inside = fence.group(1) if inside is None else None
        elif inside == language and line.strip():
            lines.append(Line(number, line.strip()))
    return lines


class Typist:
    """Types commands on a master of its own, in a home directory of its own.

    The master becomes that of this process, so a process has one typist at a time.

    :param python: runs the commands that are Python programs
    :param timeout: how long one command may take to do what it shall, s
    """

    def __init__(self, python: WarmPython, timeout: float = 100.0) -> None:
        self._python = python
        #: How long to wait, as above.
        self.timeout = timeout
        self._master = PrivateMaster(python)
        os.environ["ROS_MASTER_URI"] = self._master.uri
        self._graph = Graph()
        self._folder = tempfile.TemporaryDirectory()
        self._home = Path(self._folder.name)
        (self._home / "ci").symlink_to(WORKSPACE / "ci")
        self._environment = environment_of_reader(
            BROWSER="true",  # opens nothing
            HOME=self._folder.name,
            ROS_LOG_DIR=str(self._home / "log"),
            TERM="dumb",
        )
        self._launched: List[Job] = []
        self._beside: List[Job] = []
        self._count = 0

    def __enter__(self) -> "Typist":
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        try:
            self._end(self._beside + self._launched, must=error is None)
            if error is None:
                self._wait(lambda: not self._left(), lambda: f"{self._left()} stay")
                self._look_into_logs()
        finally:
            self._master.end()
            self._folder.cleanup()

    def type(self, command: str) -> None:
        """Type a command, and wait until it has ended or, if it goes on, does what it is for.

        :param command: a line of the page
        :raises AssertionError: if it does not do that
        """
        if _GOES_ON_BESIDE.match(command):
            self._beside.append(self._come_up(command))
        elif _LAUNCHES.match(command):
            self._end(self._launched)
            self._launched = []
            self._launched = [self._come_up(command)]
        else:
            self._run(command)
            if command.startswith("rosparam set"):
                self.check_parameter(command)

    def check_parameter(self, command: str) -> None:
        """Wait until a node follows what rosparam has set or, where that is said, refuses it.

        :param command: the line, which has been typed
        :raises AssertionError: if neither comes
        """
        name, text = shlex.split(command, comments=True)[2:]
        value = yaml.safe_load(text)
        node, _, leaf = (name, "", "") if isinstance(value, dict) else name.rpartition("/")
        wanted = value if isinstance(value, dict) else {leaf: value}

        def is_in_force() -> bool:
            in_force = self._values(node)
            there = {key: self._graph.parameter(f"{node}/{key}") for key in wanted}
            used = {key: in_force.get(key) for key in wanted}
            return there == used and (used == wanted) != (_REFUSED in command)

        self._wait(is_in_force, lambda: f"in force is {self._values(node)}")

    def _run(self, command: str) -> None:
        """Run a command that ends."""
        if command.startswith("rosservice call"):  # a node offers it after the end of init_node
            rospy.wait_for_service(command.split()[2], self.timeout)
        refused = _REFUSED in command and not command.startswith("rosparam")
        job = self._start(command, goes_on=False)
        if not job.ended_by(time.monotonic() + self.timeout):
            job.kill()
            raise PageError(f"it does not end:\n{job.output()}")
        if bool(job.status) != refused or _ERROR.search(job.output()):
            raise PageError(f"status {job.status}:\n{job.output()}")

    def _values(self, node: str) -> Dict[str, Any]:
        change = f"{node}/change"
        try:
            # A node that has come to the end of init_node has yet to offer it.
            rospy.wait_for_service(change, self.timeout)
            answer = rospy.ServiceProxy(change, SetParameters)("{}")
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise PageError(f"no node follows it: {error}") from error
        values: Dict[str, Any] = yaml.safe_load(answer.values)
        return values

    def _come_up(self, command: str) -> Job:
        """Start a command that goes on."""
        _look_at_arguments(command)
        graph = Graph()
        job = self._start(command, goes_on=True)
        words = shlex.split(command, comments=True)

        def up() -> bool:
            if job.status is not None:
                raise PageError(f"it has ended with status {job.status}:\n{job.output()}")
            if words[:2] == ["rostopic", "echo"]:
                return "\n---\n" in job.output()
            if words[:2] == ["rostopic", "pub"]:  # its type is right if a subscriber receives it
                return any(
                    graph.connected_subscribers(node, words[2])
                    for node in graph.publishers(words[2])
                )
            expected = 1 if "rosrun" in words else len(_NODE_OF_LAUNCH.findall(job.output()))
            nodes = graph.nodes()
            return 0 < expected <= len(nodes) and graph.initialised(*nodes)

        try:
            self._wait(up, lambda: f"it does not come up:\n{job.output()}")
        except BaseException:
            self._end([job], must=False)
            raise
        return job

    def _end(self, jobs: List[Job], must: bool = True) -> None:
        """Press Ctrl-C in the terminals of some jobs.

        :param must: complain where one has ended by itself, does not end, or told of an error
        """
        deadline = time.monotonic() + self.timeout
        running = [job for job in jobs if job.status is None]
        for job in running:
            job.interrupt()
        for job in jobs:
            ended = job.ended_by(deadline)
            job.kill()
            fine = job in running and ended and job.status == 0 and not _ERROR.search(job.output())
            if must and not fine:
                raise PageError(f"Ctrl-C: status {job.status}:\n{job.output()}")

    def _left(self) -> Set[str]:
        """Return which nodes are registered; of rostopic, Ctrl-C may break off rospy's own end."""
        return {name for name in self._graph.nodes() if not name.startswith("/rostopic_")}

    def _look_into_logs(self) -> None:
        for path in self._home.glob("log/**/*.log"):
            text = path.read_text(errors="replace")
            found = _LOGGED_ERROR.search(text)
            if found:
                rest = text[found.start() :].splitlines()[:_LINES_OF_A_TRACEBACK]
                raise PageError("\n".join([f"{path.name} has:", *rest]))

    def _wait(self, condition: Callable[[], bool], what: Callable[[], str]) -> None:
        wait_until(condition, what, self.timeout)

    def _start(self, command: str, goes_on: bool) -> Job:
        line, hash_, comment = command.partition(" #")
        if "topic_scope scope." in line:  # the user may have another one open
            port = free_port()
            line += f" port:={port}" if line.startswith("roslaunch") else f" --port {port}"
        self._count += 1
        output = self._home / f"output{self._count}"
        return Job(
            line + hash_ + comment, self._home, self._environment, output, goes_on, self._python
        )


def _look_at_arguments(command: str) -> None:
    """Refuse arguments that a launch file does not have: roslaunch takes them in silence."""
    found = _ARGUMENTS.search(command)
    if found and ":=" in found.group(3):
        package, name, typed = found.groups()
        known = ElementTree.parse(launch_file(package, name)).getroot().iter("arg")
        wrong = set(re.findall(r"(\w+):=", typed)) - {str(arg.get("name")) for arg in known}
        if wrong:
            raise PageError(f"{name} has no argument {', '.join(sorted(wrong))}")
