# Pure: knows no ROS.
"""Next request to a system of managed nodes: two rules, independent of ROS and of time.

All nodes are configured in order, then all are activated in order. So a node may be configured
while all before it are, and active while all are configured and all before it active. Who is
further up than that comes down, the furthest up and the last one first; then who may be further up
goes up, the first one first. There is no more to it: a loss, a return, or whatever a new manager
finds are only other levels to start from.
"""

import enum
from typing import Collection, Mapping, NamedTuple, Optional, Sequence


class Level(enum.IntEnum):
    """Level of a node's state, with ROS 2's numbers."""

    #: Not there, silent, or finalized: nothing can be built on it.
    GONE = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3


#: What leads one level up, and one level down, by the level that it leaves.
UP = {Level.UNCONFIGURED: "configure", Level.INACTIVE: "activate"}
DOWN = {Level.UNCONFIGURED: "shutdown", Level.INACTIVE: "cleanup", Level.ACTIVE: "deactivate"}


class Instruction(NamedTuple):
    """A transition that is to be requested of a node.

    :param place: the node's place in the order, from 0
    :param label: of the transition
    """

    place: int
    label: str


def highest(place: int, goal: Level, levels: Sequence[Level]) -> Level:
    """Return how far up a node may be.

    :param place: its place in the order
    :param goal: how far up all of them are to be
    :param levels: how far up they are, in order
    """
    before = levels[:place]
    if any(level < Level.INACTIVE for level in before):
        return min(goal, Level.UNCONFIGURED)
    if min(levels) < Level.INACTIVE or any(level < Level.ACTIVE for level in before):
        return min(goal, Level.INACTIVE)
    return goal


def next_instruction(
    goal: Level,
    levels: Sequence[Level],
    under_way: Mapping[int, str] = {},
    stuck: Collection[int] = (),
) -> Optional[Instruction]:
    """Return the next request, or None if no change is needed or another must end first.

    :param goal: how far up all nodes are to be
    :param levels: how far up they are, in order
    :param under_way: the request that each node has not answered yet, by its place
    :param stuck: places of nodes whose transition down has failed
    """
    if any(label in DOWN.values() for label in under_way.values()):
        return None
    free = [place for place in range(len(levels)) if place not in under_way and place not in stuck]
    limits = [highest(place, goal, levels) for place in range(len(levels))]
    too_high = [place for place in reversed(free) if levels[place] > limits[place]]
    for place in sorted(too_high, key=levels.__getitem__, reverse=True):
        # It stays configured while one that was built on it does not let itself be deactivated.
        if levels[place] is Level.ACTIVE or Level.ACTIVE not in levels[place:]:
            return Instruction(place, DOWN[levels[place]])
    for place in free:
        if not under_way and Level.GONE < levels[place] < limits[place]:
            return Instruction(place, UP[levels[place]])
    return None
