"""Two hosts of one machine: network namespaces with a cable between them."""

import contextlib
import os
import pathlib
import signal
import subprocess
from typing import Callable, Dict, List, Optional

from ..benchmark.processes import start_with_log
from ..tiers.steps import end_leftovers
from .surroundings import logs

#: how long a process may take to end when asked to, s
PATIENCE_S = 10.0
#: addresses for documentation (RFC 5737); they exist in the namespaces alone
ADDRESSES = {"near": "192.0.2.1", "far": "192.0.2.2"}
DEVICE = "cable"


class Hosts:
    """The hosts near and far, and the processes on them; all end together.

    :param directory: for logs and files; a fresh one
    :param outage: how long the cable is to be pulled, s
    """

    def __init__(self, directory: pathlib.Path, outage: float) -> None:
        self.directory = directory
        self.outage = outage
        self._running: List["subprocess.Popen[bytes]"] = []
        #: called at the end
        self.undo: List[Callable[[], None]] = []
        self._names = {host: f"basic-comms-{os.getpid()}-{host}" for host in ADDRESSES}
        self._numbers = 0

    def __enter__(self) -> "Hosts":
        try:
            for name in self._names.values():
                ip("netns", "add", name)
                ip("-n", name, "link", "set", "lo", "up")
            near, far = self._names["near"], self._names["far"]
            cable = f"link add {DEVICE} type veth peer name {DEVICE} netns {far}"
            ip("-n", near, *cable.split())
            for host, name in self._names.items():
                ip("-n", name, "address", "add", ADDRESSES[host] + "/30", "dev", DEVICE)
            self.set_cable(True)
        except BaseException:
            self._end_all()
            raise
        return self

    def __exit__(self, *_error: object) -> None:
        self._end_all()

    def _end_all(self) -> None:
        for process in reversed(self._running[:]):
            self.stop(process)
        end_leftovers(self.directory)
        for name in self._names.values():
            # One that was not made yet cannot be deleted.
            subprocess.run(["ip", "netns", "delete", name], stderr=subprocess.DEVNULL)
        for undo in self.undo:
            undo()

    def set_cable(self, plugged: bool) -> None:
        """Plug the cable in or pull it, at both ends."""
        for name in self._names.values():
            ip("-n", name, "link", "set", DEVICE, "up" if plugged else "down")

    def within(self, host: str, command: List[str]) -> List[str]:
        """Return the command that runs a command on a host."""
        return ["ip", "netns", "exec", self._names[host], *command]

    def environment(self, host: str) -> Dict[str, str]:
        """Return the environment for nodes on a host that the other one can reach."""
        environment = dict(
            os.environ,
            ROS_IP=ADDRESSES[host],
            ROS_MASTER_URI=f"http://{ADDRESSES['near']}:11311",
            ROS_HOME=str(self.directory / "ros"),
            ROS_LOG_DIR=str(self.directory / "ros" / "log"),
            HOME=str(self.directory / host),
        )
        environment.pop("ROS_HOSTNAME", None)
        return environment

    def start(
        self, host: str, command: List[str], environment: Optional[Dict[str, str]] = None
    ) -> "subprocess.Popen[bytes]":
        """Start a process on a host; its output goes to a log in the directory.

        :param environment: in place of that of a node
        """
        self._numbers += 1
        log = self.directory / f"{self._numbers:03}-{pathlib.Path(command[0]).name}.log"
        variables = environment or self.environment(host)
        process = start_with_log(self.within(host, command), variables, log)
        self._running.append(process)
        return process

    def run(
        self, host: str, command: List[str], environment: Optional[Dict[str, str]] = None
    ) -> str:
        """Run a command on a host to its end, within a minute.

        :returns: what it wrote to its standard output
        :raises subprocess.SubprocessError: if it fails
        """
        result = subprocess.run(
            self.within(host, command),
            env=environment or self.environment(host),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            timeout=60.0,
            check=True,
        )
        return result.stdout.decode()

    def stop(self, process: "subprocess.Popen[bytes]") -> None:
        """End a process as Ctrl-C would, or the hard way if it takes too long."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            if process.poll() is None:
                os.killpg(process.pid, number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(PATIENCE_S)
        if process in self._running:
            self._running.remove(process)

    def logs(self) -> str:
        """Return all that was logged."""
        return "\n".join(logs(self.directory))


def ip(*arguments: str) -> None:
    """Change the network.

    :raises subprocess.CalledProcessError: if that fails
    """
    subprocess.run(["ip", *arguments], check=True)
