"""Which goals a cancellation means."""

import pytest

from ros2_bridge.actions.cancelling import is_meant


@pytest.mark.parametrize(
    "wanted, until, meant",
    [
        ("", 0, ["a", "b", "c"]),
        ("b", 0, ["b"]),
        ("", 1, ["a"]),
        ("", 2, ["a", "b"]),
        ("c", 1, ["a", "c"]),
        ("x", 0, []),
        ("x", 2, ["a", "b"]),
    ],
)
def test_goals_are_meant_by_id_and_by_time(wanted: str, until: int, meant: "list[str]") -> None:
    stamps = {"a": 1, "b": 2, "c": 3}
    assert [one for one in stamps if is_meant(one, stamps[one], wanted, until)] == meant
