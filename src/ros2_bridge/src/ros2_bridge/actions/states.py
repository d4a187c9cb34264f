"""Goal states of ROS 1 and ROS 2, and the translation between them."""

import enum
from typing import AbstractSet, Collection, FrozenSet, Mapping, Sequence, TypeVar


class Status1(enum.IntEnum):
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


class Status2(enum.IntEnum):
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
STEPS1: Mapping[Status1, AbstractSet[Status1]] = {
    Status1.PENDING: {
        Status1.ACTIVE,
        Status1.RECALLING,
        Status1.RECALLED,
        Status1.REJECTED,
    },
    Status1.RECALLING: {Status1.PREEMPTING, Status1.RECALLED, Status1.REJECTED},
    Status1.ACTIVE: {
        Status1.PREEMPTING,
        Status1.PREEMPTED,
        Status1.SUCCEEDED,
        Status1.ABORTED,
    },
    Status1.PREEMPTING: {Status1.PREEMPTED, Status1.SUCCEEDED, Status1.ABORTED},
}
STEPS2: Mapping[Status2, AbstractSet[Status2]] = {
    Status2.ACCEPTED: {Status2.EXECUTING, Status2.CANCELING},
    Status2.EXECUTING: {Status2.CANCELING, Status2.SUCCEEDED, Status2.ABORTED},
    Status2.CANCELING: {Status2.CANCELED, Status2.SUCCEEDED, Status2.ABORTED},
}

#: States in the other ROS. ROS 2 rejects a goal before it has a state; a ROS 1 goal that is
#: rejected after ROS 2 has accepted it becomes aborted.
TO_ROS2: Mapping[Status1, Status2] = {
    Status1.PENDING: Status2.ACCEPTED,
    Status1.ACTIVE: Status2.EXECUTING,
    Status1.PREEMPTED: Status2.CANCELED,
    Status1.SUCCEEDED: Status2.SUCCEEDED,
    Status1.ABORTED: Status2.ABORTED,
    Status1.REJECTED: Status2.ABORTED,
    Status1.PREEMPTING: Status2.CANCELING,
    Status1.RECALLING: Status2.CANCELING,
    Status1.RECALLED: Status2.CANCELED,
    Status1.LOST: Status2.ABORTED,
}
#: Of two ROS 1 states, the nearer one is taken: goals that were never active are recalled, the
#: others preempted.
TO_ROS1: Mapping[Status2, Sequence[Status1]] = {
    Status2.UNKNOWN: (Status1.ABORTED,),
    Status2.ACCEPTED: (Status1.PENDING,),
    Status2.EXECUTING: (Status1.ACTIVE,),
    Status2.CANCELING: (Status1.RECALLING, Status1.PREEMPTING),
    Status2.SUCCEEDED: (Status1.SUCCEEDED,),
    Status2.CANCELED: (Status1.RECALLED, Status1.PREEMPTED),
    Status2.ABORTED: (Status1.ABORTED,),
}

#: States by number; a server may send other numbers.
NUMBERED1: Mapping[int, Status1] = {int(one): one for one in Status1}
NUMBERED2: Mapping[int, Status2] = {int(one): one for one in Status2}

#: Final states; the others have transitions.
OVER1: FrozenSet[Status1] = frozenset(set(Status1).difference(STEPS1))
OVER2: FrozenSet[Status2] = frozenset(set(Status2).difference(STEPS2, {Status2.UNKNOWN}))

_Status = TypeVar("_Status", Status1, Status2)


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
