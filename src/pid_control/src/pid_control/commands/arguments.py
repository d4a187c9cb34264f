"""Converters for argparse ``type=``: finite number, path of a YAML file, path of an SVG file."""

import argparse
import math
from typing import Tuple


def number(text: str) -> float:
    """Parse a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def yaml_path(text: str) -> str:
    """Check that a path ends like a YAML file."""
    return _ending(text, (".yaml", ".yml"))


def svg_path(text: str) -> str:
    """Check that a path ends like an SVG file."""
    return _ending(text, (".svg",))


def _ending(text: str, endings: Tuple[str, ...]) -> str:
    if not text.lower().endswith(endings):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in {' or '.join(endings)}")
    return text
