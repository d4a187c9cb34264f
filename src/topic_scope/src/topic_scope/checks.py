"""Checks of what a page asks for, field by field."""

import math
from typing import Any, Dict, Tuple

_LONGEST_NAME = 300


class RequestError(ValueError):
    """A request that cannot be obeyed, and why."""


def name_of(request: Dict[str, Any], kind: str, key: str) -> str:
    """Read a name.

    :param request: the request
    :param kind: its type
    :param key: which part of it
    :raises RequestError: if it is none
    """
    name = request.get(key)
    if not isinstance(name, str) or not 0 < len(name) <= _LONGEST_NAME:
        raise RequestError(f"{kind}: {key} is a name")
    return name


def word_of(request: Dict[str, Any], kind: str, key: str, words: Tuple[str, ...]) -> str:
    """Read one of some words; otherwise as :func:`name_of`."""
    word = request.get(key)
    if not isinstance(word, str) or word not in words:
        raise RequestError(f"{kind}: {key} is one of {', '.join(words)}")
    return word


def number_of(request: Dict[str, Any], kind: str, key: str, low: float, high: float) -> float:
    """Read a number between two bounds; otherwise as :func:`name_of`."""
    number = request.get(key)
    if isinstance(number, bool) or not isinstance(number, (int, float)):
        raise RequestError(f"{kind}: {key} is a number")
    if not low <= number <= high or not math.isfinite(number):
        raise RequestError(f"{kind}: {key} is a number from {low:g} to {high:g}")
    return float(number)
