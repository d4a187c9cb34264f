"""Simulation of an Arduino Uno: a compiled sketch on an ATmega328P in simavr, at its real pace."""

import os
import pathlib
import subprocess
from typing import List, NamedTuple, Optional, Sequence

#: Where Debian's arduino-core-avr has the core.
ARDUINO = pathlib.Path("/usr/share/arduino/hardware/arduino/avr")
#: What builds sketch and simulator.
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
_BUILD_S, _END_S = 120.0, 2.0


class BuildError(RuntimeError):
    """A sketch or the simulator that cannot be built; the text says why."""


class Size(NamedTuple):
    """Memory that a sketch takes [bytes].

    :param flash: of 32 256
    :param ram: of 2 048, without the stack and what it allocates
    """

    flash: int
    ram: int


def build_simulator(source: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """Build the simulator, unless it is newer than its source.

    :param source: ``avr_board.c``
    :param folder: where
    :returns: the program
    :raises BuildError: if that is not possible
    """
    program = folder / "avr_board"
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        _run(["gcc", str(source), "-I/usr/include/simavr", "-o", str(program), *_SIMULATOR])
    return program


def build_core(folder: pathlib.Path) -> pathlib.Path:
    """Build Arduino's core as a library, once in a folder.

    :param folder: where
    :returns: the library
    :raises BuildError: if that is not possible
    """
    library, objects = folder / "core.a", folder / "core"
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
            _run([*command, "-o", built[-1]])
    _run(["avr-gcc-ar", "rcs", str(library), *built])
    return library


def build_sketch(
    sketch: pathlib.Path, libraries: Sequence[pathlib.Path], folder: pathlib.Path
) -> pathlib.Path:
    """Build a sketch for an Arduino Uno.

    :param sketch: ``NAME.ino``
    :param libraries: folders of headers that it includes
    :param folder: where
    :returns: the program, ``NAME.elf``
    :raises BuildError: if that is not possible; the text has what the compiler says
    """
    program = folder / (sketch.stem + ".elf")
    core = build_core(folder)
    _run(
        [
            *_LANGUAGES[".cpp"],
            *_FLAGS,
            *_INCLUDES,
            *(f"-I{library}" for library in libraries),
            *("-include", "Arduino.h", "-x", "c++", str(sketch), "-x", "none", str(core)),
            *("-Wl,--gc-sections", "-o", str(program), "-lm"),
        ]
    )
    return program


def size_of(program: pathlib.Path) -> Size:
    """Return the memory that a built sketch takes.

    :param program: of :func:`build_sketch`
    :raises BuildError: if it cannot be read
    """
    text, data, bss = map(int, _run(["avr-size", str(program)]).splitlines()[1].split()[:3])
    return Size(text + data, data + bss)


class AvrBoard:
    """A sketch that runs in simavr, with its serial port behind a link.

    :param simulator: of :func:`build_simulator`
    :param program: of :func:`build_sketch`
    :param link: path of the link to its terminal
    """

    def __init__(self, simulator: pathlib.Path, program: pathlib.Path, link: str) -> None:
        self._command = [str(simulator), str(program), link]
        self._process: Optional["subprocess.Popen[bytes]"] = None

    @property
    def is_running(self) -> bool:
        """Whether it runs."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Switch it on."""
        self._process = subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
        )

    def reset(self, boot_s: float = 0.0) -> None:
        """Reset it.

        :param boot_s: how long a bootloader keeps the sketch from running [s]
        """
        self._write(f"reset {boot_s}\n")

    def close(self) -> None:
        """Switch it off; the link goes with it."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        process.stdin.close()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _write(self, line: str) -> None:
        assert self._process is not None and self._process.stdin is not None
        self._process.stdin.write(line.encode())
        self._process.stdin.flush()


def _run(command: Sequence[str]) -> str:
    """Run a compiler; return what it prints."""
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=_BUILD_S,
            check=True,
            env={**os.environ, "LC_ALL": "C"},
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
