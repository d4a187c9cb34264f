"""Files that commands write and read."""

import argparse
import os
from typing import Tuple


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


def yaml_path(text: str) -> str:
    """Judge the path of a YAML file, for argparse."""
    return _ending(text, (".yaml", ".yml"))


def svg_path(text: str) -> str:
    """Judge the path of a picture, for argparse."""
    return _ending(text, (".svg",))


def _ending(text: str, endings: Tuple[str, ...]) -> str:
    if not text.lower().endswith(endings):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in {' or '.join(endings)}")
    return text
