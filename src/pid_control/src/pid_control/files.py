"""Files that commands write."""

import errno
import os


def check_writable(path: str) -> None:
    """Make sure that a file can be written, before long work whose result is to be in it.

    :param path: the file; it stays as it is
    :raises OSError: if it cannot be
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
    """Write a file, which appears when it is complete.

    :param path: the file
    :param text: what is in it
    :raises OSError: if it cannot be written
    """
    partial = path + ".part"
    try:
        with open(partial, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(partial, path)
    finally:
        if os.path.exists(partial):
            os.remove(partial)
