# Pure: knows no ROS.
"""Enable sequence: when a set point requests its motor, and when it may publish."""

from typing import Optional


# States that a motor publishes on motor_state.
#: Not enabled since its start.
WAITING = "waiting"
ENABLED = "enabled"
#: Stopped by a request.
DISABLED = "disabled"


class EnableSequence:
    """A motor's state, from replies to calls and from motor_state.

    It requests once that the motor is enabled, and publishes while it is. A restarted motor is
    requested again. A motor that another client has disabled is not enabled again, even after its
    restart, until a client enables it.

    For a motor without motor_state, a successful call suffices.

    Not thread-safe.
    """

    def __init__(self) -> None:
        self._accepted = False
        self._state: Optional[str] = None
        self._left_alone = False

    @property
    def may_publish(self) -> bool:
        """Whether the motor was enabled for us and still is."""
        return self._accepted and self._state in (None, ENABLED)

    @property
    def wants_call(self) -> bool:
        """Whether the motor has to be requested."""
        return not self._accepted and not self._left_alone

    def answered(self, success: bool) -> None:
        """Record the answer to a request.

        :param success: whether the motor is enabled; False also without an answer
        """
        self._accepted = success

    def heard(self, state: str) -> None:
        """Record a state that the motor has published.

        :param state: WAITING, ENABLED or DISABLED
        """
        if state == DISABLED and self._accepted:
            self._left_alone = True
        elif state == ENABLED:
            self._left_alone = False
        elif state == WAITING:
            self._accepted = False
        self._state = state

    def lost(self) -> None:
        """Record that no motor is connected."""
        self._accepted = False
        self._state = None
