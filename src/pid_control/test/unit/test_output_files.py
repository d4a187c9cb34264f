"""Tests of writing output files."""

import pathlib

import pytest

from pid_control.output_files import write_file


def test_write_file_that_fails_leaves_nothing_half_made(tmp_path: pathlib.Path) -> None:
    target = tmp_path / "folder"
    target.mkdir()
    with pytest.raises(OSError):
        write_file(str(target), "text")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]
