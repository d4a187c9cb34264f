"""What a motor says of itself, in the course's words."""

TURNING, NOT_TURNING, MAX_SPEED = "Motor Turning", "Motor Not Turning", "Motor Max Speed"

#: A motor that coasts gets slower for ever; below this share of its greatest speed it stands.
_STANDS = 1e-3


def status_of(speed: float, max_speed: float) -> str:
    """Return what a motor says at a speed.

    :param speed: of either sign, rad/s
    :param max_speed: the greatest magnitude that it reaches, rad/s
    """
    if abs(speed) >= max_speed:
        return MAX_SPEED
    return TURNING if abs(speed) > _STANDS * max_speed else NOT_TURNING
