# Pure: knows no ROS.
"""Modes of a robot: the constants of RobotStatus, for code independent of ROS."""

import enum


class Mode(enum.IntEnum):
    """Modes of a robot, with the numbers of the message."""

    IDLE = 0
    MOVING = 1
    WORKING = 2
    CHARGING = 3
    ERROR = 4


#: Modes by number.
KNOWN = {int(mode): mode for mode in Mode}


def name_of(mode: int) -> str:
    """Return the name of a mode, or the number of an unknown one.

    :param mode: number in a message
    """
    return KNOWN[mode].name.lower() if mode in KNOWN else str(mode)
