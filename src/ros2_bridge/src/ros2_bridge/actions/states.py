"""Goal states of ROS 1 and ROS 2, and the translation between them."""

import enum
from typing import AbstractSet, Collection, FrozenSet, Mapping, Sequence, TypeVar


class Ros1Status(enum.IntEnum):
    """Goal states of ROS 1, numbered as in actionlib_msgs/GoalStatus."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLING = 7
    RECALLED = 8
    LOST = 9


class Ros2Status(enum.IntEnum):
    """Goal states of ROS 2, numbered as in action_msgs/GoalStatus."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


#: Shortest timeout for the result of an ended goal [s]: status and result use different
#: connections.
RESULT_S = 2.0

#: Transitions of a goal, as in actionlib's server and rcl. LOST is determined by the ROS 1 client.
ROS1_TRANSITIONS: Mapping[Ros1Status, AbstractSet[Ros1Status]] = {
    Ros1Status.PENDING: {
        Ros1Status.ACTIVE,
        Ros1Status.RECALLING,
        Ros1Status.RECALLED,
        Ros1Status.REJECTED,
    },
    Ros1Status.RECALLING: {Ros1Status.PREEMPTING, Ros1Status.RECALLED, Ros1Status.REJECTED},
    Ros1Status.ACTIVE: {
        Ros1Status.PREEMPTING,
        Ros1Status.PREEMPTED,
        Ros1Status.SUCCEEDED,
        Ros1Status.ABORTED,
    },
    Ros1Status.PREEMPTING: {Ros1Status.PREEMPTED, Ros1Status.SUCCEEDED, Ros1Status.ABORTED},
}
ROS2_TRANSITIONS: Mapping[Ros2Status, AbstractSet[Ros2Status]] = {
    Ros2Status.ACCEPTED: {Ros2Status.EXECUTING, Ros2Status.CANCELING},
    Ros2Status.EXECUTING: {Ros2Status.CANCELING, Ros2Status.SUCCEEDED, Ros2Status.ABORTED},
    Ros2Status.CANCELING: {Ros2Status.CANCELED, Ros2Status.SUCCEEDED, Ros2Status.ABORTED},
}

#: States in the other ROS. ROS 2 rejects a goal before it has a state; a ROS 1 goal that is
#: rejected after ROS 2 has accepted it becomes aborted.
TO_ROS2: Mapping[Ros1Status, Ros2Status] = {
    Ros1Status.PENDING: Ros2Status.ACCEPTED,
    Ros1Status.ACTIVE: Ros2Status.EXECUTING,
    Ros1Status.PREEMPTED: Ros2Status.CANCELED,
    Ros1Status.SUCCEEDED: Ros2Status.SUCCEEDED,
    Ros1Status.ABORTED: Ros2Status.ABORTED,
    Ros1Status.REJECTED: Ros2Status.ABORTED,
    Ros1Status.PREEMPTING: Ros2Status.CANCELING,
    Ros1Status.RECALLING: Ros2Status.CANCELING,
    Ros1Status.RECALLED: Ros2Status.CANCELED,
    Ros1Status.LOST: Ros2Status.ABORTED,
}
#: Of two ROS 1 states, the nearer one is taken: goals that were never active are recalled, the
#: others preempted.
TO_ROS1: Mapping[Ros2Status, Sequence[Ros1Status]] = {
    Ros2Status.UNKNOWN: (Ros1Status.ABORTED,),
    Ros2Status.ACCEPTED: (Ros1Status.PENDING,),
    Ros2Status.EXECUTING: (Ros1Status.ACTIVE,),
    Ros2Status.CANCELING: (Ros1Status.RECALLING, Ros1Status.PREEMPTING),
    Ros2Status.SUCCEEDED: (Ros1Status.SUCCEEDED,),
    Ros2Status.CANCELED: (Ros1Status.RECALLED, Ros1Status.PREEMPTED),
    Ros2Status.ABORTED: (Ros1Status.ABORTED,),
}

#: States by number; a server may send other numbers.
ROS1_BY_NUMBER: Mapping[int, Ros1Status] = {int(one): one for one in Ros1Status}
ROS2_BY_NUMBER: Mapping[int, Ros2Status] = {int(one): one for one in Ros2Status}

#: Final states; the others have transitions.
ROS1_TERMINAL: FrozenSet[Ros1Status] = frozenset(set(Ros1Status).difference(ROS1_TRANSITIONS))
ROS2_TERMINAL: FrozenSet[Ros2Status] = frozenset(
    set(Ros2Status).difference(ROS2_TRANSITIONS, {Ros2Status.UNKNOWN})
)

_Status = TypeVar("_Status", Ros1Status, Ros2Status)


def nearest(
    steps: Mapping[_Status, AbstractSet[_Status]], now: _Status, wanted: Collection[_Status]
) -> _Status:
    """Return the new state of a goal after an update that may be late, or follow lost updates.

    :param steps: transitions of a goal
    :param now: its state before
    :param wanted: its possible new states
    :returns: the one with the fewest transitions; the state before if none is reachable
    """
    reached = [now]  # breadth-first; grows during the iteration
    for state in reached:
        if state in wanted:
            return state
        reached += [one for one in sorted(steps.get(state, ())) if one not in reached]
    return now


def matches_cancel_request(goal_id: str, stamp: int, wanted: str, until: int) -> bool:
    """Return whether a cancel request matches a goal; the rule is the same in both ROSes.

    :param goal_id, stamp: the goal's id in ROS 1, and its start time [ns]
    :param wanted: id of the goal to cancel, empty for none
    :param until: goals that began until then are cancelled too [ns]; 0 for none. Without
        ``wanted`` and ``until``, all goals match
    """
    if not wanted and not until:
        return True
    return goal_id == wanted or bool(until and stamp <= until)
