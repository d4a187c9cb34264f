"""Command plot_bag: output files and errors."""

import csv
import io
import os
import sys
from pathlib import Path
from typing import Any, List
from unittest import mock

import genpy
import numpy
import pytest
from bags import BEGIN, write_bag
from geometry_msgs.msg import Point, PointStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray, Int32

from topic_scope.bag import plot
from topic_scope.commands import plot_bag


@pytest.fixture
def bag(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> str:
    """Write a bag of 3 s into the command's folder."""
    monkeypatch.chdir(tmp_path)
    messages: List[Any] = [("/x", Float64(0.1 * second), second * 10**9) for second in range(4)]
    messages += [("/a", Float64MultiArray(data=[0.5] * n), n * 10**9 - 10**9) for n in (1, 2, 3)]
    messages += [("/j", JointState(name=["arm", "leg"], position=[1.0, 2.0]), 10**9)]
    return write_bag(tmp_path / "x.bag", messages + [("/y", Int32(7), 10**9)])


def call(monkeypatch: "pytest.MonkeyPatch", *arguments: str) -> None:
    monkeypatch.setattr("sys.argv", ["plot_bag.py", *arguments])
    plot_bag.main()


def failure(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]", *arguments: str
) -> str:
    """Return the error text of a failing call."""
    before = sorted(os.listdir("."))
    with pytest.raises(SystemExit) as caught:
        call(monkeypatch, *arguments)
    assert caught.value.code == 2
    assert sorted(os.listdir(".")) == before
    return capsys.readouterr().err


@pytest.mark.parametrize(
    "limits, times",
    [
        ([], [0, 1, 2, 3]),
        (["--start", "1"], [1, 2, 3]),
        (["--end", "2"], [0, 1, 2]),
        (["--start", "0.5", "--end", "2.5"], [1, 2]),
        (["--start=2", "--end=2"], [2]),
    ],
)
def test_csv(
    bag: str, monkeypatch: "pytest.MonkeyPatch", limits: List[str], times: List[int]
) -> None:
    call(monkeypatch, bag, "/x/data", "-o", "out.csv", *limits)
    lines = [f"{int(time)}.000000000,{0.1 * time!r}" for time in times]
    assert Path("out.csv").read_text().splitlines() == ["time,/x/data"] + lines
    assert sorted(os.listdir(".")) == ["out.csv", "x.bag"]


@pytest.mark.parametrize(
    "name, begin", [("a.png", b"\x89PNG"), ("a.SVG", b"<?xml"), ("a.pdf", b"%PDF")]
)
def test_pictures(bag: str, monkeypatch: "pytest.MonkeyPatch", name: str, begin: bytes) -> None:
    call(monkeypatch, bag, "/x/data", "/y", "-o", name)
    assert Path(name).read_bytes().startswith(begin)
    assert sorted(os.listdir(".")) == sorted([name, "x.bag"])


@pytest.mark.parametrize(
    "arguments, text",
    [
        (["/x/data", "-o", "out.gif"], "'out.gif' does not end in .png, .svg, .pdf or .csv"),
        (["/x/data", "-o", "out"], "'out' does not end in"),
        (["/x/data"], "required: -o"),
        (["-o", "out.csv"], "required: FIELD"),
        (["/x/data", "-o", "out.csv", "--start", "soon"], "'soon' is not a time"),
        (["/x/data", "-o", "out.csv", "--start", "nan"], "'nan' is not a time"),
        (["/x/data", "-o", "out.csv", "--end", "-1"], "'-1' is not a time"),
        (
            ["/x/date", "-o", "out.csv"],
            "plot_bag: /x/date: there is no date in std_msgs/Float64; similar names: /x/data",
        ),
        (["/x//data", "-o", "out.csv"], "plot_bag: "),
        (["/x/data", "-o", "no/out.csv"], "plot_bag: no/out.csv: No such file or directory"),
        (
            ["/x/data", "-o", "out.csv", "--start", "4"],
            "plot_bag: no message of /x in this time; the bag is 3.000 s long",
        ),
        (
            ["/x/data", "-o", "out.png", "--start", "2", "--end", "1"],
            "plot_bag: --start 2 is after --end 1",
        ),
        (["/a/data[3]", "-o", "out.csv"], "plot_bag: /a/data[3]: data has 3 elements at most"),
        (["/a/data[3]", "-o", "out.csv", "--end", "1"], "data has 2 elements at most"),
        (["/a/layout/dim[0]/size", "-o", "out.png"], "layout/dim has 0 elements at most"),
        (["/a/data[x]", "-o", "out.csv"], "the elements of data have no names"),
        (["/j/position[tail]", "-o", "out.csv"], "no element of position is named tail"),
    ],
)
def test_error_messages(
    bag: str,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    arguments: List[str],
    text: str,
) -> None:
    assert text in failure(monkeypatch, capsys, bag, *arguments)


