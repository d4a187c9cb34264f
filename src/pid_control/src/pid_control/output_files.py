"""Atomic writer of output files, and a check beforehand that they can be written."""

import errno
import os


def check_writable(path: str) -> None:
    """Check that a file can be written, before long work that produces its content.

    :param path: the file; unchanged
    :raises OSError: if the file cannot be written
    """
    try:
        if os.path.isdir(path):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        with open(path + ".part", "w", encoding="utf-8"):
            pass
    except OSError as error:
        raise OSError(error.errno, error.strerror, path) from None
    os.remove(path + ".part")


def write_file(path: str, text: str) -> None:
    """Write a file atomically.

    :param path: the file
    :param text: its content; names of files that are not UTF-8 are escaped
    :raises OSError: if the file cannot be written
    """
    partial = path + ".part"
    try:
        with open(partial, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
        os.replace(partial, path)
    except OSError as error:
        raise OSError(error.errno, error.strerror, path) from None
    finally:
        if os.path.exists(partial):
            os.remove(partial)
