# Pure: knows no ROS.
"""Next request to a system of managed nodes: two rules, independent of ROS and of time.

All nodes are configured in order, then all are activated in order. So a node may be configured once
all before it are, and active once all are configured and all before it active. First every node
above its allowed level is brought down, the highest and last first; then nodes below it are brought
up, the first one first. A loss, a return and the states found by a new manager are only other
levels to start from.
"""

import enum
from typing import Collection, Mapping, NamedTuple, Optional, Sequence


class Level(enum.IntEnum):
    """Level of a node's state, with ROS 2's numbers."""

    #: Missing, silent, or finalized: no other node can depend on it.
    GONE = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3


#: Transition up, and down, from each level.
UP = {Level.UNCONFIGURED: "configure", Level.INACTIVE: "activate"}
DOWN = {Level.UNCONFIGURED: "shutdown", Level.INACTIVE: "cleanup", Level.ACTIVE: "deactivate"}


class Instruction(NamedTuple):
    """A transition to request from a node.

    :param place: index of the node, from 0
    :param label: of the transition
    """

    place: int
    label: str


def highest(place: int, goal: Level, levels: Sequence[Level]) -> Level:
    """Return the highest allowed level of a node.

    :param place: its index
    :param goal: common goal of all nodes
    :param levels: levels of all nodes, in order
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
    """Return the next request, or None if no change is needed or a pending one must end first.

    :param goal: common goal of all nodes
    :param levels: levels of all nodes, in order
    :param under_way: pending request of each node, by its index
    :param stuck: indices of nodes whose transition down has failed
    """
    if any(label in DOWN.values() for label in under_way.values()):
        return None
    free = [place for place in range(len(levels)) if place not in under_way and place not in stuck]
    limits = [highest(place, goal, levels) for place in range(len(levels))]
    too_high = [place for place in reversed(free) if levels[place] > limits[place]]
    for place in sorted(too_high, key=levels.__getitem__, reverse=True):
        # It stays configured while a node that depends on it refuses to be deactivated.
        if levels[place] is Level.ACTIVE or Level.ACTIVE not in levels[place:]:
            return Instruction(place, DOWN[levels[place]])
    for place in free:
        if not under_way and Level.GONE < levels[place] < limits[place]:
            return Instruction(place, UP[levels[place]])
    return None
