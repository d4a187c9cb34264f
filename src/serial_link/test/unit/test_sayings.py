"""What is said now and then."""

from typing import List

from serial_link.link.sayings import Sayings


def test_each_thing_is_said_once_and_again_when_it_is_forgotten() -> None:
    said: List[str] = []
    sayings = Sayings(60.0)
    for text, about in (
        ("one", ""),
        ("one", ""),
        ("two", ""),
        ("5 lost", "lost"),
        ("6 lost", "lost"),
    ):
        sayings.say(said.append, text, about)
    assert said == ["one", "two", "5 lost"]
    sayings.forget()
    sayings.say(said.append, "one")
    assert said[-1] == "one" and len(said) == 4


def test_after_its_period_a_thing_is_said_again() -> None:
    said: List[str] = []
    sayings = Sayings(0.0)
    for _ in range(2):
        sayings.say(said.append, "one")
    assert said == ["one", "one"]
