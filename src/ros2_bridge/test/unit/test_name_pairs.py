"""Pairs of type names of a renamed package: equal ones, and ROS 2's CamelCase."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.types.name_pairs import pair_names

NAMES = st.lists(st.sampled_from(["a_b", "AB", "Ab", "a__b", "c", "C", "_c", "Other"]), unique=True)


def test_equal_names_are_pairs() -> None:
    assert pair_names(["Arm", "Leg"], ["Leg", "Wing"]) == ({"Leg": "Leg"}, {})


@pytest.mark.parametrize(
    "ros1, ros2",
    [("signal_msg", "SignalMsg"), ("IMU_data", "ImuData"), ("signal2", "Signal2"), ("x_", "X")],
)
def test_names_that_differ_in_case_and_underscores_are_pairs(ros1: str, ros2: str) -> None:
    assert pair_names([ros1], [ros2]) == ({ros1: ros2}, {})


def test_equal_names_take_precedence() -> None:
    assert pair_names(["signal_msg", "SignalMsg"], ["SignalMsg"]) == (
        {"SignalMsg": "SignalMsg"},
        {},
    )


def test_ambiguous_names_are_not_paired() -> None:
    found = pair_names(["signal_msg", "Signal_Msg", "arm"], ["SignalMsg", "Arm"])
    names = ["Signal_Msg", "signal_msg", "SignalMsg"]
    assert found == ({"arm": "Arm"}, {"signal_msg": names, "Signal_Msg": names})
    found = pair_names(["imu_data"], ["ImuData", "IMUData"])
    assert found == ({}, {"imu_data": ["imu_data", "IMUData", "ImuData"]})


@given(NAMES, NAMES)
def test_each_name_has_at_most_one_counterpart(ros1: List[str], ros2: List[str]) -> None:
    found, unclear = pair_names(ros1, ros2)
    assert set(found) | set(unclear) <= set(ros1)
    assert not set(found) & set(unclear)
    assert sorted(set(found.values())) == sorted(found.values())
    assert set(found.values()) <= set(ros2)
    assert set(ros1) & set(ros2) <= set(found)
