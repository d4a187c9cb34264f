"""Files that commands write."""

import os


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
