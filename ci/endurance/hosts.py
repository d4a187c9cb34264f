"""Two hosts on one machine: network namespaces with a cable between them."""

import os
import pathlib
import subprocess
from typing import Callable, Dict, List, Optional

from ..benchmark.processes import Processes

#: Addresses for documentation (RFC 5737); they exist in the namespaces alone.
ADDRESSES = {"near": "192.0.2.1", "far": "192.0.2.2"}
DEVICE = "cable"


class Hosts(Processes):
    """The hosts near and far, and the processes on them; all end together.

    :param directory: an empty directory for logs and files
    :param outage: how long the cable is pulled [s]

    :ivar undo: functions called at the end
    """

    def __init__(self, directory: pathlib.Path, outage: float) -> None:
        super().__init__(directory)
        self.outage = outage
        self.undo: List[Callable[[], None]] = []
        self._names = {host: f"basic-comms-{os.getpid()}-{host}" for host in ADDRESSES}

    def prepare(self) -> None:
        """Create the hosts, and plug in the cable."""
        for name in self._names.values():
            ip("netns", "add", name)
            ip("-n", name, "link", "set", "lo", "up")
        near, far = self._names["near"], self._names["far"]
        cable = f"link add {DEVICE} type veth peer name {DEVICE} netns {far}"
        ip("-n", near, *cable.split())
        for host, name in self._names.items():
            ip("-n", name, "address", "add", ADDRESSES[host] + "/30", "dev", DEVICE)
        self.set_cable(True)

    def end_all(self) -> None:
        """End all processes, and remove the hosts."""
        super().end_all()
        for name in self._names.values():
            # Fails for a namespace that was not created yet.
            subprocess.run(["ip", "netns", "delete", name], stderr=subprocess.DEVNULL)
        for undo in self.undo:
            undo()

    def set_cable(self, is_plugged: bool) -> None:
        """Plug the cable in or pull it, at both ends."""
        for name in self._names.values():
            ip("-n", name, "link", "set", DEVICE, "up" if is_plugged else "down")

    def within(self, host: str, command: List[str]) -> List[str]:
        """Return the command that runs a command on a host."""
        return ["ip", "netns", "exec", self._names[host], *command]

    def environment_of(self, host: str) -> Dict[str, str]:
        """Return the environment for nodes on a host that the other one can reach."""
        environment = dict(
            self.environment,
            ROS_IP=ADDRESSES[host],
            ROS_MASTER_URI=f"http://{ADDRESSES['near']}:11311",
            HOME=str(self.directory / host),
        )
        environment.pop("ROS_HOSTNAME", None)
        return environment

    def start_on(
        self, host: str, command: List[str], environment: Optional[Dict[str, str]] = None
    ) -> "subprocess.Popen[bytes]":
        """Start a process on a host.

        :param environment: in place of a node's environment
        """
        return self.start(self.within(host, command), environment or self.environment_of(host))

    def run_on(
        self, host: str, command: List[str], environment: Optional[Dict[str, str]] = None
    ) -> str:
        """Run a command on a host to its end, within a minute.

        :returns: its standard output
        :raises subprocess.SubprocessError: if it fails
        """
        result = subprocess.run(
            self.within(host, command),
            env=environment or self.environment_of(host),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            timeout=60.0,
            check=True,
        )
        return result.stdout.decode()

    def nodes(self) -> str:
        """Return the names of all nodes; empty without a master."""
        try:
            return self.run_on("near", ["rosnode", "list"])
        except subprocess.SubprocessError:
            return ""


def ip(*arguments: str) -> None:
    """Change the network.

    :raises subprocess.CalledProcessError: if that fails
    """
    subprocess.run(["ip", *arguments], check=True)
