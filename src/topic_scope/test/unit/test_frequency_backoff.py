"""Back-off of the frequency measurement for traces without a frequency."""

from typing import Dict, List

from topic_scope.analysis.measurement import measured
from topic_scope.analysis.periods import NO_PERIOD, TOO_SHORT
from topic_scope.page.frequency_backoff import ROUNDS, FrequencyBackoff

WAVE = measured(2.0, 0.01)
NAMES = ["/a", "/b", "/c", "/d", "/e"]


def rounds(
    backoff: FrequencyBackoff, count: int, start: float, frequency: object = NO_PERIOD
) -> List[list]:
    """Return the traces that were measured in some rounds, of the latest 5 s each."""
    tried = []
    for index in range(count):
        now = start + 0.25 * index
        backoff.begin((now - 5.0, now), now)
        tried.append([name for name in NAMES if backoff.known(name) is None])
        for name in tried[-1]:
            backoff.keep(name, frequency)  # type: ignore[arg-type]
    return tried


def test_aperiodic_traces_are_measured_in_every_fourth_round_in_turn() -> None:
    first, *others = rounds(FrequencyBackoff(), 1 + 5 * ROUNDS, 1.7e9)
    assert first == NAMES
    counts: Dict[str, int] = {name: sum(name in tried for tried in others) for name in NAMES}
    assert counts == dict.fromkeys(NAMES, 5)
    assert max(len(tried) for tried in others) == 2


def test_periodic_or_short_trace_is_measured_each_time() -> None:
    for frequency in (WAVE, TOO_SHORT):
        assert rounds(FrequencyBackoff(), 9, 1.7e9, frequency) == [NAMES] * 9


def test_new_frequency_is_found_within_four_rounds() -> None:
    backoff = FrequencyBackoff()
    rounds(backoff, 5, 1.7e9)
    found = rounds(backoff, 2 * ROUNDS, 1.7e9 + 1.25, WAVE)
    assert set(sum(found[:ROUNDS], [])) == set(NAMES)
    assert found[ROUNDS:] == [NAMES] * ROUNDS


def test_changed_or_paused_span_is_measured_immediately() -> None:
    backoff = FrequencyBackoff()
    rounds(backoff, 3, 1.7e9)
    for now, span in [(1.0, (-1.0, 1.0)), (1.25, (-1.0, 1.0)), (1.5, (-0.5, 1.0))]:
        backoff.begin((1.7e9 + span[0], 1.7e9 + span[1]), 1.7e9 + now)
        assert [backoff.known(name) for name in NAMES] == [None] * len(NAMES)
        for name in NAMES:
            backoff.keep(name, NO_PERIOD)