def test_intermittent_elements_are_written(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    call(monkeypatch, bag, "/a/data[2]", "/j/position[leg]", "-o", "out.csv")
    rows = sorted(Path("out.csv").read_text().splitlines()[1:])
    assert rows == ["0.000000000,,", "1.000000000,,", "1.000000000,,2.0", "2.000000000,0.5,"]


def test_too_many_lines_are_rejected(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.chdir(tmp_path)
    message = Float64MultiArray(data=[1.0] * 41)
    path = write_bag(tmp_path / "x.bag", [("/a", message, 0), ("/a", message, 10**9)])
    names = [f"/a/data[{index}]" for index in range(41)]
    error = failure(monkeypatch, capsys, path, *names, "-o", "out.png")
    assert error.startswith("plot_bag: too many lines (41, at most 40)")
    call(monkeypatch, path, *names, "-o", "out.csv")
    call(monkeypatch, path, *names[:40], "-o", "out.png")


def test_missing_bag(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.chdir(tmp_path)
    error = failure(monkeypatch, capsys, "no.bag", "/x", "-o", "out.csv")
    assert error == "plot_bag: no.bag: No such file or directory\n"


def test_file_that_was_there_stays_when_the_new_one_fails(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    Path("out.csv").write_text("precious")
    failure(monkeypatch, capsys, bag, "/x/data", "-o", "out.csv", "--start", "4")
    assert Path("out.csv").read_text() == "precious"


class Terminal(io.StringIO):
    """Standard error that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    "error, long, shown",
    [(Terminal(), 4, True), (Terminal(), 5, False), (io.StringIO(), 4, False)],
)
def test_progress_is_shown_of_long_bags_on_a_terminal(
    bag: str, monkeypatch: "pytest.MonkeyPatch", error: io.StringIO, long: int, shown: bool
) -> None:
    monkeypatch.setattr("sys.stderr", error)
    monkeypatch.setattr(plot_bag, "LONG", long)
    call(monkeypatch, bag, "/x/data", "-o", "out.csv")
    assert ("0 % |" in error.getvalue()) == shown


@pytest.mark.parametrize("end, seconds", [("2", 1), ("9", 2)])
def test_progress_is_that_of_the_chosen_range(
    bag: str, monkeypatch: "pytest.MonkeyPatch", end: str, seconds: int
) -> None:
    shown = mock.Mock(wraps=plot_bag.tqdm)
    monkeypatch.setattr(plot_bag, "tqdm", shown)
    call(monkeypatch, bag, "/x/data", "-o", "out.csv", "--start", "1", "--end", end)
    assert shown.call_args[1]["total"] == seconds * 10**9


def test_missing_matplotlib_is_reported_and_csv_works(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.delitem(sys.modules, "topic_scope.bag.plot", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    error = failure(monkeypatch, capsys, bag, "/x/data", "-o", "out.png")
    assert error == "plot_bag: matplotlib is not installed: apt install python3-matplotlib\n"
    assert not Path("out.png").exists()
    call(monkeypatch, bag, "/x/data", "-o", "out.csv")
    assert Path("out.csv").exists()


def test_ctrl_c_ends_it_without_a_trace(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    def interrupted(*_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(plot_bag, "slices", interrupted)
    with pytest.raises(SystemExit) as caught:
        call(monkeypatch, bag, "/x/data", "-o", "out.csv")
    assert caught.value.code == 130
    assert capsys.readouterr().err == ""


def test_formulas_are_drawn(bag: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    call(monkeypatch, bag, "/x/data-/y/data", "=-/x + 1", "/x", "-o", "out.svg")
    drawn = Path("out.svg").read_text()
    assert "/x/data-/y/data" in drawn and "=-/x/data + 1" in drawn


def test_formula_values_are_in_the_rows_of_their_stamps(
    bag: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    formulas = ["=max(10*/x, 15)", "=delay(/x, 0.5)", "/y/data-/x/data", "=2*/j/position[leg]"]
    call(monkeypatch, bag, "/x", *formulas, "-o", "out.csv")
    with open("out.csv", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [
        "time",
        "/x/data",
        "=max(10 * /x/data, 15)",
        "=delay(/x/data, 0.5)",
        "/y/data-/x/data",
        "=2 * /j/position[leg]",
    ]
    assert rows == [
        ["0.000000000", "0.0", "15.0", "", "", ""],
        ["0.500000000", "", "", "0.0", "", ""],
        ["1.000000000", "", "", "", "", "4.0"],
        ["1.000000000", "", "", "", "6.9", ""],
        ["1.000000000", "0.1", "15.0", "", "", ""],
        ["1.500000000", "", "", "0.1", "", ""],
        ["2.000000000", "0.2", "15.0", "", "", ""],
        ["2.500000000", "", "", "0.2", "", ""],
        ["3.000000000", "0.30000000000000004", "15.0", "", "", ""],
        ["3.500000000", "", "", "0.30000000000000004", "", ""],
    ]


def test_stamps_are_exact_to_the_nanosecond_in_the_rows_of_formulas(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    stamps = [1700000000123456789, 1700000000223456788]
    messages: List[Any] = []
    for index, stamp in enumerate(stamps):
        message = PointStamped()
        message.header.stamp = genpy.Time(0, stamp)
        message.point.x = index
        messages.append(("/p", message, index * 10**8))
    bag = write_bag(tmp_path / "p.bag", messages)
    monkeypatch.chdir(tmp_path)
    call(monkeypatch, bag, "/p/point/x@stamp", "=/p/point/x@stamp + 1", "-o", "out.csv")
    rows = Path("out.csv").read_text().splitlines()[1:]
    # Relative to the start of the bag, which is the first message.
    assert rows == ["0.000000000,0.0,1.0", "0.099999999,1.0,2.0"]


def test_late_messages_keep_their_values_beside_formulas(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    messages: List[Any] = []
    for index, stamp in enumerate((0, 2, 1, 3)):
        message = PointStamped()
        message.header.stamp = genpy.Time(0, BEGIN + stamp * 10**8)
        message.point.x = stamp
        messages.append(("/p", message, index * 10**8))
    bag = write_bag(tmp_path / "p.bag", messages)
    monkeypatch.chdir(tmp_path)
    call(monkeypatch, bag, "/p/point/x@stamp", "=2 * /p/point/x@stamp", "-o", "out.csv")
    rows = [row.split(",")[1:] for row in Path("out.csv").read_text().splitlines()[1:]]
    assert rows == [[f"{x}.0", f"{2 * x}.0"] for x in range(4)]
    names = ("/p/point/x@stamp", "/p/point/x@received", "=2 * /p/point/x@stamp")
    call(monkeypatch, bag, *names, "-o", "out.csv")
    rows = [row.split(",")[1:] for row in Path("out.csv").read_text().splitlines()[1:]]
    # Another message at the same time is in another row.
    assert rows == [
        ["0.0", "0.0", "0.0"],
        ["", "2.0", ""],
        ["1.0", "", "2.0"],
        ["2.0", "", "4.0"],
        ["", "1.0", ""],
        ["3.0", "3.0", "6.0"],
    ]


def test_formula_continues_over_a_delay_of_recording(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    messages: List[Any] = [("/y", Float64(1.0), 150 * 10**6)]
    for place in (0, 10, 20, 30, 40, 200, 210):
        message = PointStamped()
        message.header.stamp = genpy.Time(0, BEGIN + place * 10**6)
        messages.append(("/p", message, place * 10**6))
    bag = write_bag(tmp_path / "p.bag", messages)
    monkeypatch.chdir(tmp_path)
    call(monkeypatch, bag, "=/y/data + /p/point/x", "-o", "out.csv")
    assert Path("out.csv").read_text().splitlines()[1:] == ["0.150000000,1.0"]


def test_corrections_are_reported(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    messages: List[Any] = []
    for index in range(20):
        message = PointStamped()
        message.header.stamp = genpy.Time(0, BEGIN + index * 10**8)
        messages.append(("/p", message, index * 10**8 + 8 * 10**8))
    bag = write_bag(tmp_path / "p.bag", messages)
    monkeypatch.chdir(tmp_path)
    call(monkeypatch, bag, "/p/point/x", "=2 * /p/point/x", "/p/point/x@stamp", "-o", "out.svg")
    words = "stamps 0.80 s behind: shown at reception"
    said = capsys.readouterr().err.splitlines()
    assert said == [f"plot_bag: {name}: {words}" for name in ("/p/point/x", "=2 * /p/point/x")]
    assert Path("out.svg").read_text().count(f"({words})") == 2


def test_formula_errors_are_reported(
    bag: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    assert failure(monkeypatch, capsys, bag, "=/x +", "-o", "out.csv") == (
        "plot_bag: unexpected end of the formula\n"
    )
    assert "similar names: /x/data" in failure(monkeypatch, capsys, bag, "=/x/datum", "-o", "o.csv")


def ramp(path: Path, start: float) -> str:
    """Record a ramp from 0 to 1 that starts some time after the bag, and takes 1 s."""
    values = [min(max(0.1 * index - start, 0.0), 1.0) for index in range(40)]
    return write_bag(
        path, [("/x", Float64(one), index * 10**8) for index, one in enumerate(values)]
    )


def drawn(monkeypatch: "pytest.MonkeyPatch", *arguments: str) -> List[Any]:
    """Return the series of a picture."""
    pictures: List[Any] = []
    monkeypatch.setattr(plot, "draw", pictures.append)
    monkeypatch.setattr(plot, "save", lambda _figure, path, _format: Path(path).touch())
    call(monkeypatch, *arguments, "-o", "out.svg")
    return list(pictures[0])


def test_another_bag_is_overlaid_with_an_offset(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.chdir(tmp_path)
    new, old = ramp(tmp_path / "new.bag", 1.0), ramp(tmp_path / "old.bag", 1.75)
    first, over = drawn(monkeypatch, new, "/x", "--over", old, "--offset=-0.75")
    assert (first.name, over.name) == ("/x/data", "/x/data (old.bag)")
    assert first.times[0] == 0.0 and over.times[0] == -0.75
    other = drawn(monkeypatch, new, "=2*/x", "--over", old, "--over", new, "--offset", "3")
    assert [one.times[0] for one in other] == [0.0, 3.0, 0.0]
    _, moved = drawn(monkeypatch, new, "/x", "--over", old, "--offset", "3", "--align", "/x", "0.5")
    assert moved.times[0] == pytest.approx(0.75)
    assert other[1].name == "=2 * /x/data (old.bag)"


def test_bags_are_aligned_where_a_field_rises_through_a_level(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.chdir(tmp_path)
    new, old = ramp(tmp_path / "new.bag", 1.0), ramp(tmp_path / "old.bag", 1.75)
    first, over = drawn(monkeypatch, new, "/x", "--over", old, "--align", "/x", "0.5")
    assert first.times[0] == pytest.approx(-1.5) and over.times[0] == pytest.approx(-2.25)
    for one in (first, over):
        assert numpy.interp(0.0, one.times, one.values) == pytest.approx(0.5)
    aligned = [new, "/x", "--align", "/x"]
    said = failure(monkeypatch, capsys, *aligned, "2", "-o", "o.png")
    assert said == "plot_bag: /x/data does not rise through 2 in this time\n"
    said = failure(monkeypatch, capsys, *aligned, "high", "-o", "o.png")
    assert said == "plot_bag: --align: 'high' is not a level\n"
    point = write_bag(tmp_path / "p.bag", [("/p", Point(), 0), ("/p", Point(), 10**8)])
    said = failure(monkeypatch, capsys, point, "/p/x", "--align", "/p", "0.5", "-o", "o.png")
    assert said == "plot_bag: --align: /p denotes /p/x, /p/y, /p/z; name one of them\n"
    said = failure(monkeypatch, capsys, new, "/x", "--offset", "1", "-o", "o.png")
    assert said == "plot_bag: 1 --offset for 0 --over; give one for each\n"
    said = failure(monkeypatch, capsys, new, "/x", "--over", old, "-o", "o.csv")
    assert said == "plot_bag: --over and --align do not apply to a .csv, which holds one bag\n"
    assert "no.bag: No such file" in failure(
        monkeypatch, capsys, new, "/x", "--over", "no.bag", "-o", "o.png"
    )
