"""Run a user's commands, and print the checks, for ci/deb and ci/container."""

import contextlib
import pathlib
import signal
import subprocess
import sys
import time
import urllib.request
from typing import Callable, Iterator

#: Time limit of each command and wait [s].
PATIENCE = 60.0


def output(*command: str) -> str:
    """Return the output of a command.

    :raises SystemExit: if it fails, or takes too long
    """
    try:
        return subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=PATIENCE,
            check=True,
        ).stdout.decode(errors="replace")
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        sys.exit(f"{error}\n{(error.stdout or b'').decode(errors='replace')}")


def succeeds(*command: str) -> bool:
    """Return whether a command succeeds, which may fail or hang."""
    silence = subprocess.DEVNULL
    try:
        return subprocess.call(command, stdout=silence, stderr=silence, timeout=PATIENCE) == 0
    except subprocess.TimeoutExpired:
        return False


def fetched(url: str) -> str:
    """Return the response of a server on this machine; empty without one."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with opener.open(url, timeout=PATIENCE) as reply:
            return str(reply.read().decode())
    except OSError:
        return ""


def require(truth: bool, what: str) -> None:
    """Print a fulfilled condition.

    :raises SystemExit: if it is not fulfilled
    """
    if not truth:
        sys.exit(f"failed: {what}")
    print(what)


def wait_for(what: str, condition: Callable[[], bool]) -> None:
    """Wait until a condition is fulfilled, and print it.

    :raises SystemExit: if it is not fulfilled in time
    """
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"not within {PATIENCE:.0f} s: {what}")
        time.sleep(0.2)
    print(what)


@contextlib.contextmanager
def running(*command: str, log: str = "proof.log") -> Iterator[None]:
    """Run a command during the context, and end it by Ctrl-C.

    :param log: file for its output, one per running command
    :raises SystemExit: if its status is not 0
    """
    file = pathlib.Path(log)
    with file.open("w") as to:
        process = subprocess.Popen(command, stdout=to, stderr=subprocess.STDOUT)
    try:
        yield
    except BaseException:
        _interrupt(process)
        print(file.read_text())
        raise
    end = _interrupt(process)
    if end != "status 0":
        sys.exit(f"{command} ended with {end}:\n{file.read_text()}")


def _interrupt(process: "subprocess.Popen[bytes]") -> str:
    """End a process by Ctrl-C, or kill it; return the way it has ended."""
    process.send_signal(signal.SIGINT)
    try:
        return f"status {process.wait(PATIENCE)}"
    except subprocess.TimeoutExpired:
        process.kill()
        return f"SIGKILL, {PATIENCE:.0f} s after Ctrl-C: status {process.wait()}"
