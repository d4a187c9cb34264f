"""No input runs code: no recorded signal, no YAML with Python's tags, no parameter."""

import pytest
import rosparam
import yaml
from hypothesis import given
from hypothesis import strategies as st
from launch_loading import load
from roslaunch import RLException

from basic_comms.signals.replay import SeriesError, load_series


@pytest.fixture
def marker(tmp_path):
    """Return a path that hostile input tries to create."""
    path = tmp_path / "marker"
    yield path
    assert not path.exists()


def hostile(marker):
    """Return texts that would create the marker if anything ran them."""
    return [
        f"__import__('pathlib').Path({str(marker)!r}).touch()",
        f"=cmd|'/C touch {marker}'!A0",
        f"$(touch {marker})",
        f"`touch {marker}`",
        f"| touch {marker}",
        f"; touch {marker}",
    ]


def test_recorded_signal_holds_numbers_or_is_refused(tmp_path, marker):
    recorded = tmp_path / "signal.csv"
    for text in hostile(marker):
        recorded.write_text(f"0,1\n{text},2\n")
        with pytest.raises(SeriesError, match="line 2"):
            load_series(str(recorded))
        recorded.write_text(f"0,1\n1,{text}\n")
        with pytest.raises(SeriesError, match="line 2"):
            load_series(str(recorded))


def test_path_of_a_recorded_signal_is_a_path(marker):
    for text in hostile(marker):
        with pytest.raises(SeriesError, match="no such file"):
            load_series(text)


@given(st.binary(max_size=200))
def test_any_file_is_a_signal_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    try:
        series = load_series(str(path))
    except SeriesError as error:
        assert str(path) in str(error)
    else:
        assert -1.0 <= series.value(0.5, hold=False, loop=True) <= 1.0


def python_tags(marker):
    """Return YAML that would create the marker if Python's tags were obeyed."""
    return [
        f"value: !!python/object/apply:os.mkdir [{marker}]",
        f"value: !!python/object/new:pathlib.Path.touch [{marker}]",
        "value: !!python/name:os.system",
    ]


def test_rosparam_refuses_the_tags_of_python(tmp_path, marker):
    for text in python_tags(marker):
        path = tmp_path / "parameters.yaml"
        path.write_text(text)
        with pytest.raises(yaml.YAMLError):
            rosparam.load_file(str(path))


def test_roslaunch_refuses_the_tags_of_python(tmp_path, marker):
    launch = tmp_path / "hostile.launch"
    for text in python_tags(marker):
        launch.write_text(f"<launch><rosparam>{text}</rosparam></launch>")
        with pytest.raises((RLException, yaml.YAMLError)):
            load(str(launch))
