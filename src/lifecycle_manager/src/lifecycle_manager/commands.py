# Pure: knows no ROS.
"""Commands of a manager, as in nav2."""

from typing import NamedTuple, Sequence

from lifecycle_manager.node_state import STATES
from lifecycle_manager.plan import Level


class Command(NamedTuple):
    """A command.

    :param name: nav2's name
    :param goal: level that it leads to
    :param starts: current goals from which it is allowed
    """

    name: str
    goal: Level
    starts: Sequence[Level] = tuple(Level)


#: Commands by nav2's numbers.
COMMANDS = (
    Command("STARTUP", Level.ACTIVE),
    Command("PAUSE", Level.INACTIVE, (Level.INACTIVE, Level.ACTIVE)),
    Command("RESUME", Level.ACTIVE, (Level.INACTIVE, Level.ACTIVE)),
    Command("RESET", Level.UNCONFIGURED),
    Command("SHUTDOWN", Level.GONE),
    Command("CONFIGURE", Level.INACTIVE, (Level.UNCONFIGURED, Level.INACTIVE)),
    Command("CLEANUP", Level.UNCONFIGURED, (Level.UNCONFIGURED, Level.INACTIVE)),
)


def validated(number: int, meant: Level) -> Command:
    """Return the command with a number.

    :param number: the number
    :param meant: current goal of the system
    :raises ValueError: if there is no such command, or it is not allowed now
    """
    if number >= len(COMMANDS):
        names = ", ".join(f"{index} {each.name}" for index, each in enumerate(COMMANDS))
        raise ValueError(f"command: refused {number}: must be one of {names}")
    if meant not in COMMANDS[number].starts:
        allowed = ", ".join(each.name for each in COMMANDS if meant in each.starts)
        name = COMMANDS[number].name
        raise ValueError(
            f"{name} is refused while all are to be {STATES[meant]}; allowed: {allowed}"
        )
    return COMMANDS[number]
