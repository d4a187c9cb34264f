"""The contact with a board in time."""

import math
from typing import List

import pytest

from serial_link.host.contact import (
    ASK,
    ASKING,
    CLOSED,
    DOUBTED,
    IN_STEP,
    LOST,
    MESSAGE,
    OPENED,
    PROBE,
    RESTART,
    SILENT,
    TIME,
    TOPIC,
    UNKNOWN,
)
from serial_link.host.session import (
    ASK_EVERY_S,
    OVERDUE_S,
    PROBE_EVERY_S,
    QUIET_S,
    Session,
)


def in_step(now: float = 0.0) -> Session:
    session = Session()
    assert session.handle(now, OPENED) == [ASK]
    assert session.handle(now, TIME) == []
    assert session.handle(now, TOPIC) == []
    assert session.state == IN_STEP
    return session


def run(session: Session, start: float, end: float) -> List[str]:
    """Poll whenever something is due."""
    actions: List[str] = []
    while start <= session.next_due() <= end:
        actions += session.poll(session.next_due())
    return actions


def test_nothing_is_due_while_the_port_is_closed() -> None:
    session = Session()
    assert session.next_due() == math.inf and session.poll(1e9) == []
    session = in_step()
    assert session.handle(1.0, LOST) == [RESTART]
    assert session.state == CLOSED and session.next_due() == math.inf
    assert session.restarts == 0


def test_a_board_is_asked_until_it_answers() -> None:
    session = Session()
    session.handle(0.0, OPENED)
    assert session.poll(0.9 * ASK_EVERY_S) == []
    assert run(session, 0.0, 1.01) == [ASK] * 4
    session.handle(1.1, TOPIC)
    assert session.state == IN_STEP


def test_a_board_that_says_something_is_not_probed() -> None:
    session = in_step()
    for step in range(1, 50):
        assert session.poll(0.2 * step) == []
        session.handle(0.2 * step, MESSAGE)
    assert session.poll(0.2 * 49 + QUIET_S) == [PROBE]
    assert session.state == SILENT


def test_a_board_that_only_listens_stays_in_contact() -> None:
    session = in_step()
    for request in range(1, 10):
        actions = run(session, 0.0, 2.5 * request)
        assert set(actions) == {PROBE}
        assert session.handle(2.5 * request, TIME) == [PROBE]
        assert session.state == DOUBTED
        assert session.poll(2.5 * request + PROBE_EVERY_S) == [PROBE]
        assert session.state == SILENT
    assert session.restarts == 0


def test_a_board_that_was_reset_is_back_within_a_second_of_its_start() -> None:
    session = in_step()
    back_at = 1.7
    assert set(run(session, 0.0, back_at)) == {PROBE}
    now = session.next_due()  # the first probe that it is there for
    session.poll(now)
    assert session.handle(now + 0.01, TIME) == [PROBE]
    assert session.handle(now + 0.02, TIME) == [RESTART, ASK]
    assert session.state == ASKING and session.restarts == 1
    assert now + 0.02 - back_at < 1.0
    session.handle(now + 0.03, TIME)
    assert session.state == IN_STEP


def test_a_quick_board_that_was_reset_is_missed_within_half_a_second() -> None:
    session = in_step()
    session.handle(1.0, MESSAGE)
    assert session.poll(1.5) == [PROBE]
    assert session.handle(1.51, TIME) == [PROBE]
    assert session.handle(1.52, TIME) == [RESTART, ASK]


def test_a_board_that_is_silent_for_too_long_is_asked_anew() -> None:
    session = in_step()
    actions = run(session, 0.0, 0.99 * OVERDUE_S)
    assert set(actions) == {PROBE} and session.state == SILENT
    assert run(session, 0.0, OVERDUE_S + PROBE_EVERY_S)[:2] == [RESTART, ASK]
    assert session.state == ASKING


@pytest.mark.parametrize("quiet", [False, True])
def test_a_topic_that_is_not_known_is_asked_for_but_not_again_at_once(quiet: bool) -> None:
    session = in_step()
    if quiet:
        session.poll(QUIET_S)
        assert session.state == SILENT
    assert session.handle(1.0, UNKNOWN) == [ASK]
    assert session.handle(1.0 + 0.9 * ASK_EVERY_S, UNKNOWN) == []
    assert session.handle(1.0 + 1.1 * ASK_EVERY_S, UNKNOWN) == [ASK]
    assert session.state == IN_STEP
