"""Commands with ROS 2 recordings: plots, CSV files, overlays on ROS 1 bags, masks."""

from pathlib import Path
from typing import Any, List

import genpy
import pytest
import rosbag
import written
from std_msgs.msg import Float64

from topic_scope.bag import plot
from topic_scope.bag.overlay import BagOverlay
from topic_scope.commands import mask, plot_bag
from topic_scope.protocol.options import parse


@pytest.fixture(scope="module")
def recording(tmp_path_factory: Any) -> str:
    return written.write(tmp_path_factory.mktemp("bags") / "run", written.messages())


@pytest.fixture
def old(tmp_path: Path) -> str:
    """Record half of the values of ``/x`` in a ROS 1 bag."""
    path = str(tmp_path / "old.bag")
    with rosbag.Bag(path, "w") as bag:
        for index in range(40):
            bag.write("/x", Float64(0.25 * index), genpy.Time(0, index * 10**8 + 10**9))
    return path


def call(monkeypatch: "pytest.MonkeyPatch", command: Any, *arguments: str) -> int:
    """Call a command; return its exit status."""
    monkeypatch.setattr("sys.argv", ["command", *arguments])
    try:
        command()
    except SystemExit as end:
        return int(end.code or 0) if not isinstance(end.code, str) else 1
    return 0


def test_csv_file_has_stamps_and_all_digits(
    recording: str, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    path = str(tmp_path / "out.csv")
    names = ["/odd/value@stamp", "/odd/three[2]@stamp", "/odd/waits[1]@stamp"]
    assert call(monkeypatch, plot_bag.main, recording, *names, "-o", path) == 0
    rows = Path(path).read_text().splitlines()
    assert len(rows) == 41
    # Stamps are 2 ms and 10 ns before the recording.
    assert rows[1] == f"-0.002000000,0.0,{2**60},"
    assert rows[3] == f"0.198000000,{2 / 3!r},{2**60 + 2},-0.500000000"


def test_ros1_and_ros2_recordings_are_overlaid(
    recording: str, old: str, tmp_path: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    pictures: List[Any] = []
    monkeypatch.setattr(plot, "draw", pictures.append)
    monkeypatch.setattr(plot, "save", lambda _figure, path, _format: Path(path).touch())
    arguments = ["/x", "--over", old, "--align", "/x", "2", "-o", str(tmp_path / "out.svg")]
    assert call(monkeypatch, plot_bag.main, recording, *arguments) == 0
    new_line, old_line = pictures[0]
    assert (new_line.name, old_line.name) == ("/x/data", "/x/data (old.bag)")
    assert new_line.times[4] == pytest.approx(0.0) and old_line.times[8] == pytest.approx(0.0)
    assert list(new_line.values) == [2 * one for one in old_line.values]


def test_overlay_of_the_scope_is_named_after_the_file(recording: str) -> None:
    (over,) = parse(["/x/data", "--over", f"{recording}/run.mcap"]).over
    assert (over.path, over.name) == (f"{recording}/run.mcap", "run")
    (over,) = parse(["/x/data", "--over", f"{recording}/"]).over
    assert over.name == "run"
    overlay = BagOverlay(recording, over.name)
    assert overlay.types["/run/odd"] == "odd_msgs/Odd"
    (series,) = overlay.read(["/odd/position[leg]"])
    assert list(series.values) == [float(index + 1) for index in range(1, 40, 2)]


@pytest.mark.parametrize(
    "limit, status, said", [("0.1", 1, "mask: 1 samples inside, 5 outside"), ("9", 0, "mask: 40 ")]
)
def test_mask_checks_a_recording(
    recording: str, limit: str, status: int, said: str, monkeypatch: Any, capsys: Any
) -> None:
    fields = ["/x/data", "--around", "=0.75*/x/data", "--value", limit]
    assert call(monkeypatch, mask.main, *fields, "--bag", recording) == status
    assert capsys.readouterr().out.startswith(said)
