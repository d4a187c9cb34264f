"""What a plant is given in an experiment."""

from hypothesis import given
from hypothesis import strategies as st

from pid_control.identification.excitation import excitation


@given(st.floats(-5.0, 0.0), st.floats(0.01, 5.0), st.floats(1.0, 100.0))
def test_inputs_are_within_bounds_and_end_with_0(
    least: float, largest: float, seconds: float
) -> None:
    changes = excitation(least, largest, seconds)
    times = [change.time for change in changes]
    values = [change.value for change in changes]
    assert times == sorted(times)
    assert times[0] == 0.0 and times[-1] < seconds
    assert (min(values), max(values)) == (least if least else 0.0, largest)
    assert values[0] == values[-1] == 0.0
