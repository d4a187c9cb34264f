# Pure: knows no ROS.
"""When a set point asks for its motor to be enabled, and when it may publish."""

from typing import Optional


# The states that a motor publishes on motor_state.
#: Not yet enabled since it started.
WAITING = "waiting"
ENABLED = "enabled"
#: Stopped by a request.
DISABLED = "disabled"


class EnableSequence:
    """A motor's state as its client knows it, from replies to its calls and from motor_state.

    It asks once for the motor to be enabled, and publishes while the motor is. A motor that has
    restarted has to be asked again. A motor that another client has disabled is not
    enabled again, even after its restart, until a client enables it.

    Without a motor_state, from a motor that does not publish it, a successful call is all it takes.

    Not safe for several threads at once.
    """

    def __init__(self) -> None:
        self._accepted = False
        self._state: Optional[str] = None
        self._left_alone = False

    @property
    def may_publish(self) -> bool:
        """Whether the motor was enabled for us and is still."""
        return self._accepted and self._state in (None, ENABLED)

    @property
    def wants_call(self) -> bool:
        """Whether the motor has to be asked to be enabled."""
        return not self._accepted and not self._left_alone

    def answered(self, success: bool) -> None:
        """Record the answer to a request to be enabled.

        :param success: whether the motor is enabled; False also where there was no answer
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
        """Record that no motor is connected any more."""
        self._accepted = False
        self._state = None
