"""Log with one limit per text, which a reset clears."""

from typing import List

from serial_link.link.throttled_log import ThrottledLog


def test_line_is_logged_once_per_key_and_again_after_reset() -> None:
    logged: List[str] = []
    throttled_log = ThrottledLog(60.0)
    for text, key in (
        ("one", ""),
        ("one", ""),
        ("two", ""),
        ("5 lost", "lost"),
        ("6 lost", "lost"),
    ):
        throttled_log.log(logged.append, text, key)
    assert logged == ["one", "two", "5 lost"]
    throttled_log.reset()
    throttled_log.log(logged.append, "one")
    assert logged[-1] == "one" and len(logged) == 4


def test_line_is_logged_again_after_its_period() -> None:
    logged: List[str] = []
    throttled_log = ThrottledLog(0.0)
    for _ in range(2):
        throttled_log.log(logged.append, "one")
    assert logged == ["one", "one"]
