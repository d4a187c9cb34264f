# Pure: knows no ROS.
"""Pairs of type names of a ROS 1 package and its renamed counterpart in ROS 2."""

import collections
from typing import Dict, Iterable, List, NamedTuple


class NamePairs(NamedTuple):
    """Counterparts of the types of a ROS 1 package.

    :param found: ROS 2 name by ROS 1 name, both without the package
    :param unclear: all names that match, by ROS 1 name, if more than one pair is possible
    """

    found: Dict[str, str]
    unclear: Dict[str, List[str]]


def pair_names(ros1: Iterable[str], ros2: Iterable[str]) -> NamePairs:
    """Pair equal names; of the others, those that differ only in case and underscores.

    ROS 2 requires CamelCase: ``signal_msg`` is ``SignalMsg`` there.

    :param ros1, ros2: names of the types of one kind, without the package
    """
    names1, names2 = set(ros1), set(ros2)
    pairs = NamePairs({name: name for name in names1 & names2}, {})
    similar1, similar2 = (_by_letters(names - pairs.found.keys()) for names in (names1, names2))
    for letters, ours in similar1.items():
        its = similar2.get(letters, [])
        if len(ours) == len(its) == 1:
            pairs.found[ours[0]] = its[0]
        elif its:
            pairs.unclear.update({name: [*ours, *its] for name in ours})
    return pairs


def _by_letters(names: Iterable[str]) -> Dict[str, List[str]]:
    """Return the names, grouped by their lowercase letters and digits."""
    found: Dict[str, List[str]] = collections.defaultdict(list)
    for name in sorted(names):
        found[name.replace("_", "").lower()].append(name)
    return found
