"""ROS 2 recordings against the written messages, and errors of damaged ones."""

import os
import re
import sqlite3
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy
import pytest
import written
from written import BEGIN, ODD

from topic_scope.bag import ros2_recording
from topic_scope.bag.columns import all_columns
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.opening import open_bag
from topic_scope.bag.player import BagPlayer
from topic_scope.bag.recording import BagError, Recording
from topic_scope.bag.ros2_types import Ros2Type, TypeProblem
from topic_scope.messages.decoding import Decoder, ElementMissing
from topic_scope.messages.fields import Key

KINDS = [("MCAP", ""), ("MCAP", "STORAGE"), ("SQLITE3", ""), ("SQLITE3", "MESSAGE")]


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: "-".join(filter(None, kind)))
def recording(request: Any, tmp_path_factory: Any) -> str:
    """Write a recording of each format, once."""
    return written.write(
        tmp_path_factory.mktemp("bags") / "run", written.messages(), *request.param
    )


def told_of(bag: Recording, *span: int) -> Dict[str, List[Tuple[int, bytes]]]:
    """Return time since the start [ns] and bytes of all messages, in order of reading."""
    found: Dict[str, List[Tuple[int, bytes]]] = {}
    for together in slices(bag, [one.topic for one in bag.connections.values()], *span):
        for one in together:
            found.setdefault(one.topic, []).extend(zip(one.times.tolist(), one.messages))
    return found


def value_in(message: Any, path: Tuple[Any, ...]) -> Any:
    """Return the value at a path of a ROS 2 message; None for a missing element."""
    for part in path:
        if isinstance(part, Key):
            part = message.name.index(part)
        if isinstance(part, int) and part >= len(message):
            return None
        message = message[part] if isinstance(part, int) else getattr(message, part)
    return message


def test_every_value_equals_the_written_one(recording: str) -> None:
    expected, compared = written.by_topic(written.messages()), 0
    with open_bag(recording) as bag:
        first, found = first_messages(bag), told_of(bag)
        assert (bag.faults, bag.lost, sorted(first)) == ({}, [], ["/odd", "/rare", "/x"])
        assert (bag.start, bag.length) == (BEGIN, 39 * 10**8 + 10)
        assert bag.count(["/odd", "/rare"]) == 44
    for column in all_columns(first):
        if column.path[-1] == "seq":
            continue  # not in ROS 2
        decoder = Decoder(first[column.topic].layout, column.path)
        rows = zip(found[column.topic], expected[column.topic])
        for (time, data), (when, message) in rows:
            assert time == when
            try:
                value = decoder.value(data)
            except ElementMissing:
                value = None
            place = column.path
            wanted = value_in(message, tuple(one for one in place if not isinstance(one, Key)))
            if hasattr(wanted, "nanosec"):
                wanted = wanted.sec * 10**9 + wanted.nanosec
            if place == ("raw",):
                wanted %= 256
            assert value == wanted, column.name
            compared += 1
    assert compared > 400
    assert [len(one) for one in found.values()] == [len(expected[topic]) for topic in found]


