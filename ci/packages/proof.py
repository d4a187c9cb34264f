"""Run the commands of a user, and say what has been seen, for ci/deb and ci/container."""

import contextlib
import pathlib
import signal
import subprocess
import sys
import time
from typing import Callable, Iterator

#: How long anything may take, s.
PATIENCE = 60.0


def said(*command: str) -> str:
    """Return what a command prints.

    :raises SystemExit: it fails, or takes too long
    """
    try:
        return subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
            timeout=PATIENCE,
            check=True,
        ).stdout
    except subprocess.SubprocessError as error:
        output = error.stdout or ""  # type: ignore[attr-defined]
        # Where it took too long, Python does not decode what there is.
        text = output.decode(errors="replace") if isinstance(output, bytes) else output
        sys.exit(f"{error}\n{text}")


def wait_for(what: str, condition: Callable[[], bool]) -> None:
    """Wait until something is so, and say it.

    :raises SystemExit: it is not so in time
    """
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"not within {PATIENCE:.0f} s: {what}")
        time.sleep(0.2)
    print(what)


@contextlib.contextmanager
def running(*command: str, log: str = "proof.log") -> Iterator[None]:
    """Have a command run, and end at Ctrl-C, with status 0.

    :param log: file for what it prints, not that of another one that runs
    """
    file = pathlib.Path(log)
    with file.open("w") as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
    try:
        yield
    except BaseException:
        _interrupt(process)
        print(file.read_text())
        raise
    how = _interrupt(process)
    if how != "status 0":
        sys.exit(f"{command} ended with {how}:\n{file.read_text()}")


def _interrupt(process: "subprocess.Popen[bytes]") -> str:
    """Press Ctrl-C, kill what does not end of it, and return how it has ended."""
    process.send_signal(signal.SIGINT)
    try:
        return f"status {process.wait(PATIENCE)}"
    except subprocess.TimeoutExpired:
        process.kill()
        return f"SIGKILL, {PATIENCE:.0f} s after Ctrl-C: status {process.wait()}"


def answers(*command: str) -> bool:
    """Tell whether a command that may fail, or hang, succeeds."""
    silence = subprocess.DEVNULL
    try:
        return subprocess.call(command, stdout=silence, stderr=silence, timeout=PATIENCE) == 0
    except subprocess.TimeoutExpired:
        return False
