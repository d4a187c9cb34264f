"""Replay of CSV files, and the error messages for invalid ones."""

import os
import socket
import time
from unittest import mock

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.signals import replay
from basic_comms.signals.replay import Series, SeriesError, load_series

RECORDING = Series([10.0, 11.0, 13.0], [0.0, -4.0, 8.0])


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a file and returns its path."""

    def write_file(content):
        path = tmp_path / "series.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    return write_file


def played(series, times, hold=False, loop=False):
    return [series.peak * series.value(time, hold, loop) for time in times]


def test_linear_replay_starts_with_the_first_row_and_keeps_the_last_value():
    expected = [0.0, -2.0, -4.0, 2.0, 8.0, 8.0]
    assert played(RECORDING, [0.0, 0.5, 1.0, 2.0, 3.0, 99.0]) == pytest.approx(expected)


def test_before_the_first_row_its_value_holds():
    series = Series([0.0, 1.0], [2.0, 5.0])
    assert played(series, [-0.5]) == played(series, [-0.5], hold=True) == [2.0]


def test_hold_keeps_each_value_until_the_next_row():
    times = [0.0, 0.999, 1.0, 2.999, 3.0, 99.0]
    assert played(RECORDING, times, hold=True) == [0.0, 0.0, -4.0, -4.0, 8.0, 8.0]


def test_a_loop_has_its_first_row_again_at_the_time_of_the_last():
    assert played(RECORDING, [3.0, 3.5, 31.0], loop=True) == pytest.approx([0.0, -2.0, -4.0])
    assert played(RECORDING, [3.0, 3.5, 31.0], hold=True, loop=True) == [0.0, 0.0, -4.0]


def test_sample_times_that_are_rounded_hit_the_rows_and_the_end_of_the_loop():
    rows = 30
    series = Series([n / 10 for n in range(rows + 1)], [float(n % rows) for n in range(rows + 1)])
    times = [n * 0.1 for n in range(10 * rows)]
    expected = [float(n % rows) for n in range(10 * rows)]
    assert played(series, times, hold=True, loop=True) == pytest.approx(expected)
    assert played(series, times, loop=True) == pytest.approx(expected, abs=1e-6)


def test_a_loop_hits_its_first_row_also_if_the_rounded_time_is_just_before_it():
    series = Series([0.0, 0.05, 0.1], [1.0, 2.0, -3.0])
    assert 0.3 % 0.1 < 0.1 < 0.3 % 0.1 + 1e-15
    assert played(series, [0.3], loop=True) == pytest.approx([1.0])
    assert played(series, [0.3], hold=True, loop=True) == pytest.approx([1.0])


def test_a_single_row_and_a_series_of_zeros_are_constants():
    assert played(Series([5.0], [-3.0]), [0.0, 9.0], loop=True) == [-3.0, -3.0]
    assert played(Series([0.0, 1.0], [0.0, 0.0]), [0.5]) == [0.0]


def test_a_series_without_rows_is_an_error():
    with pytest.raises(ValueError, match="rows"):
        Series([], [])


rows = st.lists(
    st.tuples(st.floats(-1e300, 1e300), st.floats(allow_nan=False, allow_infinity=False)),
    min_size=1,
    max_size=20,
    unique_by=lambda row: row[0],
).map(sorted)


@given(rows, st.floats(0.0, 1e300), st.booleans(), st.booleans())
def test_any_series_stays_within_one(series_rows, elapsed, hold, loop):
    series = Series(*zip(*series_rows))
    assert -1.0 <= series.value(elapsed, hold, loop) <= 1.0


@given(st.floats(0.0, 3.0))
def test_linear_replay_equals_numpy(elapsed):
    expected = numpy.interp(elapsed, [0.0, 1.0, 3.0], [0.0, -4.0, 8.0])
    assert played(RECORDING, [elapsed]) == pytest.approx([expected])


@pytest.mark.parametrize(
    "content",
    [
        "0,1\n0.5,-2.5\n",
        "time,value\n0,1\n0.5,-2.5\n",
        "# a comment\n\ntime [s], value [V]\n0 , 1\n# another\n 5e-1,\t-2.5",
        b"\xef\xbb\xbf0,1\r\n0.5,-2.5\r\n",
        "1700000000.0,1\n1700000000.5,-2.5\n",
    ],
)
def test_files_in_their_usual_forms_are_read(write, content):
    series = load_series(write(content))
    assert len(series) == 2
    assert series.duration == 0.5
    assert series.peak == 2.5
    assert played(series, [0.0, 0.25, 0.5]) == pytest.approx([1.0, -0.75, -2.5])


@pytest.mark.parametrize(
    "content, words",
    [
        ("", "series.csv: no rows"),
        ("# only this\ntime,value\n", "series.csv: no rows"),
        ("0,1\n1,x\n", "series.csv, line 2: '1,x'; two finite numbers"),
        ("0,1\ntime,value\n", "series.csv, line 2: 'time,value'; two finite numbers"),
        ("time,value\nunit,unit\n0,1\n", "series.csv, line 2: 'unit,unit'; two finite"),
        ("time,1\n", "series.csv, line 1: 'time,1'; two finite numbers"),
        ("0,1\n1\n", "series.csv, line 2: '1'; two finite numbers"),
        ("0,1,2\n", "series.csv, line 1: '0,1,2'; two finite numbers"),
        ("0,nan\n", "series.csv, line 1: '0,nan'; two finite numbers"),
        ("inf,1\n", "series.csv, line 1: 'inf,1'; two finite numbers"),
        ("0,1\n\n# x\n0,2\n", "series.csv, line 4: time 0.0 after 0.0; times must increase"),
        ("1,1\n0.5,2\n", "series.csv, line 2: time 0.5 after 1.0; times must increase"),
        ("0,__import__('os')\n", "two finite numbers"),
        pytest.param("0," + "9" * 9999, "9...'; two finite numbers", id="long line"),
        ("0," + "x" * 38, f"line 1: '0,{'x' * 38}'; two finite"),
        ("0," + "x" * 39, f"line 1: '0,{'x' * 35}...'; two finite"),
        (b"\xff\xfe0,1\n", "series.csv: not UTF-8 text"),
    ],
)
def test_malformed_file_is_rejected_with_name_line_and_format(write, content, words):
    with pytest.raises(SeriesError) as refusal:
        load_series(write(content))
    assert words in str(refusal.value)
    assert len(str(refusal.value)) < 300


@pytest.mark.parametrize("name", ["", "missing.csv", "null\0.csv", "\udc80.csv\0"])
def test_a_missing_file_is_refused(tmp_path, name):
    with pytest.raises(SeriesError, match="no such file"):
        load_series(str(tmp_path / name) if name else "")


def test_non_regular_file_is_rejected_by_type_without_opening(tmp_path):
    os.mkfifo(tmp_path / "pipe")  # to open it would wait for a writer
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "socket"))
        for path, kind in [
            (tmp_path, "a folder"),
            (tmp_path / "pipe", "a FIFO"),
            (tmp_path / "socket", "a socket"),
            (os.devnull, "a device"),
        ]:
            with pytest.raises(SeriesError, match=f"^{path}: this is {kind}; a CSV file of time"):
                load_series(str(path))


def test_a_file_behind_a_file_is_refused_with_the_reason(write):
    with pytest.raises(SeriesError, match="cannot be read: Not a directory"):
        load_series(write("0,1\n") + "/series.csv")


def test_a_file_that_is_too_long_or_too_big_is_refused(write, monkeypatch):
    path = write("0,1\n1,1\n2,1\n")
    monkeypatch.setattr(replay, "LARGEST_LINES", 3)
    monkeypatch.setattr(replay, "LARGEST_BYTES", 12)
    assert len(load_series(path)) == 3
    monkeypatch.setattr(replay, "LARGEST_LINES", 2)
    with pytest.raises(SeriesError, match="series.csv: too long; at most 2 lines are allowed"):
        load_series(path)
    monkeypatch.setattr(replay, "LARGEST_BYTES", 11)
    with pytest.raises(SeriesError, match="series.csv: 12 bytes; at most 11 are allowed"):
        load_series(path)


def test_the_size_is_looked_at_before_anything_is_read(tmp_path, monkeypatch):
    path = tmp_path / "series.csv"
    with open(path, "wb") as file:
        file.truncate(40_000_000)
    monkeypatch.setattr("builtins.open", None)
    with pytest.raises(SeriesError, match="series.csv: 40000000 bytes; at most 8000000"):
        load_series(str(path))


def test_file_without_size_is_read_up_to_limit():
    with pytest.raises(SeriesError, match="/proc/self/stat: 12 bytes; at most 11"):
        with mock.patch.object(replay, "LARGEST_BYTES", 11):
            load_series("/proc/self/stat")


@pytest.mark.parametrize(
    "lines",
    [
        [f"{1.7e9 + n:.6f},{n * 1e-7:.16f}\n" for n in range(replay.LARGEST_LINES)],
        ["\n"] * replay.LARGEST_BYTES,
        ["# nothing\n"] * (replay.LARGEST_BYTES // 10),
        [","] * replay.LARGEST_BYTES,
        ["0,", "9" * (replay.LARGEST_BYTES - 2)],
    ],
    ids=["rows", "blank lines", "comments", "commas", "digits"],
)
def test_the_largest_file_takes_well_below_a_second(write, lines):
    path = write("".join(lines))
    assert os.path.getsize(path) <= replay.LARGEST_BYTES
    began = time.thread_time()  # of this thread alone, whatever else the machine does
    try:
        assert len(load_series(path)) == replay.LARGEST_LINES
    except SeriesError as error:
        assert len(str(error)) < 300
    assert time.thread_time() - began < 0.8


@pytest.mark.parametrize(
    "heading",
    ["time,value", '"t [s]", "U [V]"', "%time,field.data", "time,/signal/signal_y", "t,é"],
)
def test_a_heading_is_two_names(write, heading):
    assert len(load_series(write(heading + "\n0,1\n"))) == 1


@pytest.mark.parametrize(
    "line",
    ["0;1", "0 1", "0.1s,5V", "\N{MINUS SIGN}1,\N{MINUS SIGN}2", "value", "a,b,c", ",", "a,"],
)
def test_a_first_line_that_is_no_heading_is_not_passed_over(write, line):
    with pytest.raises(SeriesError) as refusal:
        load_series(write("# times\n" + line + "\n1,1\n"))
    assert str(refusal.value).endswith(
        f"series.csv, line 2: {line!r}; two finite numbers, time,value, are allowed, or "
        "a heading of two names"
    )


def test_a_file_that_cannot_be_opened_is_refused(write, monkeypatch):
    def refuse(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    path = write("0,1\n")
    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(SeriesError, match="cannot be read: Permission denied"):
        load_series(path)


def test_the_home_directory_may_be_shortened(write, monkeypatch):
    path = write("0,1\n")
    monkeypatch.setenv("HOME", os.path.dirname(path))
    assert len(load_series("~/series.csv")) == 1
