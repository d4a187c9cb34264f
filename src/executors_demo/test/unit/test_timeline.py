"""The command that draws a timeline."""

import io
import re
import sys
from pathlib import Path
from typing import List, Set

import pytest
from executors_demo.bars import bars
from executors_demo.events import Event, read
from executors_demo.picture import Panel, draw
from executors_demo.commands.timeline import main

LOG = "\n".join(
    [
        "[INFO] [1.0]: /two_mutex: executor='multi'",
        f"[INFO] [1.0]: {Event(0.0, 'executor-1-10', 'timer1', 1, True)}",
        f"[INFO] [1.0]: {Event(0.1, 'executor-1-9', 'timer2', 1, True)}",
        f"[INFO] [1.0]: {Event(1.1, 'executor-1-9', 'timer2', 1, False)}",
        f"[INFO] [1.0]: {Event(2.0, 'executor-1-10', 'timer1', 1, False)}",
        f"[INFO] [1.0]: {Event(2.0, 'executor-1-10', 'timer3', 1, True)}",
        f"[INFO] [1.0]: {Event(2.0, 'executor-1-10', 'timer3', 1, False)}",
    ]
)


def run(monkeypatch: "pytest.MonkeyPatch", *arguments: str) -> None:
    monkeypatch.setattr(sys, "argv", ["timeline", *arguments])
    main()


def texts(picture: Path) -> List[str]:
    """Return the comments in a picture: matplotlib writes each text as one beside its shape."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text())


def colours(picture: Path) -> Set[str]:
    """Return the colours of the bars, which are neither black nor white as all else is."""
    found = set(re.findall(r"fill: ?(#[0-9a-f]{6})", picture.read_text()))
    return found - {"#000000", "#ffffff"}


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "two_mutex.log"
    path.write_text(LOG)
    return path


def test_a_picture_has_each_thread_callback_and_number(
    log: Path, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    picture = tmp_path / "picture.svg"
    run(monkeypatch, str(log), "-o", str(picture))
    said = texts(picture)
    threads = [text for text in said if text.startswith("executor")]
    assert threads == ["executor-1-9", "executor-1-10"]
    assert {"timer1", "timer2", "timer3", "two_mutex", "1"} <= set(said)
    assert len(colours(picture)) == 3


def test_a_call_of_no_length_is_seen() -> None:
    figure = draw([Panel("", bars(read(LOG.splitlines())))])
    assert min(patch.get_width() for patch in figure.axes[0].patches) > 0.0


def test_failed_rename_leaves_no_file(
    log: Path, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    (tmp_path / "folder.svg").mkdir()
    with pytest.raises(SystemExit):
        run(monkeypatch, str(log), "-o", str(tmp_path / "folder.svg"))
    assert {path.name for path in tmp_path.iterdir()} == {"two_mutex.log", "folder.svg"}


def test_the_same_log_gives_the_same_picture(
    log: Path, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    one, other = tmp_path / "one.svg", tmp_path / "other.svg"
    run(monkeypatch, str(log), "-o", str(one))
    monkeypatch.setattr(sys, "stdin", io.StringIO(LOG))
    run(monkeypatch, str(log), "-o", str(other))
    assert one.read_bytes() == other.read_bytes()


def test_standard_input_is_default(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> None:
    for number, arguments in enumerate(([], ["-"])):
        picture = tmp_path / f"{number}.PNG"
        monkeypatch.setattr(sys, "stdin", io.StringIO(LOG))
        run(monkeypatch, *arguments, "-o", str(picture))
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_logs_are_drawn_below_each_other(
    log: Path, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    second, picture = tmp_path / "single.txt", tmp_path / "picture.svg"
    second.write_text(LOG)
    run(monkeypatch, str(log), str(second), "-o", str(picture))
    said = texts(picture)
    assert said.index("two_mutex") < said.index("single")
    assert said.count("executor-1-9") == 2


@pytest.mark.parametrize(
    "text, arguments, said",
    [
        (
            "nothing",
            ["{log}", "-o", "{out}.svg"],
            "{log}: no line about the start or end of a call",
        ),
        (LOG, ["{log}x", "-o", "{out}.svg"], "{log}x: No such file or directory"),
        (LOG, ["{log}", "-o", "{out}/a/b.svg"], "{out}/a/b.svg.part: No such file or directory"),
        (LOG, ["{log}", "-o", "{out}.pdf"], "'{out}.pdf' does not end in .svg or .png"),
    ],
)
def test_undrawable_log_is_reported(
    text: str,
    arguments: List[str],
    said: str,
    tmp_path: Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    names = {"log": str(tmp_path / "a.log"), "out": str(tmp_path / "out")}
    (tmp_path / "a.log").write_text(text)
    with pytest.raises(SystemExit) as ended:
        run(monkeypatch, *[argument.format(**names) for argument in arguments])
    assert ended.value.code == 2
    assert said.format(**names) in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["a.log"]


def test_interrupted_command_has_the_status_of_a_shell(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    class Terminal(io.StringIO):
        """Standard input whose user presses Ctrl-C."""

        def __next__(self) -> str:
            raise KeyboardInterrupt

    monkeypatch.setattr(sys, "stdin", Terminal())
    with pytest.raises(SystemExit) as ended:
        run(monkeypatch, "-o", str(tmp_path / "picture.svg"))
    assert ended.value.code == 130 and not list(tmp_path.iterdir())


def test_missing_matplotlib_is_reported_with_package(
    log: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.delitem(sys.modules, "executors_demo.picture", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(SystemExit) as ended:
        run(monkeypatch, str(log), "-o", str(log) + ".svg")
    assert ended.value.code == 2
    assert "matplotlib is not installed: apt install python3-matplotlib" in capsys.readouterr().err
