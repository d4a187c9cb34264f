"""Run the image, and compose.yaml, by the commands of docs/container.md.

``python3 ci packages.container_proof TOOL COMPOSE``, with the page's commands on its standard
input, says what it has seen, and ends with a status other than 0 at the first thing that is not as
it should.
"""

import contextlib
import json
import os
import re
import shlex
import socket
import subprocess
import sys
import tempfile
import time
from typing import Any, Dict, Iterator, List

from .proof import PATIENCE, answers, said, wait_for

IMAGE = "basic_comms"
#: What the page and compose.yaml call the containers.
NAMES = ("course", "scope")
#: Most that the image may weigh, 1e6 bytes, and the longest time from SIGTERM to the end, s.
MOST_MB, LONGEST_S = 500, 3.0
#: How often the end is tried: a machine may be busy with something else.
TRIES = 3
#: Packages to build with.
BUILDS = re.compile(r"-dev$|^(binutils|clang|cmake|make)\b|^(cpp|g\+\+|gcc)(-\d+)?$")
#: A try to reach the master at an address.
REACH = "import socket, sys; socket.create_connection((sys.argv[1], 11311), 3.0)"


class Tool:
    """Podman or docker.

    :param name: how it is called
    :param compose: how its compose is called
    """

    def __init__(self, name: str, compose: str) -> None:
        self.name = name
        self._compose = compose

    def typed(self, line: str) -> List[str]:
        """Return the words of a line of the page, which is written for podman."""
        words = shlex.split(line)
        called = {"podman": self.name, "podman-compose": self._compose}[words[0]]
        return [*called.split(), *words[1:]]

    def said(self, *arguments: str) -> str:
        """Return what it prints."""
        return said(self.name, *arguments).strip()

    def answers(self, *arguments: str) -> bool:
        """Tell whether it succeeds."""
        return answers(self.name, *arguments)


def insist(truth: bool, what: str) -> None:
    """Say that something is so.

    :raises SystemExit: it is not
    """
    if not truth:
        sys.exit(f"failed: {what}")
    print(what)


def refuse_others(tool: Tool) -> None:
    """Leave alone what somebody else has called so: the proof ends containers of these names.

    :raises SystemExit: there is such a container
    """
    for name in NAMES:
        if tool.answers("container", "inspect", name):
            sys.exit(f"there is a container '{name}', which would be ended: remove it first")


def image(tool: Tool) -> None:
    """Look at the image."""
    size = int(tool.said("image", "inspect", "--format", "{{.Size}}", IMAGE)) / 1e6
    insist(size <= MOST_MB, f"the image has {size:.0f} MB of at most {MOST_MB}")
    packages = tool.said("run", "--rm", IMAGE, "dpkg-query", "-W", "-f", "${Package}\n").split()
    found = list(filter(BUILDS.search, packages))
    insist(not found, f"of its {len(packages)} packages these are to build with: {found}")


def course(tool: Tool, run: str, heard: str) -> float:
    """Run the coursework, and end it.

    :returns: how long it took to end, s
    """
    process = subprocess.Popen(tool.typed(run), stdout=subprocess.DEVNULL)
    try:
        wait_for("the container runs", lambda: tool.answers("exec", "course", "true"))
        wait_for("/proc_signal is received in it", lambda: answers(*tool.typed(heard)))
        insist(tool.said("exec", "course", "id", "-u") != "0", "its user is not root")
        insist(not tool.answers("exec", "course", "touch", "/home/ros/x"), "its root is read-only")
        insist(tool.said("port", "course") == "", "no port of it is published")
        began = time.monotonic()
        tool.said("kill", "--signal", "TERM", "course")
        status = process.wait(PATIENCE)
        insist(status == 0, "SIGTERM ends it with status 0")
        return time.monotonic() - began
    finally:
        if process.poll() is None:
            tool.said("rm", "--force", "course")


