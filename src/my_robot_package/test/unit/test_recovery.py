"""Repeated set-up after failures."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from my_robot_package.nodes.robust_node import SetupFailed, set_up


@given(st.integers(0, 6), st.integers(1, 6))
def test_it_is_tried_until_it_succeeds(failures: int, attempts: int) -> None:
    did: List[str] = []

    def attempt() -> None:
        did.append("try")
        if did.count("try") <= failures:
            raise OSError(f"failure {did.count('try')}")

    def recover(error: Exception) -> None:
        did.append(str(error))

    if failures < attempts:
        assert set_up(attempt, recover, attempts) == failures + 1
    else:
        with pytest.raises(SetupFailed, match=f"failed {attempts} times, .*: failure {attempts}$"):
            set_up(attempt, recover, attempts)
    tries = min(failures + 1, attempts)
    expected = [word for number in range(1, tries) for word in ("try", f"failure {number}")]
    assert did == expected + ["try"]


def test_a_failure_of_the_recovery_is_not_hidden() -> None:
    def attempt() -> None:
        raise OSError("first")

    def recover(error: Exception) -> None:
        raise KeyError("second")

    with pytest.raises(KeyError):
        set_up(attempt, recover, 3)


def test_no_attempt_is_no_setup() -> None:
    with pytest.raises(ValueError, match="attempts: refused 0"):
        set_up(lambda: None, lambda error: None, 0)
