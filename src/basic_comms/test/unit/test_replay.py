"""Replay of CSV files: what is played, and what is refused with which words."""

import os

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
        (b"\xff\xfe0,1\n", "series.csv: not UTF-8 text"),
    ],
)
def test_a_broken_file_is_refused_with_its_name_line_and_what_is_allowed(write, content, words):
    with pytest.raises(SeriesError) as refusal:
        load_series(write(content))
    assert words in str(refusal.value)
    assert len(str(refusal.value)) < 300


def test_a_missing_file_a_directory_and_a_device_are_refused(tmp_path):
    for path in ("", str(tmp_path / "missing.csv"), str(tmp_path), os.devnull):
        with pytest.raises(SeriesError, match="no such file"):
            load_series(path)


def test_a_file_that_is_too_long_or_too_big_is_refused(write, monkeypatch):
    path = write("0,1\n1,1\n2,1\n")
    monkeypatch.setattr(replay, "LARGEST_ROWS", 2)
    with pytest.raises(SeriesError, match="line 3: too long; at most 2 rows"):
        load_series(path)
    monkeypatch.setattr(replay, "LARGEST_BYTES", 11)
    with pytest.raises(SeriesError, match="too big; at most 11 bytes"):
        load_series(path)


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
