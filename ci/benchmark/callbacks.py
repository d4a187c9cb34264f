"""What it costs that the callbacks of a node exclude each other."""

import timeit
from typing import Callable, List

from context import Bench, Figures

from nodekit import Group
from nodekit.node.callbacks import Callback

CALLS = 100_000


def uncontended(_bench: Bench, _subject: str) -> Figures:
    """Call a function that does nothing, by itself and in a group that nobody else wants."""

    def nothing() -> None:
        pass

    subjects: List[Callable[[], None]] = [nothing, Callback(Group(), nothing, "nothing").call]
    by_itself, in_group = (
        min(timeit.repeat(function, number=CALLS, repeat=5)) / CALLS for function in subjects
    )
    return {"group_us": (in_group - by_itself) * 1e6}
