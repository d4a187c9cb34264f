"""Which goals a cancellation means. Both ROSes have the same rule for those that are there."""


def is_meant(goal_id: str, stamp: int, wanted: str, until: int) -> bool:
    """Tell whether a cancellation means a goal.

    :param goal_id, stamp: the goal's id in ROS 1, and when it began, ns
    :param wanted: id of the goal that is to be cancelled, empty for none
    :param until: all that began until then are to be cancelled too, ns, 0 for none. With neither,
        all are
    """
    if not wanted and not until:
        return True
    return goal_id == wanted or bool(until and stamp <= until)
