"""Simulation of an Arduino Uno: a compiled sketch on an ATmega328P in simavr, in real time."""

import contextlib
import os
import pathlib
import select
import subprocess
import time
from typing import Callable, List, NamedTuple, Optional, Sequence

from serial_link.port_mark import is_left_behind, remove_link, remove_own_link, write_mark

#: Arduino core, as Debian's arduino-core-avr installs it.
ARDUINO = pathlib.Path("/usr/share/arduino/hardware/arduino/avr")
#: Packages that build the sketch and the simulator.
DEBIAN_PACKAGES = "gcc avr-libc gcc-avr arduino-core-avr libelf-dev libsimavr-dev"
_INCLUDES = (f"-I{ARDUINO / 'cores' / 'arduino'}", f"-I{ARDUINO / 'variants' / 'standard'}")
_FLAGS = (
    "-mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10807 -DARDUINO_AVR_UNO -DARDUINO_ARCH_AVR -Os "
    "-ffunction-sections -fdata-sections -flto -w -DDECIMAL_DIG=__DECIMAL_DIG__"
).split()
_LANGUAGES = {
    ".c": ["avr-gcc", "-std=gnu11"],
    ".S": ["avr-gcc", "-x", "assembler-with-cpp"],
    ".cpp": ["avr-g++", "-std=gnu++11", "-fpermissive", "-fno-exceptions"],
}
_SIMULATOR = "-O2 -lsimavr -lelf -lm -lutil".split()
_BUILD_S, _START_S, _END_S = 120.0, 5.0, 2.0
_LONGEST_NAME = 64
#: Memory of an Arduino Uno, without the bootloader [bytes].
_FLASH, _RAM = 32256, 2048


class BuildError(RuntimeError):
    """Error of building a sketch or the simulator; the text gives the cause."""


class MemoryUse(NamedTuple):
    """Memory use of a sketch [bytes].

    :param flash: of 32 256
    :param ram: of 2 048, without stack and heap
    """

    flash: int
    ram: int

    def check(self) -> None:
        """Check that the sketch fits into an Arduino Uno.

        :raises BuildError: if it does not fit; the text has the figures
        """
        if self.flash > _FLASH or self.ram >= _RAM:
            raise BuildError(
                f"the sketch needs {self.flash} of {_FLASH} bytes of flash and {self.ram} of "
                f"{_RAM} bytes of RAM, plus the stack; lower the numbers and buffers in "
                "NodeHandle_, or remove arrays"
            )


class AvrBuilder:
    """Builder of sketches for an Arduino Uno, and of the simulator.

    :param folder: build folder; existing files in it are reused
    :param is_over: returns whether to stop before the next step
    """

    def __init__(self, folder: pathlib.Path, is_over: Callable[[], bool] = lambda: False) -> None:
        self._folder, self._is_over = folder, is_over

    def simulator(self, source: pathlib.Path) -> pathlib.Path:
        """Build the simulator.

        :param source: ``avr_board.c``
        :returns: the program
        :raises BuildError: if the build fails
        """
        program = self._folder / "avr_board"
        if not program.exists():
            includes = "-I/usr/include/simavr"
            self._run(["gcc", str(source), includes, "-o", str(program), *_SIMULATOR])
        return program

    def sketch(self, sketch: pathlib.Path, libraries: Sequence[pathlib.Path]) -> pathlib.Path:
        """Build a sketch.

        :param sketch: ``NAME.ino``
        :param libraries: include folders
        :returns: the program, ``NAME.elf``
        :raises BuildError: if the build fails; the text has the compiler's output
        """
        program = self._folder / (sketch.stem + ".elf")
        includes = [*_INCLUDES, *(f"-I{library}" for library in libraries)]
        source = ["-include", "Arduino.h", "-x", "c++", str(sketch), "-x", "none"]
        target = ["-Wl,--gc-sections", "-o", str(program), "-lm"]
        core = str(self._core())
        self._run([*_LANGUAGES[".cpp"], *_FLAGS, *includes, *source, core, *target])
        return program

    def size(self, program: pathlib.Path) -> MemoryUse:
        """Return the memory use of a built sketch.

        :param program: from :meth:`sketch`
        :raises BuildError: if avr-size fails
        """
        lines = self._run(["avr-size", str(program)]).splitlines()
        text, data, bss = map(int, lines[1].split()[:3])
        return MemoryUse(text + data, data + bss)

    def _core(self) -> pathlib.Path:
        """Build the Arduino core as a library, once."""
        library, objects = self._folder / "core.a", self._folder / "core"
        if library.exists():
            return library
        if not ARDUINO.is_dir():
            raise BuildError(f"{ARDUINO} is missing: sudo apt install {DEBIAN_PACKAGES}")
        objects.mkdir(parents=True, exist_ok=True)
        built: List[str] = []
        for source in sorted((ARDUINO / "cores" / "arduino").iterdir()):
            if source.suffix in _LANGUAGES:
                built.append(str(objects / (source.name + ".o")))
                command = [*_LANGUAGES[source.suffix], *_FLAGS, *_INCLUDES, "-c", str(source)]
                self._run([*command, "-o", built[-1]])
        self._run(["avr-gcc-ar", "rcs", str(library), *built])
        return library

    def _run(self, command: Sequence[str]) -> str:
        if self._is_over():
            raise BuildError("the build was cancelled")
        return _run(command)


