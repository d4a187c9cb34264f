"""Status texts in ``motor_output``, such as "Motor Turning", by the motor's speed."""

TURNING, NOT_TURNING, MAX_SPEED = "Motor Turning", "Motor Not Turning", "Motor Max Speed"

#: Share of the greatest speed below which a motor counts as stopped: a coasting motor never stops.
_STANDS = 1e-3


def status_of(speed: float, max_speed: float) -> str:
    """Return the motor's status text at a speed.

    :param speed: of either sign [rad/s]
    :param max_speed: largest magnitude of the speed [rad/s]
    """
    if abs(speed) >= max_speed:
        return MAX_SPEED
    return TURNING if abs(speed) > _STANDS * max_speed else NOT_TURNING
