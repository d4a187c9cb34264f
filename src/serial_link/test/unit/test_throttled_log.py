"""Throttled log."""

from typing import List

from serial_link.link.throttled_log import ThrottledLog


def test_each_thing_is_said_once_and_again_when_it_is_forgotten() -> None:
    said: List[str] = []
    throttled_log = ThrottledLog(60.0)
    for text, about in (
        ("one", ""),
        ("one", ""),
        ("two", ""),
        ("5 lost", "lost"),
        ("6 lost", "lost"),
    ):
        throttled_log.log(said.append, text, about)
    assert said == ["one", "two", "5 lost"]
    throttled_log.reset()
    throttled_log.log(said.append, "one")
    assert said[-1] == "one" and len(said) == 4


def test_after_its_period_a_thing_is_said_again() -> None:
    said: List[str] = []
    throttled_log = ThrottledLog(0.0)
    for _ in range(2):
        throttled_log.log(said.append, "one")
    assert said == ["one", "one"]