@contextlib.contextmanager
def composed(tool: Tool, up: str, port: int) -> Iterator[None]:
    """Have what compose.yaml describes run."""
    os.environ["SCOPE_PORT"] = str(port)
    command = tool.typed(up)
    with tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        try:
            yield
        except BaseException:
            log.seek(0)
            print(log.read())
            raise
        finally:
            answers(*command[:-1], "down")
            # podman-compose leaves them.
            for network in ("basic_comms", "packaging_page"):
                tool.answers("network", "rm", network)
            process.kill()
            process.wait(PATIENCE)


def system(tool: Tool, up: str, other: str) -> None:
    """Run the coursework and the oscilloscope beside it."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with composed(tool, up, port):
        wait_for("the page is seen on this machine", lambda: connects("127.0.0.1", port))
        insist(greeting(port)["readonly"] is True, "it is read-only")
        wait_for("the course is healthy", lambda: is_healthy(tool, "course"))
        wait_for(
            "/proc_signal is received in a container of the network",
            lambda: answers(*tool.typed(other)),
        )
        address = tool.said(
            "inspect",
            "--format",
            "{{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}",
            "course",
        )
        reach = (IMAGE, "python3", "-c", REACH, address)
        insist(tool.answers("run", "--rm", "--network", "basic_comms", *reach), "the master, too")
        insist(not tool.answers("run", "--rm", *reach), "but not in a container of another network")
        insist(not connects(own_address(), port), "and the page not from another machine")
        ports = tool.said("port", "course") + tool.said("port", "scope")
        insist(ports == f"8080/tcp -> 127.0.0.1:{port}", f"all that is published is {ports}")
        tool.said("exec", "course", "rosnode", "kill", "/process")
        insist(not is_healthy(tool, "course"), "it is not where /proc_signal falls silent")


def is_healthy(tool: Tool, name: str) -> bool:
    """Tell whether the check of a container's health succeeds now."""
    if tool.name == "podman":
        return tool.answers("healthcheck", "run", name)
    check = json.loads(tool.said("inspect", "--format", "{{json .Config.Healthcheck}}", name))
    seconds = check["Timeout"] // 1_000_000_000
    command = ["timeout", str(seconds), *check["Test"][1:]]
    return tool.answers("exec", name, *command)


def connects(address: str, port: int) -> bool:
    """Tell whether something serves HTTP there."""
    try:
        with socket.create_connection((address, port), PATIENCE) as link:
            link.sendall(f"GET / HTTP/1.0\r\nHost: localhost:{port}\r\n\r\n".encode())
            return link.recv(12).endswith(b"200")
    except OSError:
        return False


def own_address() -> str:
    """Return the address under which other machines know this one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # nothing is sent
        return str(probe.getsockname()[0])


def greeting(port: int) -> Dict[str, Any]:
    """Return what the oscilloscope welcomes a page with, once it has found the master."""
    lines = [
        "GET /ws HTTP/1.1",
        f"Host: localhost:{port}",
        f"Origin: http://localhost:{port}",
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
        "",
        "",
    ]
    with socket.create_connection(("127.0.0.1", port), PATIENCE) as link:
        link.sendall("\r\n".join(lines).encode())
        with link.makefile("rb") as stream:
            while stream.readline().strip():
                pass
            message: Dict[str, Any] = {}
            while message.get("type") != "hello":
                size = stream.read(2)[1]
                if size > 125:
                    size = int.from_bytes(stream.read({126: 2, 127: 8}[size]), "big")
                message = json.loads(stream.read(size))
    return message


def main() -> None:
    """Do all of it."""
    tool = Tool(*sys.argv[1:])
    run, heard, up, other = filter(None, (line.strip() for line in sys.stdin))
    refuse_others(tool)
    image(tool)
    seconds = LONGEST_S
    for _ in range(TRIES):
        seconds = course(tool, run, heard)
        if seconds < LONGEST_S:
            break
    insist(seconds < LONGEST_S, f"within {seconds:.1f} s of at most {LONGEST_S:.0f}")
    system(tool, up, other)


if __name__ == "__main__":
    main()
