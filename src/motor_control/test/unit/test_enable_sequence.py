"""When a set point asks for its motor, and when it publishes."""

from typing import Callable, List

from hypothesis import given
from hypothesis import strategies as st

from motor_control.enable_sequence import DISABLED, ENABLED, WAITING, EnableSequence


def after(*events: Callable[[EnableSequence], None]) -> EnableSequence:
    """Return a sequence that has seen these events."""
    sequence = EnableSequence()
    for event in events:
        event(sequence)
    return sequence


def accepted(sequence: EnableSequence) -> None:
    sequence.answered(True)


def refused(sequence: EnableSequence) -> None:
    sequence.answered(False)


def waiting(sequence: EnableSequence) -> None:
    sequence.heard(WAITING)


def enabled(sequence: EnableSequence) -> None:
    sequence.heard(ENABLED)


def disabled(sequence: EnableSequence) -> None:
    sequence.heard(DISABLED)


def lost(sequence: EnableSequence) -> None:
    sequence.lost()


EVENTS = [accepted, refused, waiting, enabled, disabled, lost]


def assert_asks(sequence: EnableSequence) -> None:
    assert sequence.wants_call and not sequence.may_publish


def assert_publishes(sequence: EnableSequence) -> None:
    assert sequence.may_publish and not sequence.wants_call


def assert_leaves_alone(sequence: EnableSequence) -> None:
    assert not sequence.may_publish and not sequence.wants_call


def test_it_asks_from_the_start() -> None:
    assert_asks(after())


def test_it_publishes_after_success_only() -> None:
    assert_asks(after(waiting))
    assert_asks(after(waiting, refused))
    assert_publishes(after(waiting, refused, accepted, enabled))


def test_success_suffices_without_motor_state() -> None:
    assert_publishes(after(accepted))
    assert_publishes(after(disabled, lost, accepted))


def test_it_asks_although_somebody_else_has_enabled_the_motor() -> None:
    assert_asks(after(enabled))
    assert_publishes(after(enabled, accepted))


def test_motor_that_somebody_disables_is_left_alone_until_somebody_enables_it() -> None:
    assert_leaves_alone(after(accepted, enabled, disabled))
    assert_publishes(after(accepted, enabled, disabled, enabled))


def test_motor_that_was_disabled_before_is_enabled_at_the_start() -> None:
    assert_asks(after(disabled))
    assert_publishes(after(disabled, accepted, enabled))


def test_motor_that_died_is_asked_again() -> None:
    assert_asks(after(accepted, enabled, lost))
    assert_asks(after(accepted, enabled, lost, waiting))
    assert_publishes(after(accepted, enabled, lost, waiting, accepted, enabled))


def test_unnoticed_motor_restart_causes_new_request() -> None:
    assert_asks(after(accepted, enabled, waiting))


def test_motor_that_was_disabled_and_died_is_left_alone_until_somebody_enables_it() -> None:
    assert_leaves_alone(after(accepted, enabled, disabled, lost, waiting))
    assert_asks(after(accepted, enabled, disabled, lost, waiting, enabled))
    assert_publishes(after(accepted, enabled, disabled, lost, waiting, enabled, accepted))


def test_late_messages_have_no_effect() -> None:
    assert_publishes(after(accepted, disabled, enabled))
    assert_publishes(after(accepted, waiting, accepted, enabled))


@given(st.lists(st.sampled_from(EVENTS)))
def test_it_never_publishes_without_a_success_since_the_motor_started(
    events: List[Callable[[EnableSequence], None]],
) -> None:
    sequence = after(*events)
    assert not (sequence.may_publish and sequence.wants_call)
    if sequence.may_publish:
        last = max(index for index, event in enumerate(events) if event is accepted)
        assert not {refused, waiting, lost} & set(events[last:])


@given(st.lists(st.sampled_from(EVENTS)))
def test_an_enabled_motor_is_always_made_use_of_in_the_end(
    events: List[Callable[[EnableSequence], None]],
) -> None:
    sequence = after(*events)
    sequence.heard(ENABLED)
    if sequence.wants_call:
        sequence.answered(True)
    assert_publishes(sequence)
