"""The port of a simulated Arduino Uno: a program in the simulator's place, and real terminals."""

import os
import pathlib
import sys
from typing import List
from unittest import mock

import pytest

from nodekit.testing.waiting import wait_until
from serial_link.board import avr_board
from serial_link.board.avr_board import AvrBoard, AvrBuilder, BuildError, MemoryUse
from serial_link.board.transports import PtyTransport
from serial_link.port_mark import is_left_behind

#: What the simulator does about its port. The program "crash" ends at a command, as on cpu_Crashed
#: before it removes its link.
SIMULATOR = """#!{python}
import os, sys
ends = []
def plug():
    ends.append(os.openpty())
    os.symlink(os.ttyname(ends[-1][1]), sys.argv[2])
    print(os.ttyname(ends[-1][1]), flush=True)
plug()
for line in sys.stdin:
    if sys.argv[1] == "crash":
        sys.exit(1)
    os.unlink(sys.argv[2]) if line == "unplug\\n" else plug()
if os.path.lexists(sys.argv[2]):
    os.unlink(sys.argv[2])
"""


@pytest.fixture
def simulator(tmp_path: pathlib.Path) -> pathlib.Path:
    path = tmp_path / "simulator"
    path.write_text(SIMULATOR.format(python=sys.executable))
    path.chmod(0o755)
    return path


def entries(folder: pathlib.Path) -> List[str]:
    return sorted(path.name for path in folder.iterdir() if path.name != "simulator")


