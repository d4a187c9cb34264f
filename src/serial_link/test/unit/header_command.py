"""The command make_headers, and the libraries that its headers are compiled with in tests."""

import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parents[1]
#: Options of a compiler: a ``ros.h`` for tests on this machine, and what it shares with that of the
#: simulated AVR.
LIBRARIES = [f"-I{HERE / 'board_library'}", f"-I{HERE.parent / 'avr' / 'library'}"]


def command(*arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run make_headers."""
    return subprocess.run(
        [sys.executable, str(HERE.parent / "scripts" / "make_headers"), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
