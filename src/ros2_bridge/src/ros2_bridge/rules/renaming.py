"""Renaming rules between ROS 1 and ROS 2; imports neither."""

import re
from typing import Dict, Mapping, Optional, Sequence

_NAME = re.compile(r"/|(/[A-Za-z]\w*)+", re.ASCII)


class Renaming:
    """Finds the name on the other side of topics, services and nodes.

    A rule is for a name and all that stands below it, and of several the one for the longest name
    counts. A name from which there is no way back, as two would have the same on the other side,
    has none there.

    :param rules: each ``NAME=NAME``, in ROS 1 and in ROS 2; ``/`` stands for all names
    :raises ValueError: if one is malformed, or two are for one name; the text is a clause that says
        what must hold
    """

    def __init__(self, rules: Sequence[str] = ()) -> None:
        self._to_ros2: Dict[str, str] = {}
        self._to_ros1: Dict[str, str] = {}
        for rule in rules:
            ros1, sign, ros2 = rule.partition("=")
            for name in (ros1, ros2):
                if not sign or not _NAME.fullmatch(name):
                    raise ValueError(
                        "each rule must be NAME=NAME, the name in ROS 1 first, such as /robot1=/;"
                        f" {rule!r} is not"
                    )
            if ros1 in self._to_ros2 or ros2 in self._to_ros1:
                raise ValueError(f"each name may be in one rule only; {rule!r} repeats one")
            self._to_ros2[ros1], self._to_ros1[ros2] = ros2, ros1

    def in_ros2(self, name: str) -> Optional[str]:
        """Return the name in ROS 2 of what has a name in ROS 1, None where it has none."""
        return _there_and_back(name, self._to_ros2, self._to_ros1)

    def in_ros1(self, name: str) -> Optional[str]:
        """Return the name in ROS 1 of what has a name in ROS 2, None where it has none."""
        return _there_and_back(name, self._to_ros1, self._to_ros2)


def _there_and_back(name: str, there: Mapping[str, str], back: Mapping[str, str]) -> Optional[str]:
    if not there:
        return name
    other = _renamed(name, there)
    return other if other and _renamed(other, back) == name else None


def _renamed(name: str, rules: Mapping[str, str]) -> str:
    """Apply the rule for the longest part of a name; empty where it takes away all of it."""
    part = name
    while part not in rules and part != "/":
        part = part.rpartition("/")[0] or "/"
    if part not in rules:
        return name
    return rules[part].rstrip("/") + name[len(part.rstrip("/")) :]