def test_spans_hold_each_message_once(recording: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    with open_bag(recording) as bag:
        whole, part = told_of(bag), told_of(bag, 10**9, 2 * 10**9)
    monkeypatch.setattr(ros2_recording, "_SPAN_MESSAGES", 7)
    with open_bag(recording) as bag:
        numbers, starts = bag.chunks_after(0)
        assert len(numbers) == 12 and starts == sorted(starts) and starts[0] == BEGIN
        assert told_of(bag) == whole
        assert told_of(bag, 10**9, 2 * 10**9) == part
    assert part["/x"] == [one for one in whole["/x"] if 10**9 <= one[0] <= 2 * 10**9]
    assert len(part["/x"]) == 11


def test_player_has_the_latest_of_rare_topics_besides(
    recording: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(ros2_recording, "_SPAN_MESSAGES", 7)
    with open_bag(recording) as bag:
        player = BagPlayer(bag, 0.1, lambda: 0.0)
        player.want(["/x"])
        player.aside.want(["/rare"])
        player.seek(player.start + 3.2)  # 0.9 s and some spans after the latest message
        while player.is_loading:
            player.now()
        *_, batch = player.aside.subscriptions()["/rare"].drain()
        assert Decoder(first_messages(bag)["/rare"].layout, ("data",)).value(
            batch.messages[-1]
        ) == (2**53 + 24)
        times = [t for one in player.subscriptions()["/x"].drain() for t in one.times]
        assert len(times) == 1 and not player.problems


def test_single_files_are_recordings(recording: str) -> None:
    (path,) = [*Path(recording).glob("*.mcap"), *Path(recording).glob("*.db3")]
    with open_bag(str(path)) as bag, open_bag(recording) as folder:
        assert told_of(bag) == told_of(folder)


def test_folder_need_not_say_what_is_in_its_files(tmp_path: Path) -> None:
    """In real recordings, times and settings in metadata.yaml may differ from the files."""
    path = Path(written.write(tmp_path / "run", written.messages()))
    with open_bag(str(path)) as bag:
        whole = told_of(bag)
    metadata = path / "metadata.yaml"
    text = metadata.read_text()
    text = re.sub(
        r"nanoseconds_since_epoch: \d+", f"nanoseconds_since_epoch: {BEGIN + 10**9}", text
    )
    text = re.sub(r"offered_qos_profiles: .*", "offered_qos_profiles: []", text)
    metadata.write_text(text.replace("nanoseconds: 3900000010", "nanoseconds: 5"))
    with open_bag(str(path)) as bag:
        assert told_of(bag) == whole
    metadata.write_text("rosbag2: [")
    (file,) = path.glob("*.mcap")
    with open_bag(str(file)) as bag:
        assert told_of(bag) == whole
    metadata.unlink()
    with open_bag(str(path)) as bag:
        assert told_of(bag) == whole
    stored = Path(written.write(tmp_path / "stored", written.messages(), "SQLITE3"))
    (stored / "metadata.yaml").unlink()
    with open_bag(str(stored)) as bag:
        assert told_of(bag) == whole


def test_settings_of_another_recording_do_not_apply_to_a_file(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4)))
    (file,) = path.glob("*.mcap")
    other = path / "other.mcap"
    other.write_bytes(file.read_bytes())
    with open_bag(str(file)) as bag:
        whole = told_of(bag)
    metadata = path / "metadata.yaml"
    metadata.write_text(
        re.sub("compression_mode: .*", "compression_mode: FILE", metadata.read_text())
    )
    with pytest.raises(BagError, match="its files are compressed"):
        open_bag(str(file))
    with open_bag(str(other)) as bag:
        assert told_of(bag) == whole


def test_compression_is_read_in_any_case_and_must_be_known(tmp_path: Path) -> None:
    """ROS 2 writes the mode in capital letters."""
    path = Path(written.write(tmp_path / "run", written.messages(4), "SQLITE3", "MESSAGE"))
    metadata = path / "metadata.yaml"
    with open_bag(str(path)) as bag:
        whole = told_of(bag)
    text = re.sub("compression_mode: .*", "compression_mode: MESSAGE", metadata.read_text())
    metadata.write_text(text)
    with open_bag(str(path)) as bag:
        assert told_of(bag) == whole
    metadata.write_text(re.sub("compression_format: .*", "compression_format: lz4", text))
    with pytest.raises(BagError, match="its files are compressed by lz4"):
        open_bag(str(path))


def test_compressed_messages_are_read_without_metadata_but_for_broken_ones(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4), "SQLITE3", "MESSAGE"))
    with open_bag(str(path)) as bag:
        whole = told_of(bag)
    (path / "metadata.yaml").unlink()
    (file,) = path.glob("*.db3")
    with open_bag(str(file)) as bag:
        assert told_of(bag) == whole
    with sqlite3.connect(str(file)) as database:
        broken = "UPDATE messages SET data = substr(data, 1, 9) WHERE timestamp = ?"
        database.execute(broken, [BEGIN + 10**8])
    with open_bag(str(file)) as bag:
        found = told_of(bag)
        assert found["/odd"] == whole["/odd"]
        assert found["/x"] == [whole["/x"][0], (10**8, b""), *whole["/x"][2:]]
        (note,) = bag.notes
    assert "/x: messages that do not fit their definition are left out: it cannot be decom" in note


def test_bad_definition_affects_only_its_topic(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4)))
    (file,) = path.glob("*.mcap")
    content = file.read_bytes()
    file.write_bytes(content.replace(b"uint16[] many", b"uint16[? many"))
    with open_bag(str(file)) as bag:
        assert sorted(first_messages(bag)) == ["/rare", "/x"]
        assert list(bag.faults) == ["/odd"]
        assert bag.faults["/odd"].startswith("its definition cannot be read: Could not parse")
        assert "\n" not in bag.faults["/odd"] and len(bag.faults["/odd"]) < 200
        assert sorted(told_of(bag)) == ["/rare", "/x"]


