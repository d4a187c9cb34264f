"""Library for ROS 2 recordings: errors without it, and its installation."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, List

import pytest

from topic_scope.bag import rosbags_library
from topic_scope.bag.opening import open_bag
from topic_scope.bag.recording import BagError
from topic_scope.commands import fetch_rosbags, plot_bag


@pytest.fixture
def place(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> Path:
    """Return the empty folder of the library."""
    folder = tmp_path / "home" / "rosbags"
    monkeypatch.setattr(rosbags_library, "_places", lambda: [folder])
    monkeypatch.setattr("sys.path", list(sys.path))
    return folder


@pytest.mark.parametrize("begin", [b"\x89MCAP0\r\n", b"SQLite format 3\0", None])
def test_missing_library_is_reported_with_its_command(
    tmp_path: Path, place: Path, begin: Any, monkeypatch: "pytest.MonkeyPatch", capsys: Any
) -> None:
    path = tmp_path / "run"
    if begin is None:
        path.mkdir()
        (path / "metadata.yaml").touch()
    else:
        path.write_bytes(begin + b"\0" * 100)
    said = (
        f"{path} is a ROS 2 recording; fetch the library rosbags to read it: "
        "rosrun topic_scope fetch_rosbags.py"
    )
    with pytest.raises(BagError) as caught:
        open_bag(str(path))
    assert str(caught.value) == said
    monkeypatch.setattr("sys.argv", ["plot_bag.py", str(path), "/x", "-o", "out.csv"])
    with pytest.raises(SystemExit) as ended:
        plot_bag.main()
    assert (ended.value.code, capsys.readouterr().err) == (2, f"plot_bag: {said}\n")


def test_folder_without_recordings_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(BagError, match="Is a directory"):
        open_bag(str(tmp_path))


def run(folder: Path, status: int, output: str) -> Any:
    """Return a fake of subprocess.run: creates the environment, pip exits with a status."""

    def call(command: List[str], **_options: Any) -> None:
        if "pip" in command:
            if status:
                raise subprocess.CalledProcessError(status, command, output.encode())
            os.mkdir(command[command.index("--target") + 1])
            assert "--require-hashes" in command and not folder.exists()

    return call


def test_installation_is_atomic(
    place: Path, monkeypatch: "pytest.MonkeyPatch", capsys: Any
) -> None:
    monkeypatch.setattr("sys.argv", ["fetch_rosbags.py"])
    monkeypatch.setattr(subprocess, "run", run(place, 1, "Looking\nERROR: no matching hash\n"))
    with pytest.raises(SystemExit) as ended:
        fetch_rosbags.main()
    assert ended.value.code == (
        "fetch_rosbags: rosbags cannot be fetched from PyPI: ERROR: no matching hash"
    )
    assert list(place.parent.iterdir()) == []
    monkeypatch.setattr(subprocess, "run", run(place, 0, ""))
    fetch_rosbags.main()
    assert capsys.readouterr().out == f"fetch_rosbags: rosbags is in {place}\n"
    assert list(place.parent.iterdir()) == [place]
    monkeypatch.setattr(subprocess, "run", run(place, 1, "must not be called"))
    fetch_rosbags.main()
    rosbags_library.enter()
    assert sys.path[0] == str(place)
