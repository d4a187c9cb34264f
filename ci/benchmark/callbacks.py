"""What it costs that the callbacks of a node exclude each other."""

from nodekit.testing.costs import time_in_a_group

from .context import Bench, Figures


def uncontended(_bench: Bench, _subject: str) -> Figures:
    """Call a function that does nothing, by itself and in a group that nobody else wants."""
    return {"group_us": time_in_a_group()}
