"""Active pairs, and when they are closed."""

from typing import List, Optional

import pytest

from ros2_bridge.rules.selection import Rules, Route
from ros2_bridge.rules.active_pairs import MISSED_POLLS, BridgedResources, PairBridge, for_all
from ros2_bridge.rules.skip_log import SkipLog, Unbridgeable


class Pair:
    """Something that is bridged, of a type and with a quality."""

    def __init__(self, kind: str, quality: int) -> None:
        self.kind, self.quality, self.is_closed = kind, quality, False
        self.fails = False

    def close(self) -> None:
        assert not self.is_closed
        self.is_closed = True
        if self.fails:
            raise RuntimeError("it does not close")


def test_pair_missing_for_several_polls_is_closed() -> None:
    parts: BridgedResources[str, Pair] = BridgedResources(3)
    kept, gone = parts["a"], parts["b"] = Pair("", 0), Pair("", 0)
    parts.close_missing(["a"])
    parts.close_missing(["a"])
    parts.close_missing(["a", "b"])  # it was back: counted again
    for _ in range(2):
        parts.close_missing(["a"])
        assert parts == {"a": kept, "b": gone}
    parts.close_missing(["a"])
    assert parts == {"a": kept} and gone.is_closed and not kept.is_closed
    parts.close_missing(["a", "b"])
    parts["b"] = again = Pair("", 0)
    parts.close_missing(["a"])  # counted again
    assert parts["b"] is again


class Pairs(PairBridge[Pair]):
    """Fake bridge with pairs of one type and quality, which may reject them."""

    def __init__(self) -> None:
        self.log = SkipLog()
        super().__init__(self.log)
        self.kind: Optional[str] = "text"
        self.quality, self.problem = 1, ""

    def _has_same_type(self, route: Route, pair: Pair) -> bool:
        return pair.kind == self.kind

    def _is_as_begun(self, route: Route, pair: Pair) -> bool:
        return pair.quality == self.quality

    def _begin(self, route: Route) -> Optional[Pair]:
        if self.problem:
            raise Unbridgeable(self.problem)
        return Pair(self.kind, self.quality) if self.kind else None

    def polled(self, *names: str) -> List[Optional[Pair]]:
        """Return the pairs of some names after a poll in which these are to be bridged."""
        routes = [Route(name, True) for name in names]
        self.update_pairs(routes)
        return [self.pairs.get(route) for route in routes]


def test_pair_is_kept_while_nothing_changes() -> None:
    pairs = Pairs()
    first = pairs.polled("/a", "/b")
    assert None not in first and pairs.polled("/a", "/b") == first
    for _ in range(MISSED_POLLS):
        pairs.polled("/a")
    assert list(pairs.pairs.values()) == first[:1]


def test_new_quality_applies_immediately_and_new_type_after_a_poll() -> None:
    pairs = Pairs()
    (first,) = pairs.polled("/a")
    pairs.quality = 2
    (second,) = pairs.polled("/a")
    assert first and first.is_closed
    assert second and (second.kind, second.quality) == ("text", 2)
    pairs.kind = "number"
    assert pairs.polled("/a") == [None] and second.is_closed
    (third,) = pairs.polled("/a")
    assert third and third.kind == "number"


def test_failed_pair_is_retried() -> None:
    pairs = Pairs()
    pairs.kind = None  # it is not known yet
    assert pairs.polled("/a") == [None] and pairs.log.next_line(0.0) is None
    pairs.kind, pairs.problem = "text", "/a has several types"
    assert pairs.polled("/a") == pairs.polled("/a") == [None]
    assert pairs.log.next_line(0.0) == "not bridged: /a has several types"
    pairs.problem = ""
    assert None not in pairs.polled("/a")


def test_denied_pair_is_closed_immediately() -> None:
    pairs = Pairs()
    kept, denied = pairs.polled("/a", "/b")
    pairs.close_denied(Rules(True, True, ["*"], ["/b"]))
    assert list(pairs.pairs.values()) == [kept]
    assert denied and denied.is_closed
    pairs.close_denied(Rules(True, False, ["*"], []))
    assert kept and not kept.is_closed
    pairs.close_denied(Rules(False, True, ["*"], []))
    assert kept.is_closed and not pairs.pairs


def test_first_of_several_failures_is_raised() -> None:
    numbers = iter([{}, {}])
    with pytest.raises(KeyError, match="first"):
        for_all(["first", "second"], lambda name: next(numbers)[name])


def test_failure_for_one_item_does_not_stop_others() -> None:
    pairs = Pairs()
    before = pairs.polled("/a", "/b", "/c")
    for pair in before:
        assert pair
        pair.fails = pair is not before[2]
    pairs.quality = 2
    with pytest.raises(RuntimeError, match="it does not close"):
        pairs.polled("/a", "/b", "/c", "/d")
    assert all(pair and pair.is_closed for pair in before)
    assert [route.name for route in pairs.pairs] == ["/c", "/d"]
    assert None not in pairs.polled("/a", "/b")  # created again
    for pair in pairs.pairs.values():
        pair.fails = True
    for _ in range(MISSED_POLLS - 2):
        pairs.polled("/e")
    with pytest.raises(RuntimeError, match="it does not close"):
        pairs.polled("/e", "/f")
    with pytest.raises(RuntimeError, match="it does not close"):
        pairs.polled("/e", "/f")
    assert [route.name for route in pairs.pairs] == ["/e", "/f"]
