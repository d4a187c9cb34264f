"""The list of goals as bytes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.actions.status_list import ListedGoal, read_list, write_list

GOALS = st.lists(
    st.builds(
        ListedGoal,
        st.binary(min_size=16, max_size=16),
        st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1),
        st.integers(-128, 127),
    )
)


@given(GOALS)
def test_status_list_survives_round_trip(goals: "list[ListedGoal]") -> None:
    assert read_list(write_list(goals)) == goals


@given(GOALS, st.integers(0, 40))
def test_list_that_is_cut_is_refused(goals: "list[ListedGoal]", left: int) -> None:
    data = write_list(goals)
    if left < len(data):
        with pytest.raises(ValueError):
            read_list(data[:left])


def test_other_notation_is_refused() -> None:
    with pytest.raises(ValueError):
        read_list(b"\0\0" + write_list([])[2:])


def test_time_beyond_ros2_range_is_clipped() -> None:
    (read,) = read_list(write_list([ListedGoal(bytes(16), (2**32 - 1) * 10**9, 1)]))
    assert read.stamp == (2**31 - 1) * 10**9
