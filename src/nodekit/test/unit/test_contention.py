"""Newer values that bad ones or own writes have hit, and writers that correct each other."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.parameters.contention import BURST, OVERLAP_S, REFILL_S, Contention
from nodekit.parameters.declaration import FloatParameter, ParameterSet, StringParameter
from nodekit.parameters.no_value import MISSING


class Gauge(ParameterSet):
    """Two parameters."""

    level = FloatParameter(1.0, minimum=0.0, help="a level")
    title = StringParameter("gauge", help="a title")


IN_FORCE = Gauge(level=2.0)


def overwritten(contention, raw, *pushed, now=100.0):
    return contention.overwritten(IN_FORCE, {"level": raw}, [("level", v) for v in pushed], now)


def after_writing(value, name="level", now=100.0):
    contention = Contention()
    contention.note(name, value, now)
    return contention


def test_what_was_pushed_but_replaced_by_others_is_history():
    assert overwritten(Contention(), 5.0, 3.0, 4.0, 5.0) == {}


def test_last_good_value_before_a_bad_one_wins():
    assert overwritten(Contention(), -1, 3.0, 4.0, -1) == {"level": 4.0}
    assert overwritten(Contention(), -1, 3.0, -2, -1) == {"level": 3.0}
    assert overwritten(Contention(), -1, -2, -1) == {}


def test_what_an_own_write_has_hit_wins():
    assert overwritten(after_writing(2.0), 2.0, -1, 5) == {"level": 5}
    assert overwritten(after_writing(2.0), 2.0, "5", -1) == {"level": "5"}
    assert overwritten(after_writing(2.0), 2.0, -1) == {}


def test_deletion_that_an_own_write_has_hit_means_the_default():
    assert overwritten(after_writing(2.0), 2.0, 5, MISSING) == {"level": 1.0}


def test_own_write_that_was_replaced_has_hit_nothing():
    contention = after_writing(2.0)
    assert overwritten(contention, 7.0, 5.0, 7.0) == {}
    # Somebody has set the very value that was written before.
    assert overwritten(contention, 2.0, 5.0) == {}


def test_own_write_is_told_from_an_equal_value_of_another_kind():
    assert overwritten(after_writing(2.0), 2, 5.0) == {}


def test_deleted_value_leaves_no_own_write_standing():
    contention = after_writing(2.0)
    assert contention.overwritten(IN_FORCE, {}, [("level", 5.0), ("level", MISSING)], 100.1) == {}
    assert overwritten(contention, 2.0, 5.0) == {}


def test_notifications_of_old_times_are_not_taken_for_news():
    assert overwritten(after_writing(2.0), 2.0, 5.0, now=100.0 + OVERLAP_S) == {}
    assert overwritten(after_writing(2.0), 2.0, 5.0, now=99.9 + OVERLAP_S) == {"level": 5.0}


def test_each_parameter_is_judged_by_itself():
    contention = after_writing("gauge", "title")
    raw = {"level": 3.0, "title": "gauge", "other": 1}
    pushed = [("level", 9.0), ("title", "new"), ("other", 2), ("title", 7)]
    assert contention.overwritten(IN_FORCE, raw, pushed, 100.1) == {"title": "new"}


def test_a_burst_of_writes_goes_at_once_and_more_one_by_one():
    contention = Contention()
    assert [contention.allow("level", 0.0) for _ in range(BURST)] == [True] * BURST
    assert not contention.allow("level", 0.5 * REFILL_S)
    assert contention.allow("title", 0.5 * REFILL_S)
    assert contention.allow("level", 1.1 * REFILL_S)
    assert not contention.allow("level", 1.9 * REFILL_S)


def test_one_more_write_goes_with_each_of_the_reads_that_come_once_in_a_while():
    contention = Contention()
    for _ in range(BURST):
        contention.allow("level", 0.0)
    assert all(contention.allow("level", number * REFILL_S) for number in range(1, 1000))


@given(st.lists(st.floats(0.0, 3.0 * REFILL_S), max_size=200))
def test_writes_are_never_more_than_the_burst_and_one_a_period(pauses):
    contention, now, allowed = Contention(), 0.0, 0
    for pause in pauses:
        now += pause
        allowed += contention.allow("level", now)
        assert allowed <= BURST + now / REFILL_S + 1e-6


@pytest.mark.parametrize("rest", [BURST * REFILL_S, 1e6])
def test_the_burst_is_back_after_a_rest(rest):
    contention = Contention()
    for _ in range(2 * BURST):
        contention.allow("level", 0.0)
    assert [contention.allow("level", rest) for _ in range(BURST + 1)].count(True) == BURST


def test_what_is_written_on_purpose_is_newer_than_any_notification():
    contention = after_writing(2.0)
    contention.forget(["level", "title"])
    assert overwritten(contention, 2.0, 5.0) == {}
