"""Bags with unreadable topics, messages or chunks: the rest is read, and the loss is reported."""

import struct
from pathlib import Path
from typing import Any, Dict, List, Tuple

import genpy
import pytest
import rosbag
from bags import BEGIN, serialized, write_bag
from std_msgs.msg import Float64, Int32, Int64, String

from topic_scope.bag.columns import choose
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.overlay import BagOverlay
from topic_scope.bag.player import BagPlayer
from topic_scope.bag.ros1_recording import Ros1Recording
from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.commands import plot_bag
from topic_scope.messages.layout_cache import Layouts
from topic_scope.sampling.recorder import Recorder

Run = Tuple[int, str, str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: Any) -> Any:
    """Return a function that calls plot_bag: exit status, errors, and the CSV file."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> Run:
        monkeypatch.setattr("sys.argv", ["plot_bag.py", *arguments, "-o", "out.csv"])
        status = 0
        try:
            plot_bag.main()
        except SystemExit as end:
            status = int(str(end.code))
        written = Path("out.csv")
        return status, capsys.readouterr().err, written.read_text() if written.exists() else ""

    return call


def write_with_faults(path: Path) -> str:
    """Record a valid topic, a topic with a bad definition, and a topic that changes its type."""
    bad: Dict[str, str] = {"type": "a/A", "md5sum": "1" * 32, "message_definition": "float64[ x\n"}
    with rosbag.Bag(str(path), "w") as bag:
        for number in range(3):
            time = genpy.Time(0, BEGIN + number * 10**9)
            bag.write("/good", Float64(float(number)), time)
            bag.write("/bad", Float64(1.0), time, connection_header={"topic": "/bad", **bad})
            bag.write("/twice", Float64(1.0), time)
            # rosbag writes one type per name; other recorders may write several.
            bag.write("twice", Int32(1), time)
    return str(path)


def test_bad_topics_do_not_affect_others(tmp_path: Path, run: Any) -> None:
    path = write_with_faults(tmp_path / "x.bag")
    status, said, written = run(path, "/good")
    assert (status, said) == (0, "")
    assert written.splitlines()[1:] == ["0.000000000,0.0", "1.000000000,1.0", "2.000000000,2.0"]
    status, said, again = run(path, "/bad", "/good", "/twice/data")
    assert status == 1 and again == written
    bad, twice = said.splitlines()
    assert bad.startswith(f"plot_bag: {path}: /bad is left out: its definition cannot be read: ")
    assert twice == (
        f"plot_bag: {path}: /twice is left out: its messages change their type: "
        "std_msgs/Float64, std_msgs/Int32"
    )
    Path("out.csv").unlink()
    status, said, written = run(path, "=2*/bad/x")
    assert (status, written) == (2, "") and "/bad is left out" in said


def test_bad_definition_is_the_reason_why_its_trace_is_empty(tmp_path: Path) -> None:
    bag = Ros1Recording(write_with_faults(tmp_path / "x.bag"))
    layouts = Layouts()
    for connection in bag.connections.values():
        layouts.received(connection.header)
    recorder = Recorder(BagPlayer(bag, 10.0), layouts, 10.0)
    recorder.set_topics({"/bad": "a/A", "/good": "std_msgs/Float64"})
    recorder.want(["/bad/x", "/good/data"], 0.0)
    assert str(recorder.problem("/bad/x")).startswith("its definition cannot be read: ")
    assert recorder.problem("/good/data") is None
    bag.close()


def test_overlay_names_the_topics_that_it_lacks(tmp_path: Path) -> None:
    overlay = BagOverlay(write_with_faults(tmp_path / "x.bag"), "old")
    assert sorted(overlay.faults) == ["/bad", "/twice"]
    assert list(overlay.types) == ["/old/good"]


def write_with_a_broken_chunk(path: Path, number: int) -> str:
    """Record 40 messages of two topics in four chunks, and damage one chunk."""
    with rosbag.Bag(str(path), "w", compression="bz2", chunk_threshold=900) as bag:
        for index in range(40):
            time = genpy.Time(0, BEGIN + index * 10**8)
            bag.write("/x", Float64(float(index)), time)
            bag.write("/s", String("x" * 50), time)
    content = bytearray(path.read_bytes())
    place = -1
    for _ in range(number + 1):
        place = content.index(b"BZh", place + 1)
    content[place + 20 : place + 60] = b"\xff" * 40
    path.write_bytes(bytes(content))
    return str(path)


@pytest.mark.parametrize("number", [0, 1])
def test_damaged_chunk_loses_only_its_messages(tmp_path: Path, run: Any, number: int) -> None:
    path = write_with_a_broken_chunk(tmp_path / "x.bag", number)
    status, said, written = run(path, "/x")
    assert status == 1 and said.count("\n") == 1
    assert said.startswith(f"plot_bag: {path} is damaged (") and "rosbag reindex" in said
    values = [float(row.split(",")[1]) for row in written.splitlines()[1:]]
    lost = sorted(set(range(40)) - set(values))
    assert 0 < len(lost) < 20 and (lost[0] == 0) == (number == 0)
    assert lost == list(range(lost[0], lost[-1] + 1))
    span = ("--start", str(lost[0] / 10), "--end", str(lost[-1] / 10))
    status, said, _ = run(path, "/x", *span)
    assert status == 2 and said.startswith(f"plot_bag: {path} is damaged (")
    with Ros1Recording(path) as bag:
        found = first_messages(bag)["/x"].data
    assert found == serialized(Float64(float(lost[-1] + 1 if number == 0 else 0)))


def test_picture_says_that_a_part_is_missing(tmp_path: Path) -> None:
    overlay = BagOverlay(write_with_a_broken_chunk(tmp_path / "x.bag", 1), "old")
    (series,) = overlay.read(["/x/data"])
    assert series.correction == "1 damaged part of the bag left out"
    messages = [("/x", Int64(2**62), 0)]
    with Ros1Recording(write_bag(tmp_path / "y.bag", messages)) as bag:
        bag.lost += ["one", "two"]
        lines, readers = chosen(bag, first_messages(bag), ["/x"])
        (series,) = series_of(bag, lines, readers, slices(bag, ["/x"]))
    assert str(series.correction).startswith("whole numbers beyond 2**53")
    assert str(series.correction).endswith("; 2 damaged parts of the bag left out")


def test_picture_of_two_bags_reports_the_parts_that_each_lacks(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", capsys: Any
) -> None:
    first, second = (write_with_a_broken_chunk(tmp_path / f"{name}.bag", 1) for name in "xy")
    arguments = [
        first,
        "/x",
        "/x/data",
        "--over",
        second,
        "--over",
        first,
        "-o",
        str(tmp_path / "x.png"),
    ]
    monkeypatch.setattr("sys.argv", ["plot_bag.py", *arguments, "--align", "/x", "1.5"])
    with pytest.raises(SystemExit) as caught:
        plot_bag.main()
    lines = [one for one in capsys.readouterr().err.splitlines() if "is damaged" in one]
    assert caught.value.code == 1
    assert [one.split(" is damaged")[0] for one in lines] == [
        f"plot_bag: {path}" for path in (first, second)
    ]


def test_topic_whose_chunks_are_all_broken_is_a_fault(tmp_path: Path, run: Any) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w", compression="bz2", chunk_threshold=100) as bag:
        bag.write("/lost", String("x" * 200), genpy.Time(1))
        bag.write("/x", Float64(1.0), genpy.Time(2))
    content = bytearray(path.read_bytes())
    place = content.index(b"BZh") + 15
    content[place : place + 20] = b"\xff" * 20
    path.write_bytes(bytes(content))
    with Ros1Recording(str(path)) as bag:
        assert list(first_messages(bag)) == ["/x"]
        assert "is damaged (" in bag.faults["/lost"]
    assert run(str(path), "/x")[0] == 0


def test_truncated_message_is_left_out(tmp_path: Path, run: Any) -> None:
    with rosbag.Bag("x.bag", "w") as bag:
        for number, data in enumerate([b"\0" * 8, b"\0\0", b"\0", b"\0" * 8]):
            raw = (Float64._type, data, Float64._md5sum, Float64)
            bag.write("/x", raw, genpy.Time(1 + number), raw=True)
    status, said, written = run("x.bag", "/x", "=2*/x/data")
    assert status == 1
    assert said == "plot_bag: /x/data: 2 messages cut off: left out\n"
    rows = ["0.000000000,0.0,0.0", "1.000000000,,", "2.000000000,,", "3.000000000,0.0,0.0"]
    assert written.splitlines()[1:] == rows
    with Ros1Recording("x.bag") as bag:
        lines, readers = chosen(bag, first_messages(bag), ["/x"])
        series_of(bag, lines, readers, slices(bag, ["/x"]))
    assert readers[0].cut_off == "2 messages cut off: left out"


def test_notes_of_a_recording_are_reported(
    tmp_path: Path, monkeypatch: "pytest.MonkeyPatch", run: Any
) -> None:
    def opened(path: str) -> Ros1Recording:
        bag = Ros1Recording(path)
        bag.notes.append("1 message cannot be converted")
        return bag

    monkeypatch.setattr(plot_bag, "open_bag", opened)
    path = write_bag(tmp_path / "x.bag", [("/x", Float64(1.0), 0)])
    assert run(path, "/x")[:2] == (1, "plot_bag: 1 message cannot be converted\n")


def test_message_with_a_damaged_length_is_left_out(tmp_path: Path, run: Any) -> None:
    """All messages of a small bag are in one chunk."""
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w") as bag:
        for number in range(5):
            for topic in "/a", "/b":
                bag.write(topic, Float64(1000.5 + number), genpy.Time(1 + number))
    data = path.read_bytes()
    for number in 0, 2:
        message = struct.pack("<Id", 8, 1000.5 + number)
        place = data.index(message)  # of /a, which was written first
        data = data[:place] + struct.pack("<I", 2**31) + data[place + 4 :]
    path.write_bytes(data)
    with Ros1Recording(str(path)) as bag:
        assert first_messages(bag)["/a"].data == serialized(Float64(1001.5))
    status, _, written = run(str(path), "/b")
    assert status == 0 and [row.split(",")[1] for row in written.splitlines()[1:]] == [
        str(1000.5 + number) for number in range(5)
    ]
    status, said, written = run(str(path), "/a")
    assert (status, said) == (1, "plot_bag: /a/data: 2 messages cut off: left out\n")
    assert [row.split(",")[1] for row in written.splitlines()[1:]] == [
        "",
        "1001.5",
        "",
        "1003.5",
        "1004.5",
    ]


def names(path: str, *expressions: str) -> List[str]:
    """Return the names of the columns that expressions denote in a bag."""
    with Ros1Recording(path) as bag:
        return [column.name for column in choose(list(expressions), first_messages(bag))]


def test_topic_with_special_characters_is_quoted(tmp_path: Path, run: Any) -> None:
    messages: List[Any] = [
        (topic, Float64(value), time)
        for time in (0, 10**9)
        for topic, value in (("/ORB-SLAM", 1.5), ("/S-PTAM/a b", 2.0), ("/x", 0.5))
    ]
    path = write_bag(tmp_path / "x.bag", messages)
    assert names(path, "/ORB-SLAM", "ORB-SLAM/data", '"/S-PTAM/a b"/data') == [
        '"/ORB-SLAM"/data',
        '"/S-PTAM/a b"/data',
    ]
    formula, difference = '=2*"/ORB-SLAM"/data - /x/data', '"/S-PTAM/a b"/data-"/ORB-SLAM"/data'
    status, said, written = run(path, formula, difference)
    assert (status, said) == (0, "")
    assert written.splitlines() == [
        'time,"=2 * ""/ORB-SLAM""/data - /x/data","""/S-PTAM/a b""/data-""/ORB-SLAM""/data"',
        "0.000000000,2.5,",
        "0.000000000,,0.5",
        "1.000000000,2.5,",
        "1.000000000,,0.5",
    ]
    assert names(path, "ORB-SLAM/data.difference@received") == [
        '"/ORB-SLAM"/data.difference@received'
    ]
    status, said, _ = run(path, "/x/data-/ORB-SLAM/data")
    assert (status, '"/a-b"/field' in said) == (2, True)


def test_ambiguous_field_is_quoted(tmp_path: Path, run: Any) -> None:
    messages: List[Any] = [("/imu/data", Float64(1.0), 0), ("/imu/data/data", Float64(2.0), 10)]
    path = write_bag(tmp_path / "x.bag", messages)
    assert names(path, '"/imu/data"', "/imu/data/data", "/imu/data") == [
        '"/imu/data"/data',
        "/imu/data/data/data",
    ]
    _, _, written = run(path, '"/imu/data"/data', "/imu/data/data/data")
    assert written.splitlines()[1:] == ["0.000000000,1.0,", "0.000000010,,2.0"]
    overlay = BagOverlay(path, "old")
    recorder = Recorder(BagPlayer(Ros1Recording(path), 10.0), Layouts(), 10.0, [overlay])
    recorder.set_topics(overlay.types)
    listed = [choice.field for choice in recorder.choices()]
    assert listed == ['"/old/imu/data"/data', "/old/imu/data/data/data"]
    recorder.want(listed, 0.0)
    assert sorted(name for name, _ in overlay.take_wanted()) == [
        '"/imu/data"/data',
        "/imu/data/data/data",
    ]
