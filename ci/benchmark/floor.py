"""What generator and process would cost if nothing but the kernel's calls were left of them."""

import contextlib
import socket
import subprocess
import sys
import threading
from typing import Iterator, List, Tuple

from .peer_programs import SCRIPTS

FLOOR = "floor"


@contextlib.contextmanager
def up(rate: float) -> Iterator[List[int]]:
    """Have a pair of bare Python loops running, connected as nodes are.

    :param rate: of the generator, Hz
    :returns: the numbers of process and generator
    """
    with contextlib.ExitStack() as stack:
        sockets = [_connected() for _ in range(2)]
        for pair in sockets:
            for end in pair:
                stack.enter_context(end)
        (generated, samples), (answers, observed) = sockets
        running = [
            _start(stack, "process", str(samples.fileno()), answers),
            _start(stack, "generator", f"{rate:g}", generated),
        ]
        threading.Thread(target=_read, args=(observed,), daemon=True).start()
        yield [process.pid for process in running]


def _connected() -> Tuple[socket.socket, socket.socket]:
    """Return both ends of a connection over TCP, set up as subscribers and publishers do."""
    with socket.create_server(("localhost", 0)) as server:
        near = socket.create_connection(server.getsockname())
        far, _ = server.accept()
    for end in (near, far):
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return near, far


def _start(
    stack: contextlib.ExitStack, role: str, first: str, out: socket.socket
) -> "subprocess.Popen[bytes]":
    command: List[str] = [sys.executable, str(SCRIPTS / "floor.py"), role, first]
    inherited = [out.fileno()] + ([int(first)] if role == "process" else [])
    process = subprocess.Popen([*command, str(out.fileno())], pass_fds=inherited)
    stack.callback(process.wait, 10.0)
    stack.callback(process.kill)
    return process


def _read(observed: socket.socket) -> None:
    with contextlib.suppress(OSError):  # closed at the end
        while observed.recv(65536):
            pass