def test_message_that_does_not_fit_its_definition_is_left_out(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4), "SQLITE3"))
    (file,) = path.glob("*.db3")
    with sqlite3.connect(str(file)) as database:
        times = [BEGIN + 10**8, BEGIN + 2 * 10**8]
        database.execute(
            "UPDATE messages SET data = x'00010000ff' WHERE timestamp IN (?, ?)", times
        )
    with open_bag(str(file)) as bag:
        layout = first_messages(bag)["/x"].layout
        values = Decoder(layout, ("data",)).decode([data for _, data in told_of(bag)["/x"]])
    assert values.tolist()[::3] == [0.0, 1.5] and numpy.isnan(values[1:3]).all()
    with open_bag(str(file)) as bag:
        player = BagPlayer(bag, 10.0, lambda: 0.0)
        player.want(["/x"])
        player.seek(player.end)
        while player.is_loading:
            player.now()
    (problem,) = player.problems
    assert problem.startswith(
        f"{file}: /x: messages that do not fit their definition are left out: "
    )


def test_type_without_a_definition_is_the_standard_type(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4), "SQLITE3"))
    (file,) = path.glob("*.db3")
    with sqlite3.connect(str(file)) as database:  # as up to Humble
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3")
    with open_bag(str(file)) as bag:
        assert sorted(first_messages(bag)) == ["/rare", "/x"]
        assert bag.faults == {
            "/odd": f"its definition cannot be read: the recording has no definition of {ODD}"
        }


def test_topics_of_a_file_are_named_or_rejected_one_by_one(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4), "SQLITE3"))
    (file,) = path.glob("*.db3")
    with sqlite3.connect(str(file)) as database:
        database.execute("UPDATE topics SET name = 'x' WHERE name = '/x'")
        database.execute("UPDATE topics SET serialization_format = 'json' WHERE name = '/odd'")
        rare = "SELECT id FROM topics WHERE name = '/rare'"
        database.execute(f"DELETE FROM messages WHERE topic_id = ({rare})")
    with open_bag(str(file)) as bag:
        assert list(first_messages(bag)) == ["/x"] and len(told_of(bag)["/x"]) == 4
        text = "its definition cannot be read: its messages are in json, not CDR"
        assert bag.faults == {"/odd": text}  # and /rare is not in it


DEFINITION = f"""\
char A=1
char B=2
char kind
int32 C=3
int32 x
int32 y
a/Inner one
a/Inner[2] class
{"=" * 80}
MSG: a/Inner
float64[<=3] values
"""


def test_definition_in_ros1_has_constants_where_their_field_is_sure() -> None:
    assert Ros2Type("a/msg/B", "MSG", DEFINITION, "humble").definition == (
        "uint8 A=1\nuint8 B=2\nuint8 kind\nint32 x\nint32 y\na/Inner one\na/Inner[2] class\n"
        f"{'=' * 80}\nMSG: a/Inner\nfloat64[] values\n"
    )


@pytest.mark.parametrize("language", ["NONE", "MSG"])
def test_standard_type_is_that_of_the_distribution(language: str) -> None:
    name = "geometry_msgs/msg/VelocityStamped"  # new after Humble
    assert "frame_id" in Ros2Type(name, language, "", "jazzy").definition
    for distribution in ("humble", "unknown"):
        with pytest.raises(TypeProblem, match="the recording has no definition of geometry_msgs"):
            Ros2Type(name, language, "", distribution)


