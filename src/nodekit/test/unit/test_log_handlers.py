"""Tests of logs that cannot be written: only lines are lost."""

import io
import logging
import os
import select
import subprocess
import sys

import pytest
from rosgraph import roslogging

from nodekit.process_context import ProcessContext
from nodekit.rospy_internals import log_handlers, startup
from nodekit.testing.waiting import TIMEOUT_S

startup.apply_patches()


@pytest.fixture(autouse=True)
def notices_are_due(monkeypatch):
    """Report the first lost line of each test."""
    monkeypatch.setattr(log_handlers, "PROCESS", ProcessContext())


@pytest.fixture
def full():
    """Return a text stream on a full disk."""
    with open("/dev/full", "wb", buffering=0) as raw:
        yield io.TextIOWrapper(raw, write_through=True)


def logger_with(handler):
    """Return a logger with one handler."""
    logger = logging.Logger("test")
    logger.addHandler(handler)
    return logger


def test_full_disk_below_the_console_is_noticed_once(full, capsys):
    logger = logger_with(roslogging.RosStreamHandler(stdout=full))
    for _ in range(10):
        logger.info("a line")
    assert capsys.readouterr().err.count("log lines are lost") == 1


def test_full_disk_below_both_streams_is_survived(full, monkeypatch):
    monkeypatch.setattr(sys, "stderr", full)
    logger = logger_with(roslogging.RosStreamHandler(stdout=full, stderr=full))
    logger.info("a line")
    logger.error("another")


def test_full_disk_below_the_file_prints_no_traceback(full, capsys):
    logger = logger_with(logging.StreamHandler(full))
    for _ in range(10):
        logger.info("a line")
    errors = capsys.readouterr().err
    assert errors.count("log lines are lost") == 1
    assert "Traceback" not in errors


def test_line_that_cannot_be_formatted_is_still_a_defect_to_be_seen(capsys):
    logger_with(logging.StreamHandler(io.StringIO())).info("%d", "text")
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["console", "file"])
def test_characters_that_the_stream_lacks_are_escaped(kind, capsys):
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii", write_through=True)
    console = kind == "console"
    logger = logger_with(
        roslogging.RosStreamHandler(stdout=stream) if console else logging.StreamHandler(stream)
    )
    logger.info("gr\u00fc\u00dfe")
    logger.info("\u4f60")
    assert rb"gr\xfc\xdfe" in raw.getvalue() and rb"\u4f60" in raw.getvalue()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "place", [{"ROS_LOG_DIR": "/proc"}, {"ROS_HOME": "/proc"}], ids=["directory", "home"]
)
def test_where_no_log_file_can_be_written_the_console_is_left(place):
    program = (
        "import rosgraph.roslogging as r, logging;"
        "from nodekit.rospy_internals import startup; startup.apply_patches();"
        "r.configure_logging('rospy', logging.INFO, filename='x.log');"
        "logging.getLogger('rosout').info('heard')"
    )
    environment = {name: value for name, value in os.environ.items() if name != "ROS_LOG_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**environment, **place},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert "heard" in done.stdout
    assert "WARNING: cannot" in done.stderr and "Traceback" not in done.stderr


def test_line_for_a_pipe_does_not_wait_in_a_buffer():
    program = (
        "import rosgraph.roslogging as r, logging, sys;"
        "from nodekit.rospy_internals import startup; startup.apply_patches();"
        "r.configure_logging('rospy', logging.INFO, filename='null');"
        "logging.getLogger('rosout').info('heard');"
        "sys.stdin.read()"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    with subprocess.Popen(
        [sys.executable, "-c", program],
        env={**buffered, "ROS_LOG_DIR": "/dev"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        universal_newlines=True,
    ) as node:
        readable, _, _ = select.select([node.stdout], [], [], TIMEOUT_S)
        assert readable and "heard" in node.stdout.readline()
        node.stdin.close()


def test_unwritable_output_does_not_change_the_exit_status():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [
                sys.executable,
                "-c",
                "from nodekit.rospy_internals import startup;"
                "startup.apply_patches(); print('a line')",
            ],
            env={name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"},
            stdout=full,
            stderr=full,
        )
    assert done.returncode == 0
