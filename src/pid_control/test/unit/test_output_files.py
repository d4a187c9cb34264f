"""Tests of writing output files."""

import errno
import pathlib
from typing import Callable

import pytest

from pid_control.output_files import check_writable, write_file


@pytest.mark.parametrize("write", [check_writable, lambda path: write_file(path, "text")])
@pytest.mark.parametrize(
    "name, number, text",
    [
        ("folder", errno.EISDIR, "Is a directory"),
        ("no/a", errno.ENOENT, "No such file or directory"),
    ],
)
def test_file_that_cannot_be_written_is_named_and_nothing_is_left(
    write: Callable[[str], None], name: str, number: int, text: str, tmp_path: pathlib.Path
) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError) as failed:
        write(str(tmp_path / name))
    error = failed.value
    assert (error.errno, error.strerror, error.filename) == (number, text, str(tmp_path / name))
    assert [path.name for path in tmp_path.rglob("*")] == ["folder"]


def test_write_file_replaces_what_the_check_leaves_as_it_is(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "file"
    path.write_text("a longer text, of before")
    check_writable(str(path))
    assert path.read_text() == "a longer text, of before"
    write_file(str(path), "± of \udce9\n")
    assert path.read_bytes() == b"\xc2\xb1 of \\udce9\n"
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