def open_files(folder: Path) -> List[str]:
    """Return the files in a folder that this process has open."""
    links = [f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd")]
    return [one for one in map(os.path.realpath, links) if one.startswith(f"{folder}/")]


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
def test_closed_or_rejected_recording_leaves_no_file_open(tmp_path: Path, storage: str) -> None:
    path = written.write(tmp_path / "run", written.messages(4), storage)
    bag = open_bag(path)
    assert open_files(tmp_path)
    bag.close()
    assert not open_files(tmp_path)
    with pytest.raises(BagError) as caught:
        open_bag(written.write(tmp_path / "empty", [], storage))
    assert str(caught.value) and not open_files(tmp_path)


def test_calls_of_services_are_named_as_that() -> None:
    """Recordings of `ros2 bag record --all` hold them, with the definition of the service."""
    with pytest.raises(TypeProblem, match="^calls of a service cannot be shown$"):
        Ros2Type("odd_msgs/srv/Add_Event", "MSG", "int64 a\n---\nint64 sum\n", "jazzy")


@pytest.mark.parametrize("part", [0.01, 0.5, 0.99])
def test_truncated_file_is_rejected(tmp_path: Path, part: float) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4)))
    (file,) = path.glob("*.mcap")
    file.write_bytes(file.read_bytes()[: int(part * file.stat().st_size)])
    with pytest.raises(BagError) as caught:
        open_bag(str(file))
    assert str(caught.value).startswith(f"{file} cannot be read: ")


def test_broken_chunk_is_named(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4), "MCAP", "STORAGE"))
    (file,) = path.glob("*.mcap")
    content = bytearray(file.read_bytes())
    place = content.index(b"\x28\xb5\x2f\xfd") + 20  # zstd's own mark
    content[place : place + 40] = b"\xff" * 40
    file.write_bytes(bytes(content))
    with open_bag(str(file)) as bag:
        assert first_messages(bag) == {}
        assert all("its messages cannot be read" in text for text in bag.faults.values())
        assert told_of(bag) == {} and len(bag.lost) == 1


def test_folder_with_a_missing_file_is_rejected(tmp_path: Path) -> None:
    path = Path(written.write(tmp_path / "run", written.messages(4)))
    (file,) = path.glob("*.mcap")
    file.rename(tmp_path / "other.mcap")
    with pytest.raises(BagError, match=f"{file.name} is missing, which its metadata.yaml names"):
        open_bag(str(path))
    (path / "metadata.yaml").write_text("rosbag2: [\n")
    with pytest.raises(BagError, match="its metadata.yaml cannot be read"):
        open_bag(str(path))


def test_empty_recording_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(BagError, match="holds no messages"):
        open_bag(written.write(tmp_path / "run", [], "SQLITE3"))


def test_first_message_that_does_not_fit_is_left_out(tmp_path: Path) -> None:
    path = written.write(tmp_path / "run", written.messages(), "SQLITE3")
    (file,) = Path(path).glob("*.db3")
    with sqlite3.connect(str(file)) as database:
        one = "SELECT min(messages.id) FROM messages JOIN topics ON topic_id = topics.id"
        database.execute(f"UPDATE messages SET data = x'00' WHERE id = ({one} AND name = '/x')")
    with open_bag(path) as bag:
        assert "/x" in first_messages(bag) and not bag.faults
        assert [data for _, data in told_of(bag)["/x"]].count(b"") == 1


def test_file_that_the_metadata_does_not_name_is_read_too(tmp_path: Path) -> None:
    sent = written.messages()
    with open_bag(written.write(tmp_path / "whole", sent)) as bag:
        whole = told_of(bag)
    path = written.write(tmp_path / "run", sent[10:])
    earlier = written.write(tmp_path / "earlier", sent[:10])
    (file,) = Path(earlier).glob("*.mcap")
    file.rename(Path(path) / "run_1.mcap")
    with open_bag(path) as bag:
        assert bag.count(["/x", "/odd", "/rare"]) == len(sent)
        assert told_of(bag) == whole  # in time order


CODE = '__import__("os").environ.__setitem__("EXECUTED", "1")'


@pytest.mark.parametrize(
    "name, text",
    [
        (f'a/msg/B"""\n    {CODE}\n    """', "int32 x\n"),
        (f"a/msg/B:\n    {CODE}\n    #", "int32 x\n"),
        (f"a/msg/B({CODE})", "int32 x\n"),
        ("a/msg/B", f"int32 x\n{'=' * 80}\nMSG: a/C({CODE})\nint32 y\n"),
        ("a/msg/B", f"a/C({CODE}) x\n"),
        ("a/msg/B", f"int32 x=[{CODE}]\n"),
    ],
)
def test_code_in_a_definition_is_rejected_and_not_executed(
    monkeypatch: "pytest.MonkeyPatch", name: str, text: str
) -> None:
    monkeypatch.delenv("EXECUTED", raising=False)
    with pytest.raises(TypeProblem):
        Ros2Type(name, "MSG", text, "humble")
    assert "EXECUTED" not in os.environ
