"""Pauses between attempts that fail."""


class BackOff:
    """Pauses that double from one attempt to the next, up to a longest one.

    :param first: pause after the first attempt, s, > 0
    :param longest: longest pause, s
    """

    def __init__(self, first: float, longest: float) -> None:
        self._first = first
        self._longest = longest
        self._pause = first

    def next(self) -> float:
        """Return the pause after one more attempt that failed, s."""
        pause = self._pause
        self._pause = min(2.0 * pause, self._longest)
        return pause

    def reset(self) -> None:
        """Begin with the first pause again."""
        self._pause = self._first
