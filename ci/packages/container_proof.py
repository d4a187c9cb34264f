"""Run the image, and compose.yaml, by the commands of docs/container.md.

``python3 ci packages.container_proof TOOL COMPOSE``, with the page's commands on its standard
input, prints its checks, and ends with a status other than 0 at the first fault.
"""

import contextlib
import json
import os
import re
import shlex
import socket
import subprocess
import sys
import time
from typing import Iterator, List

from .proof import PATIENCE, fetched, output, require, succeeds, wait_for

IMAGE = "basic_comms"
#: Names of the containers on the page and in compose.yaml.
NAMES = ("course", "scope")
#: Largest size of the image [1e6 bytes], and longest time from SIGTERM to the end [s].
MOST_MB, LONGEST_S = 500, 3.0
#: Number of attempts to measure the end: the machine may be busy.
TRIES = 3
#: Packages of build tools.
BUILDS = re.compile(r"-dev$|^(binutils|clang|cmake|make)\b|^(cpp|g\+\+|gcc)(-\d+)?$")
#: Attempt to connect to the master at an address.
REACH = "import socket, sys; socket.create_connection((sys.argv[1], 11311), 3.0)"
ADDRESS = "{{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}"
REVISION = '{{index .Config.Labels "org.opencontainers.image.revision"}}'
#: Package of the course's nodes.
NODES = "ros-basic-comms"
#: Prints whether the oscilloscope treats a page as read-only, once it has found the master.
IS_READONLY = """
import asyncio, json
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

async def hello():
    request = HTTPRequest("ws://localhost:8080/ws", headers={"Origin": "http://localhost:8080"})
    connection = await websocket_connect(request)
    message = {}
    while message.get("type") != "hello":
        message = json.loads(await connection.read_message())
    return message["readonly"]

print(asyncio.run(hello()))
"""


class Tool:
    """Podman or docker.

    :param name: its command
    :param compose: command of its compose
    """

    def __init__(self, name: str, compose: str) -> None:
        self.name = name
        self._called = {"podman": name, "podman-compose": compose}

    def typed(self, line: str) -> List[str]:
        """Return the words of a line of the page, adapted from podman."""
        first, *words = shlex.split(line)
        return [*self._called[first].split(), *words]

    def output(self, *arguments: str) -> str:
        return output(self.name, *arguments).strip()

    def succeeds(self, *arguments: str) -> bool:
        return succeeds(self.name, *arguments)

    def is_healthy(self, container: str) -> bool:
        """Run the health check of a container, and return whether it succeeds."""
        if self.name == "podman":
            return self.succeeds("healthcheck", "run", container)
        check = json.loads(
            self.output("inspect", "--format", "{{json .Config.Healthcheck}}", container)
        )
        seconds = str(check["Timeout"] // 1_000_000_000)
        return self.succeeds("exec", container, "timeout", seconds, *check["Test"][1:])


def check_image(tool: Tool) -> None:
    """Check the size of the image, and that it has no build tools."""
    size = int(tool.output("image", "inspect", "--format", "{{.Size}}", IMAGE)) / 1e6
    require(size <= MOST_MB, f"the image has {size:.0f} MB of at most {MOST_MB}")
    user = tool.output("image", "inspect", "--format", "{{.Config.User}}", IMAGE)
    require(bool(re.match("[1-9]", user)), f"its user is {user}, a number other than 0")
    commit = tool.output("image", "inspect", "--format", REVISION, IMAGE)
    packed = tool.output("run", "--rm", IMAGE, "dpkg-query", "-W", "-f", "${Version}", NODES)
    is_named = "~git" not in packed or (commit != "" and commit in packed)
    require(is_named, f"its label {commit} names the commit of version {packed}")
    packages = tool.output("run", "--rm", IMAGE, "dpkg-query", "-W", "-f", "${Package}\n").split()
    found = list(filter(BUILDS.search, packages))
    require(not found, f"of its {len(packages)} packages these are to build with: {found}")


def check_course(tool: Tool, run: str, receive: str) -> float:
    """Run the coursework, and end it.

    :returns: time that the end took [s]
    """
    process = subprocess.Popen(tool.typed(run), stdout=subprocess.DEVNULL)
    try:
        wait_for("the container runs", lambda: tool.succeeds("exec", "course", "true"))
        wait_for("/proc_signal is received in it", lambda: succeeds(*tool.typed(receive)))
        require(tool.output("exec", "course", "id", "-u") != "0", "its user is not root")
        touch = ("exec", "course", "touch", "/home/ros/x")
        require(not tool.succeeds(*touch), "its root is read-only")
        require(tool.output("port", "course") == "", "no port of it is published")
        began = time.monotonic()
        tool.output("kill", "--signal", "TERM", "course")
        require(process.wait(PATIENCE) == 0, "SIGTERM ends it with status 0")
        return time.monotonic() - began
    finally:
        if process.poll() is None:
            tool.output("rm", "--force", "course")


@contextlib.contextmanager
def composed(tool: Tool, up: str) -> Iterator[None]:
    """Run the services of compose.yaml."""
    command = tool.typed(up)
    process = subprocess.Popen(command, stdout=sys.stderr)
    try:
        yield
    finally:
        succeeds(*command[:-1], "down")
        # podman-compose does not remove them.
        for network in ("basic_comms", "packaging_page"):
            tool.succeeds("network", "rm", network)
        process.kill()
        process.wait(PATIENCE)


def check_system(tool: Tool, up: str, receive: str) -> None:
    """Run the coursework and the oscilloscope beside it."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    os.environ["SCOPE_PORT"] = str(port)
    with composed(tool, up):
        wait_for(
            "the page is seen on this machine", lambda: bool(fetched(f"http://localhost:{port}"))
        )
        readonly = tool.output("exec", "scope", "python3", "-c", IS_READONLY)
        require(readonly == "True", "it is read-only")
        wait_for("the course is healthy", lambda: tool.is_healthy("course"))
        wait_for(
            "/proc_signal is received in a container of the network",
            lambda: succeeds(*tool.typed(receive)),
        )
        reach = (
            IMAGE,
            "python3",
            "-c",
            REACH,
            tool.output("inspect", "--format", ADDRESS, "course"),
        )
        inside = tool.succeeds("run", "--rm", "--network", "basic_comms", *reach)
        require(inside, "the master is reached there, too")
        outside = tool.succeeds("run", "--rm", *reach)
        require(not outside, "but not in a container of another network")
        ports = tool.output("port", "course") + tool.output("port", "scope")
        require(ports == f"8080/tcp -> 127.0.0.1:{port}", f"all that is published is {ports}")
        tool.output("exec", "course", "rosnode", "kill", "/process")
        require(not tool.is_healthy("course"), "it is not where /proc_signal falls silent")


def main() -> None:
    """Run all checks, unless containers with these names exist: they would be ended."""
    tool = Tool(*sys.argv[1:])
    run, receive, up, receive_outside = filter(None, (line.strip() for line in sys.stdin))
    for name in NAMES:
        if tool.succeeds("container", "inspect", name):
            sys.exit(f"there is a container '{name}', which would be ended: remove it first")
    check_image(tool)
    ends = (check_course(tool, run, receive) for _ in range(TRIES))
    seconds = next((end for end in ends if end < LONGEST_S), None)
    require(seconds is not None, f"within {LONGEST_S:.0f} s")
    check_system(tool, up, receive_outside)


if __name__ == "__main__":
    main()
