"""Patch of rospy's log handlers: a log that cannot be written loses only its lines."""

import atexit
import contextlib
import logging
import os
import sys
from typing import Any, Optional

import rosgraph.roslogging
import rospy
import rospy.core
import rospy.impl.rosout
from rosgraph.roslogging import RosStreamHandler

from nodekit.process_context import PROCESS
from nodekit.throttle import Throttle

#: Shortest time between two notices that lines are lost [s].
_NOTICE_PERIOD_S = 60.0


def patch_logs() -> None:
    """Make a failing log lose its lines only.

    Without this patch:

    - A full disk, a closed pipe or an unencodable character raises in the caller that logs, so that
      a talker stops publishing; for a log file, each line prints a traceback.
    - A node whose log file cannot be opened does not start.
    - A line with an invalid byte, as in a file name, blocks ``/rosout`` for later subscribers.
    - A line after ``/rosout`` is closed at shutdown adds a traceback to the file.
    - On a pipe or in a file, console output stays in a buffer of 8 kB.
    """
    emit, handle_error = RosStreamHandler.emit, logging.Handler.handleError
    configure = rosgraph.roslogging.configure_logging

    def emit_or_drop(handler: RosStreamHandler, record: logging.LogRecord) -> None:
        try:
            emit(handler, record)
            _flush_console(handler)
        except (OSError, UnicodeEncodeError):
            handler.handleError(record)

    def drop_with_notice(handler: logging.Handler, record: logging.LogRecord) -> None:
        error = sys.exc_info()[1]
        if isinstance(error, UnicodeEncodeError) and _escape_from_now_on(handler):
            handler.emit(record)
        elif isinstance(error, OSError):
            _notice(error)
        else:
            handle_error(handler, record)

    def configure_with_or_without_file(*args: Any, **kwds: Any) -> Optional[str]:
        try:
            name: Optional[str] = configure(*args, **kwds)
            if name is not None:
                return name
        except OSError as error:
            sys.stderr.write(f"WARNING: cannot write a log file: {error}\n")
        # Without a file, rospy would not configure the console either.
        kwds.update(filename="null", env={**os.environ, "ROS_LOG_DIR": os.path.dirname(os.devnull)})
        configure(*args, **kwds)
        return None

    to_rosout: Any = getattr(rospy.impl.rosout, "_rosout", None)

    def escaped_to_rosout(level: int, *fields: Any) -> Any:
        return to_rosout(level, *map(_as_text, fields))

    RosStreamHandler.emit = emit_or_drop
    setattr(logging.Handler, "handleError", drop_with_notice)
    rosgraph.roslogging.configure_logging = configure_with_or_without_file
    logging.getLogger("rospy.rosout").addFilter(_is_wanted_at_shutdown)
    atexit.register(_close_output)
    if to_rosout is not None:
        rospy.impl.rosout._rosout = escaped_to_rosout
    else:
        rospy.logwarn("unsupported rospy version: lines with invalid bytes do not reach /rosout")


def _flush_console(handler: RosStreamHandler) -> None:
    """Flush the standard output of a handler."""
    stream: Any = getattr(handler, "_stdout", None) or sys.stdout
    if stream is not None:
        stream.flush()


def _is_wanted_at_shutdown(record: logging.LogRecord) -> bool:
    """Return whether to keep a line of rospy about ``/rosout``: no errors at shutdown."""
    return record.levelno < logging.ERROR or not rospy.core.is_shutdown_requested()


def _as_text(field: Any) -> Any:
    """Return a field of a line with invalid characters escaped, as on the console."""
    if not isinstance(field, str):
        return field
    return field.encode("utf-8", "backslashreplace").decode("utf-8")


def _escape_from_now_on(handler: logging.Handler) -> bool:
    """Escape characters that a handler's streams cannot encode.

    :returns: whether a stream was changed
    """
    changed = False
    for name in ("stream", "_stdout", "_stderr"):
        stream: Any = getattr(handler, name, None)
        if getattr(stream, "errors", "backslashreplace") != "backslashreplace":
            stream.reconfigure(errors="backslashreplace")
            changed = True
    return changed


def _notice(error: OSError) -> None:
    """Print on stderr, rate-limited, that log lines are lost."""
    if PROCESS.get(Throttle, lambda: Throttle(_NOTICE_PERIOD_S), "lost log lines").is_due():
        with contextlib.suppress(OSError):  # stderr cannot be written either
            sys.stderr.write(f"WARNING: log lines are lost: {error}\n")


def _close_output() -> None:
    """Drop unwritable output; otherwise Python turns it into the node's exit status."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            with open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), stream.fileno())
