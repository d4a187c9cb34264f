"""Tests of the measurement of an outage, and of the parser of publishers' reports."""

from typing import Set

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ci.endurance.run_cable import counted_losses, lost, reported_lateness

LOG = """\
[rosout][WARNING] 1: /signal: subscriber /process does not keep up: 140 messages lost, 140 in all
[rosout][WARNING] 2: /signal: subscriber /echo does not keep up: 5 messages lost, 5 in all
[rosout][INFO] 3: /signal: subscriber /process keeps up again: 20 more lost, 160 in all
[rosout][WARNING] 4: /signal: samples are 20.1 s late
[rosout][WARNING] 5: /signal: samples are in time again; 1900 were late, by up to 20.1 s
"""


@settings(max_examples=30)
@given(st.sets(st.integers(1, 998)), st.floats(0.0, 1e5))
def test_each_lost_sample_is_counted(removed: Set[int], begin: float) -> None:
    times = np.array([begin + 1e-3 * n for n in range(1000) if n not in removed])
    assert lost(times, 1000.0) == len(removed)


def test_jitter_and_repetition_are_not_losses() -> None:
    assert lost(1e-3 * np.arange(1000) + 3e-4 * np.sin(np.arange(1000)), 1000.0) == 0
    assert lost(np.array([0.0, 1e-3, 1e-3, 2e-3]), 1000.0) == 0


def test_losses_are_those_of_the_latest_report_of_each_subscriber() -> None:
    assert counted_losses(LOG) == {"/signal /process": 160, "/signal /echo": 5}
    assert counted_losses("") == {}


def test_lateness_of_each_ended_outage() -> None:
    assert reported_lateness(LOG) == [20.1]
    assert reported_lateness(LOG + LOG.replace("20.1", "3.5")) == [20.1, 3.5]
    assert reported_lateness("") == []
