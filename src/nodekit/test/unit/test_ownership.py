"""What is made is closed with its owner, whoever else makes or closes something just then."""

import threading
from typing import Any, Iterable, Iterator, List

from nodekit.life.opening import Opener
from nodekit.life.ownership import Owner


class Thing:
    """Notes whether it was closed."""

    def __init__(self) -> None:
        self.closed = False

    def close(self) -> None:
        self.closed = True


class Interrupted(List[Any]):
    """A list after whose last element somebody else does something, if he is not kept from it."""

    def __init__(self, things: Iterable[Any], other: threading.Thread) -> None:
        super().__init__(things)
        self._other = other

    def __iter__(self) -> Iterator[Any]:
        yield from super().__iter__()
        self._other.start()
        self._other.join(0.1)


def test_what_is_made_while_something_else_is_closed_is_closed_with_the_rest() -> None:
    owner, gone, late = Owner(Opener()), Thing(), Thing()
    other = threading.Thread(target=owner.own, args=(late,))
    owner._made = Interrupted([gone], other)
    owner.disown(gone)
    other.join()
    owner.close()
    assert (late.closed, gone.closed) == (True, False)