def test_board_has_a_marked_link_until_it_is_switched_off(
    simulator: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    board = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    board.start()
    assert entries(tmp_path) == ["board", "board.board"]
    assert os.readlink(tmp_path / "board") in (tmp_path / "board.board").read_text()
    assert not is_left_behind(str(tmp_path / "board"))
    assert board._process is not None
    assert os.getsid(board._process.pid) != os.getsid(0)  # Ctrl-C does not reach it
    board.close()
    assert entries(tmp_path) == []


def size_of(folder: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", sizes: str) -> MemoryUse:
    """Return the memory use of a sketch, from a tool in place of avr-size."""
    tool = folder / "avr-size"
    tool.write_text(f"#!{sys.executable}\nimport os\nprint('text data bss')\nprint({sizes})\n")
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")
    return AvrBuilder(folder).size(pathlib.Path("any"))


def test_ctrl_c_does_not_reach_a_compiler(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    session = size_of(tmp_path, monkeypatch, "os.getsid(0), 0, 0").flash
    assert size_of(tmp_path, monkeypatch, "int(os.environ['LC_ALL'] == 'C'), 0, 0").flash == 1
    assert session != os.getsid(0)  # a terminal interrupts what is in the session of the node


def test_missing_tool_is_named_with_its_packages_and_a_failed_one_with_its_output(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    with pytest.raises(BuildError, match="^avr-size: no such section\n$"):
        size_of(tmp_path, monkeypatch, "__import__('sys').exit('no such section')")
    (tmp_path / "avr-size").unlink()
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BuildError, match="^avr-size is missing: sudo apt install gcc avr-libc"):
        AvrBuilder(tmp_path).size(pathlib.Path("any"))


def test_tool_that_hangs_is_named(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(avr_board, "_BUILD_S", 0.1)
    with pytest.raises(BuildError, match="avr-size takes more than 0.1 s"):
        size_of(tmp_path, monkeypatch, "__import__('time').sleep(10.0)")


def test_initialized_data_takes_flash_and_ram(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    assert size_of(tmp_path, monkeypatch, "12000, 300, 1200") == MemoryUse(12300, 1500)


def test_built_programs_are_reused_and_a_cancelled_build_ends(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(avr_board, "_run", mock.Mock(side_effect=AssertionError("it compiles")))
    builder = AvrBuilder(tmp_path)
    for name in ("avr_board", "core.a"):
        (tmp_path / name).touch()
    assert builder.simulator(pathlib.Path("any")) == tmp_path / "avr_board"
    assert builder._core() == tmp_path / "core.a"
    with pytest.raises(BuildError, match="the build was cancelled"):
        AvrBuilder(tmp_path, lambda: True).size(pathlib.Path("any"))


def test_library_simulator_and_sketch_are_built_from_all_of_their_sources(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    commands: List[List[str]] = []
    monkeypatch.setattr(avr_board, "_run", commands.append)
    monkeypatch.setattr(avr_board, "ARDUINO", tmp_path / "arduino")
    builder = AvrBuilder(tmp_path)
    with pytest.raises(BuildError, match="arduino is missing: sudo apt install gcc avr-libc"):
        builder.sketch(tmp_path / "blink.ino", ())
    sources = tmp_path / "arduino" / "cores" / "arduino"
    sources.mkdir(parents=True)
    for name in ("b.cpp", "a.c", "c.S", "d.h"):
        (sources / name).touch()
    sketch = builder.sketch(tmp_path / "blink.ino", (tmp_path / "one", tmp_path / "two"))
    simulator = builder.simulator(tmp_path / "avr_board.c")
    assert (sketch, simulator) == (tmp_path / "blink.elf", tmp_path / "avr_board")
    *compiled, archived, linked, simulated = commands
    objects = [str(tmp_path / "core" / f"{name}.o") for name in ("a.c", "b.cpp", "c.S")]
    assert [command[-4:] for command in compiled] == [
        ["-c", str(sources / name), "-o", target]
        for name, target in zip(("a.c", "b.cpp", "c.S"), objects)
    ]
    assert [command[0] for command in compiled] == ["avr-gcc", "avr-g++", "avr-gcc"]
    assert archived[-4:] == [str(tmp_path / "core.a"), *objects]
    assert [word for word in linked if word.startswith(f"-I{tmp_path}")] == [
        f"-I{tmp_path / 'one'}",
        f"-I{tmp_path / 'two'}",
    ]
    for command in (*compiled, linked):
        assert {"-mmcu=atmega328p", "-DF_CPU=16000000L"} <= set(command)
    assert linked.index(str(tmp_path / "blink.ino")) < linked.index(str(tmp_path / "core.a"))
    for command, target in ((linked, sketch), (simulated, simulator)):
        assert command[command.index("-o") + 1] == str(target)
    assert simulated[:2] == ["gcc", str(tmp_path / "avr_board.c")] and "-lsimavr" in simulated


@pytest.mark.parametrize("is_marked", [False, True])
def test_link_of_a_killed_board_is_replaced(
    is_marked: bool,
    simulator: pathlib.Path,
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    (tmp_path / "board").symlink_to("/dev/null" if is_marked else "/dev/pts/none")
    monkeypatch.setattr(avr_board, "is_left_behind", lambda link: is_marked)
    board = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    board.start()
    assert os.readlink(tmp_path / "board").startswith("/dev/pts/")
    board.close()


def test_board_whose_link_cannot_be_marked_ends(
    simulator: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    (tmp_path / "board.board").mkdir()
    board = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    with pytest.raises(OSError, match=r"board\.board"):
        board.start()
    assert not board.is_running and entries(tmp_path) == ["board.board"]


def test_commands_of_the_simulator_have_the_given_values(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    lines: List[str] = []
    board = AvrBoard(pathlib.Path("any"), pathlib.Path("any"), str(tmp_path / "board"))
    monkeypatch.setattr(board, "_write", lines.append)
    board.reset(1.5)
    board.set_noise(0.01)
    assert lines == ["reset 1.5\n", "noise 0.01\n"]


def test_second_board_is_rejected_and_keeps_port_of_first(
    simulator: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    first = PtyTransport(str(tmp_path / "board"))
    first.plug()
    before = (tmp_path / "board.board").read_text(), os.readlink(tmp_path / "board")
    late = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    with pytest.raises(OSError, match="board exists already: .* stop that board or remove it"):
        late.start()
    assert not late.is_running
    late.close()
    assert before == ((tmp_path / "board.board").read_text(), os.readlink(tmp_path / "board"))
    first.unplug()


def test_cable_out_and_in_gives_the_port_another_terminal_and_mark(
    simulator: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    board = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    board.start()
    before = os.readlink(tmp_path / "board")
    board.unplug()
    wait_until(lambda: not os.path.lexists(tmp_path / "board"), lambda: "the port is there")
    board.plug()
    now = os.readlink(tmp_path / "board")
    assert now != before and now in (tmp_path / "board.board").read_text()
    board.unplug()
    board.close()
    assert entries(tmp_path) == []


def test_crashed_simulator_leaves_no_link(simulator: pathlib.Path, tmp_path: pathlib.Path) -> None:
    board = AvrBoard(simulator, pathlib.Path("crash"), str(tmp_path / "board"))
    board.start()
    board.reset()  # the line at which it crashes
    wait_until(lambda: not board.is_running, lambda: "it runs")
    board.close()
    assert entries(tmp_path) == []


def test_command_after_a_crash_of_the_simulator_leaves_no_link(
    simulator: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    board = AvrBoard(simulator, pathlib.Path("crash"), str(tmp_path / "board"))
    board.start()
    board.reset()
    wait_until(lambda: not board.is_running, lambda: "it runs")
    with pytest.raises(BrokenPipeError):
        board.reset()
    board.close()
    assert entries(tmp_path) == []


def test_link_that_another_board_has_made_meanwhile_is_kept(tmp_path: pathlib.Path) -> None:
    late = tmp_path / "simulator"
    late.write_text(
        f"#!{sys.executable}\nimport os, sys\nos.symlink('/dev/null', sys.argv[2])\n"
        "print('/dev/pts/none', flush=True)\nsys.stdin.read()\n"
    )
    late.chmod(0o755)
    board = AvrBoard(late, pathlib.Path("run"), str(tmp_path / "board"))
    with pytest.raises(OSError, match="another board was started at the same time"):
        board.start()
    assert not board.is_running and entries(tmp_path) == ["board"]


def test_simulator_that_hangs_is_ended(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(avr_board, "_START_S", 0.1)
    monkeypatch.setattr(avr_board, "_END_S", 0.1)
    simulator = tmp_path / "simulator"
    simulator.write_text(f"#!{sys.executable}\nimport time\ntime.sleep(600.0)\n")
    simulator.chmod(0o755)
    board = AvrBoard(simulator, pathlib.Path("run"), str(tmp_path / "board"))
    with pytest.raises(OSError, match="board cannot be created"):
        board.start()
    assert not board.is_running and entries(tmp_path) == []


def test_failed_start_of_simulator_is_reported(tmp_path: pathlib.Path) -> None:
    board = AvrBoard(pathlib.Path("/bin/false"), pathlib.Path("run"), str(tmp_path / "board"))
    with pytest.raises(OSError, match="board cannot be created: see the simulator's output"):
        board.start()
    assert not board.is_running and entries(tmp_path) == []


@pytest.mark.parametrize(
    "size", [MemoryUse(32257, 100), MemoryUse(100, 2048), MemoryUse(100, 3000)]
)
def test_sketch_that_does_not_fit_is_refused_with_its_size(size: MemoryUse) -> None:
    with pytest.raises(BuildError, match=f"needs {size.flash} of 32256 .* {size.ram} of 2048"):
        size.check()
    MemoryUse(32256, 2047).check()
