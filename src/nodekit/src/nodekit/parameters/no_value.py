"""What stands where the parameter server holds no value, or none that can be sent."""


class NoValue:
    """Stands in for a value; its own kind, so that no parameter takes it.

    :param text: how it is shown
    """

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


#: The value of a key that the server does not hold.
MISSING = NoValue("MISSING")
#: A value that the master cannot send, such as an integer of 64 bits.
UNREADABLE = NoValue("a value that the master cannot send")
