"""Who publishes under one name."""

from typing import List

from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.sources import Sources

MEMORY_S = 10.0


def heard(publishers: str, step: float = 1.0) -> Sources:
    """Return what was heard from publishers of one letter each, at equal intervals."""
    sources = Sources()
    for number, publisher in enumerate(publishers):
        sources.note(publisher, number * step, MEMORY_S)
    return sources


def test_a_robot_that_is_started_again_has_no_rival() -> None:
    for publishers in ("a", "aaaa", "aaabbb", "aabbccdd"):
        assert not heard(publishers).has_rivals, publishers
    assert not heard("ab" * 5, step=MEMORY_S + 1.0).has_rivals


def test_two_that_are_heard_in_turns_are_rivals() -> None:
    for publishers in ("aba", "aaabba", "abca", "abcabc"):
        sources = heard(publishers)
        assert sources.has_rivals, publishers
        assert sources.names() == sorted(set(publishers))


def test_who_is_alone_again_has_no_rival() -> None:
    sources = heard("aba")  # b was heard at 1 s
    sources.forget(1.0 + MEMORY_S, MEMORY_S)
    assert sources.has_rivals
    sources.note("a", 11.5, MEMORY_S)
    sources.forget(11.5, MEMORY_S)
    assert not sources.has_rivals
    assert sources.names() == ["a"]
    sources.note("b", 12.0, MEMORY_S)
    assert not sources.has_rivals


def test_the_last_one_is_remembered_however_long_it_is_silent() -> None:
    sources = heard("ab")
    sources.forget(1000.0, MEMORY_S)
    assert sources.names() == ["b"]


def test_eight_may_follow_each_other_and_the_ninth_is_a_rival() -> None:
    assert not heard("abcdefgh").has_rivals
    assert heard("abcdefghi").has_rivals


@given(st.lists(st.integers(0, 1000), max_size=100))
def test_few_are_remembered_and_many_are_rivals(publishers: List[int]) -> None:
    sources = Sources()
    for publisher in publishers:
        sources.note(str(publisher), 0.0, MEMORY_S)
    assert len(sources.names()) <= 8
    assert sources.has_rivals or len(set(publishers)) <= 8
    if publishers:
        assert str(publishers[-1]) in sources.names()