class AvrBoard:
    """Sketch that runs in simavr, with its serial port behind a symbolic link.

    :param simulator: from :meth:`AvrBuilder.simulator`
    :param program: from :meth:`AvrBuilder.sketch`
    :param link: path of the link to its terminal
    """

    def __init__(self, simulator: pathlib.Path, program: pathlib.Path, link: str) -> None:
        self._command, self._link = [str(simulator), str(program), link], link
        self._process: Optional["subprocess.Popen[bytes]"] = None
        self._terminal = ""

    @property
    def is_running(self) -> bool:
        """Whether the simulator runs."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start the simulator; its port exists when this returns.

        :raises OSError: if the port cannot be created, or belongs to another board
        """
        if is_left_behind(self._link) or not os.path.exists(self._link):
            remove_link(self._link)  # left by a killed board
        if os.path.lexists(self._link):
            raise OSError(
                f"{self._link} exists already: it is a file, the port of another board, or "
                "left by a killed board; stop that board or remove it"
            )
        # In its own session: otherwise Ctrl-C would kill it before it removes its link.
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        try:
            self._mark_link()
        except OSError:
            self.close()
            raise

    def reset(self, boot_s: float = 0.0) -> None:
        """Reset the board.

        :param boot_s: time in the bootloader before the sketch runs [s]
        """
        self._write(f"reset {boot_s}\n")

    def set_noise(self, share: float) -> None:
        """Change, lose or double bytes, as a bad cable does.

        :param share: of the bytes in either direction, from 0 to 1
        """
        self._write(f"noise {share}\n")

    def unplug(self) -> None:
        """Pull the cable: the port disappears, and the sketch keeps running."""
        self._write("unplug\n")

    def plug(self) -> None:
        """Plug the cable in again, with another port number.

        :raises OSError: if the port cannot be created
        """
        self._write("plug\n")
        self._mark_link()

    def close(self) -> None:
        """Stop the simulator, and remove the link."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # after a command that it did not read
            process.stdin.close()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        assert process.stdout is not None
        process.stdout.close()
        remove_own_link(self._link, self._terminal)  # in case the simulator did not

    def _mark_link(self) -> None:
        """Wait for the link to the terminal, and mark it as owned by this process."""
        self._terminal = self._read_terminal()
        if not self._terminal or os.readlink(self._link) != self._terminal:
            raise OSError(
                f"{self._link} cannot be created: see the simulator's output above, or another "
                "board was started at the same time"
            )
        write_mark(self._link)

    def _read_terminal(self) -> str:
        """Return the terminal's name, which the simulator prints; empty if it does not."""
        assert self._process is not None and self._process.stdout is not None
        end, line, file = time.monotonic() + _START_S, b"", self._process.stdout.fileno()
        while not line.endswith(b"\n"):
            if not select.select([file], [], [], max(0.0, end - time.monotonic()))[0]:
                return ""
            data = os.read(file, _LONGEST_NAME)
            if not data:
                return ""
            line += data
        return line.decode().strip()

    def _write(self, line: str) -> None:
        assert self._process is not None and self._process.stdin is not None
        self._process.stdin.write(line.encode())
        self._process.stdin.flush()


def _run(command: Sequence[str]) -> str:
    """Run a compiler; return its output."""
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=_BUILD_S,
            check=True,
            env={**os.environ, "LC_ALL": "C"},
            # In its own session: Ctrl-C would make it fail before the node shuts down.
            start_new_session=True,
        )
    except FileNotFoundError as error:
        raise BuildError(
            f"{error.filename} is missing: sudo apt install {DEBIAN_PACKAGES}"
        ) from None
    except subprocess.TimeoutExpired:
        raise BuildError(f"{command[0]} takes more than {_BUILD_S:g} s") from None
    except subprocess.CalledProcessError as error:
        raise BuildError(f"{command[0]}: {error.stderr.decode(errors='replace')}") from None
    return done.stdout.decode()
