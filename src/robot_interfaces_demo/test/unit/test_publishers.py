"""Publishers under one name."""

from typing import List

from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.monitoring.publishers import Publishers

MEMORY_S = 10.0


def heard(publishers: str, step: float = 1.0) -> Publishers:
    """Return the state after messages from publishers of one letter each, at equal intervals."""
    known = Publishers()
    for number, publisher in enumerate(publishers):
        known.add_message(publisher, number * step, MEMORY_S)
    return known


def test_a_robot_that_is_started_again_has_no_rival() -> None:
    for publishers in ("a", "aaaa", "aaabbb", "aabbccdd"):
        assert not heard(publishers).has_rivals, publishers
    assert not heard("ab" * 5, step=MEMORY_S + 1.0).has_rivals


def test_two_that_are_heard_in_turns_are_rivals() -> None:
    for publishers in ("aba", "aaabba", "abca", "abcabc"):
        known = heard(publishers)
        assert known.has_rivals, publishers
        assert known.names() == sorted(set(publishers))


def test_remaining_publisher_has_no_rival() -> None:
    known = heard("aba")  # b was heard at 1 s
    known.forget(1.0 + MEMORY_S, MEMORY_S)
    assert known.has_rivals
    known.add_message("a", 11.5, MEMORY_S)
    known.forget(11.5, MEMORY_S)
    assert not known.has_rivals
    assert known.names() == ["a"]
    known.add_message("b", 12.0, MEMORY_S)
    assert not known.has_rivals


def test_last_publisher_is_kept_during_silence() -> None:
    known = heard("ab")
    known.forget(1000.0, MEMORY_S)
    assert known.names() == ["b"]


def test_eight_may_follow_each_other_and_the_ninth_is_a_rival() -> None:
    assert not heard("abcdefgh").has_rivals
    assert heard("abcdefghi").has_rivals


@given(st.lists(st.integers(0, 1000), max_size=100))
def test_few_are_remembered_and_many_are_rivals(publishers: List[int]) -> None:
    known = Publishers()
    for publisher in publishers:
        known.add_message(str(publisher), 0.0, MEMORY_S)
    assert len(known.names()) <= 8
    assert known.has_rivals or len(set(publishers)) <= 8
    if publishers:
        assert str(publishers[-1]) in known.names()
