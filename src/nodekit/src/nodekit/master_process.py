"""Process of a ROS master on a free port of this machine."""

import contextlib
import errno
import random
import socket
import subprocess
import time
from typing import Any, List, Optional
from xmlrpc.client import ServerProxy

#: Longest wait for the master's response or end [s], long enough for a busy machine.
_LIMIT_S = 30.0
#: Pause between two requests to a master that starts [s].
_PAUSE_S = 0.02
#: Ports below Linux's ip_local_port_range, whose ports another process could get at any time, and
#: above those of ROS: 11311 of the master, and 11411, where rosserial listens for boards.
_PORTS = range(12_000, 32_768)
#: Not the module's generator, which all tests seed alike.
_random = random.SystemRandom()


def free_ports(count: int) -> List[int]:
    """Return different free TCP ports of localhost.

    :param count: number of ports
    """
    ports: List[int] = []
    with contextlib.ExitStack() as probes:
        while len(ports) < count:
            probe, port = probes.enter_context(socket.socket()), _random.choice(_PORTS)
            try:
                probe.bind(("localhost", port))
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    raise
            else:
                ports.append(port)
    return ports


class MasterProcess:
    """Master that can be killed and started again; a restart loses its parameters.

    :param start_new_session: whether it does not receive Ctrl-C of the terminal
    :raises TimeoutError: if it does not respond

    :ivar uri: its URI
    :ivar process: its process
    """

    def __init__(self, start_new_session: bool = False) -> None:
        self._start_new_session = start_new_session
        self._start_at_free_port()
        while self.responding_pid() != self.process.pid:  # another process has taken the port
            self.kill()
            self._start_at_free_port()

    def _start_at_free_port(self) -> None:
        self._port = free_ports(1)[0]
        self.uri = f"http://localhost:{self._port}/"
        self.start()

    def start(self) -> None:
        """Start the master, and wait until it responds.

        :raises TimeoutError: if it does not respond
        """
        self.process = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self._port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=self._start_new_session,
        )
        try:
            deadline = time.monotonic() + _LIMIT_S
            while not self.responding_pid():
                if time.monotonic() > deadline:
                    raise TimeoutError(f"the master at {self.uri} does not respond")
                time.sleep(_PAUSE_S)
        except BaseException:
            self.kill()
            raise

    def kill(self) -> None:
        """Kill the master."""
        self.process.kill()
        self.process.wait(_LIMIT_S)

    def responding_pid(self) -> Optional[int]:
        """Return the process id of the master that responds at the URI, None without one."""
        try:
            with ServerProxy(self.uri) as proxy:
                answer: Any = proxy.getPid("/master_process")
                return int(answer[2])
        except OSError:
            return None
