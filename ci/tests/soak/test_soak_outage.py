"""An outage is measured, and what publishers say about it is understood."""

import pytest

from ci.benchmark.record import Sample
from ci.endurance.run_cable import Outage, counted_losses, outage, reported_lateness

LOG = """\
[rosout][WARNING] 1: /signal: subscriber /process does not keep up: 140 messages lost, 140 in all
[rosout][WARNING] 2: /signal: subscriber /echo does not keep up: 5 messages lost, 5 in all
[rosout][INFO] 3: /signal: subscriber /process keeps up again: 20 more lost, 160 in all
[rosout][WARNING] 4: /signal: samples are 20.1 s late
[rosout][WARNING] 5: /signal: samples are in time again; 1900 were late, by up to 20.1 s
"""


def test_a_burst_after_an_outage() -> None:
    # 10 Hz; from 2 s to 5 s nothing comes through, then all but the samples of 3 s to 4 s.
    there = [Sample(100.0 + 0.1 * n, 0.1 * n) for n in range(20)]
    there += [Sample(105.0, 0.1 * n) for n in range(20, 51) if not 30 <= n < 40]
    seen = outage(0.1, there)
    assert seen == Outage(51, 10, pytest.approx(3.1), pytest.approx(3.0))


def test_losses_are_those_of_the_latest_report_of_each_subscriber() -> None:
    assert counted_losses(LOG) == {"/signal /process": 160, "/signal /echo": 5}
    assert counted_losses("") == {}


def test_lateness_is_that_of_each_outage_that_is_over() -> None:
    assert reported_lateness(LOG) == [20.1]
    assert reported_lateness(LOG + LOG.replace("20.1", "3.5")) == [20.1, 3.5]
    assert reported_lateness("") == []
