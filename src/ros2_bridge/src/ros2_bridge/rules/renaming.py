"""Renaming rules between ROS 1 and ROS 2; imports neither."""

import re
from typing import Dict, Mapping, Optional, Sequence

_NAME = re.compile(r"/|(/[A-Za-z]\w*)+", re.ASCII)


class Renaming:
    """Mapping of the names of topics, services and nodes between ROS 1 and ROS 2.

    A rule applies to a name and all names below it; the rule with the longest name wins. If two
    names would map to the same name, the mapping is not invertible, and has no result.

    :param rules: each ``NAME=NAME``, ROS 1 first; ``/`` stands for all names
    :raises ValueError: if a rule is malformed, or a name is repeated; the text is a clause that
        states the requirement
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
        """Return the ROS 2 name for a ROS 1 name; None without one."""
        return _there_and_back(name, self._to_ros2, self._to_ros1)

    def in_ros1(self, name: str) -> Optional[str]:
        """Return the ROS 1 name for a ROS 2 name; None without one."""
        return _there_and_back(name, self._to_ros1, self._to_ros2)


def _there_and_back(name: str, there: Mapping[str, str], back: Mapping[str, str]) -> Optional[str]:
    if not there:
        return name
    other = _renamed(name, there)
    return other if other and _renamed(other, back) == name else None


def _renamed(name: str, rules: Mapping[str, str]) -> str:
    """Apply the rule for the longest prefix of a name; empty if it removes the whole name."""
    part = name
    while part not in rules and part != "/":
        part = part.rpartition("/")[0] or "/"
    if part not in rules:
        return name
    return rules[part].rstrip("/") + name[len(part.rstrip("/")) :]
