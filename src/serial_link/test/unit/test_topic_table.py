"""Table of a board's topics, filled in rounds that may be damaged."""

from typing import List, Optional

import pytest

from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    TopicInfo,
)
from serial_link.negotiation.topic_table import (
    MOST_ROUNDS,
    MOST_TOPICS,
    SETTLED_S,
    Endpoint,
    TopicTable,
)


def info(number: int, name: str = "", size: int = 512) -> TopicInfo:
    return TopicInfo(number, name or f"topic_{number}", "std_msgs/Empty", "0" * 32, size)


def names(table: TopicTable) -> List[str]:
    return [endpoint.name for endpoint in table.endpoints()]


def test_topics_in_both_directions_may_share_an_id() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    assert table.add(0.0, PUBLISHER, info(125, "out"))
    assert table.add(0.0, SUBSCRIBER, info(125, "in"))
    assert table.endpoints() == [
        Endpoint(PUBLISHER, "out", "std_msgs/Empty", info(125, "out"), None),
        Endpoint(SUBSCRIBER, "in", "std_msgs/Empty", None, info(125, "in")),
    ]
    assert table.incoming(125) == table.endpoints()[0]
    assert table.incoming(126) is None
    assert not any(endpoint.is_service for endpoint in table.endpoints())


def test_a_service_is_known_when_both_halves_are() -> None:
    for kind in (SERVICE_SERVER, SERVICE_CLIENT):
        table = TopicTable()
        table.begin_round(0.0)
        table.add(0.0, kind + SUBSCRIBER, info(100, "call"))
        table.add(0.0, kind + PUBLISHER, info(126, "another"))
        table.add(0.0, kind + PUBLISHER, info(127, "call")._replace(type="std_msgs/Bool"))
        assert table.endpoints() == [] and table.incoming(126) is None
        table.add(0.0, kind + PUBLISHER, info(125, "call"))
        expected = Endpoint(kind, "call", "std_msgs/Empty", info(125, "call"), info(100, "call"))
        assert table.endpoints() == [expected] and expected.is_service
        assert table.incoming(125) == expected


def test_round_ends_after_silence() -> None:
    table = TopicTable()
    assert table.is_settled and table.end_round(9.0) is None
    table.begin_round(1.0)
    assert not table.is_settled
    assert table.end_round(1.0 + 0.9 * SETTLED_S) is None
    table.add(1.15, PUBLISHER, info(125))
    assert table.end_round(1.25) is None
    assert table.end_round(1.15 + SETTLED_S) is True
    assert table.is_settled and table.end_round(9.0) is None


def round_of(table: TopicTable, time: float, *numbers: int) -> Optional[bool]:
    """Return the result of a round in which topics are announced."""
    table.begin_round(time)
    for number in numbers:
        table.add(time, PUBLISHER, info(number))
    return table.end_round(time + 0.5)


def test_topic_that_two_good_rounds_lack_is_removed() -> None:
    table = TopicTable()
    for time in (0.0, 1.0):  # heard twice, as the damage below requires
        assert round_of(table, time, 125, 126, 127) is True
    for time, numbers in (2.0, (125, 126)), (3.0, (126, 127)):
        assert round_of(table, time, *numbers) is False
        assert names(table) == ["topic_125", "topic_126", "topic_127"]
    table.begin_round(4.0)
    table.add(4.0, PUBLISHER, info(126))
    table.mark_damaged()
    assert table.end_round(4.5) is False
    assert names(table) == ["topic_125", "topic_126", "topic_127"]
    assert round_of(table, 5.0, 126, 127) is True
    assert names(table) == ["topic_126", "topic_127"]
    assert round_of(table, 6.0, 126, 127) is True


def test_restarted_board_may_announce_its_last_topics_late() -> None:
    table = TopicTable()
    assert round_of(table, 0.0, 125, 126) is True
    table.reset()
    assert round_of(table, 1.0, 125) is False and not table.is_complete
    assert round_of(table, 2.0, 125, 126) is True and table.is_complete
    table.reset()  # another sketch has fewer topics
    assert round_of(table, 3.0, 125) is False
    assert round_of(table, 4.0, 125) is True and table.is_complete
    table.reset()
    assert round_of(table, 5.0, 125) is True and table.is_complete


def test_silent_board_keeps_topics() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    table.add(0.0, PUBLISHER, info(125))
    table.end_round(1.0)
    table.begin_round(1.0)
    assert table.end_round(2.0) is True
    assert names(table) == ["topic_125"]


def test_restart_invalidates_earlier_announcements() -> None:
    table = TopicTable()
    table.mark_damaged()  # a single announcement then replaces nothing
    for time in (0.0, 1.0):
        table.begin_round(time)
        for info_id in (PUBLISHER, SUBSCRIBER):
            table.add(time, info_id, info(100, "old"))
        table.end_round(time + 0.5)
    assert table.is_complete and table.accepts(info(100, "old"))
    table.reset()
    assert not table.is_complete and not table.accepts(info(100, "old"))
    assert table.endpoints() == [] and table.incoming(100) is None
    table.begin_round(2.0)
    table.add(2.0, SUBSCRIBER, info(100, "new"))
    assert table.accepts(info(100, "new")) and not table.accepts(info(100, "old"))
    table.mark_damaged()
    for time in (2.0, 3.0):
        assert table.end_round(time + 0.5) is False and not table.is_complete
        table.begin_round(time + 1.0)
        table.add(time + 1.0, SUBSCRIBER, info(100, "new"))
    assert table.end_round(4.5) is True and table.is_complete
    assert names(table) == ["new"]


@pytest.mark.parametrize(
    "told, known",
    [
        ("motor_outqut motor_output motor_output", "motor_outqut motor_outqut motor_output"),
        ("motor_output motor_outqut motor_output", "motor_output motor_output motor_output"),
        ("old new old new new", "old old old old new"),
    ],
)
def test_damage_requires_two_equal_announcements(told: str, known: str) -> None:
    table = TopicTable()
    for time, (name, expected) in enumerate(zip(told.split(), known.split())):
        table.begin_round(float(time))
        table.add(float(time), PUBLISHER, info(125, name))
        table.mark_damaged()
        is_complete = table.end_round(time + 0.5)
        assert names(table) == [expected]
    table.begin_round(9.0)
    table.add(9.0, PUBLISHER, info(125, names(table)[0]))
    assert is_complete is False and table.end_round(9.5) is True


def test_single_announcement_replaces_nothing_after_damage() -> None:
    table = TopicTable()
    table.mark_damaged()
    for time, name in enumerate(["old", "old", "new", "new"]):
        table.begin_round(float(time))
        table.add(float(time), PUBLISHER, info(125, name))
        assert table.end_round(time + 0.5) is (time in (1, 3))
        assert names(table) == ["new" if time == 3 else "old"]


def test_disagreeing_rounds_are_limited() -> None:
    table, rounds = TopicTable(), 0
    table.mark_damaged()
    is_complete: Optional[bool] = False
    while not is_complete:
        table.begin_round(float(rounds))
        table.add(float(rounds), PUBLISHER, info(125, f"topic_{rounds}"))
        is_complete = table.end_round(rounds + 0.5)
        rounds += 1
    assert rounds == MOST_ROUNDS


def test_damaged_rounds_are_limited() -> None:
    table, rounds = TopicTable(), 1
    table.begin_round(0.0)
    table.mark_damaged()
    while table.end_round(float(rounds)) is False:
        rounds += 1
        table.begin_round(float(rounds) - 0.5)
        table.mark_damaged()
    assert rounds == MOST_ROUNDS
    table.begin_round(100.0)
    table.mark_damaged()
    assert table.end_round(101.0) is False


def test_aborted_rounds_are_limited() -> None:
    """Board whose topic is announced wrongly each time, so that it is asked again."""
    table, rounds = TopicTable(), 0
    table.begin_round(0.0)
    while not table.end_round(float(rounds)) and rounds < 2 * MOST_ROUNDS:
        table.begin_round(float(rounds))  # by a message whose id is not known
        table.mark_damaged()
        rounds += 1
    assert rounds < MOST_ROUNDS
    table.reset()
    table.begin_round(100.0)
    table.mark_damaged()
    assert table.end_round(101.0) is False  # a restarted board is asked as often again


def test_aborted_rounds_count_after_a_complete_one_and_not_after_a_restart() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    assert table.end_round(1.0) is True
    for number, is_final in ((MOST_ROUNDS, True), (MOST_ROUNDS - 1, False)):
        for _ in range(number):
            table.begin_round(2.0)
            table.mark_damaged()
        assert table.end_round(3.0) is is_final
    table.reset()
    table.begin_round(4.0)
    table.mark_damaged()
    assert table.end_round(5.0) is False


def test_restarted_board_without_topics_is_not_asked_for_those_of_the_sketch_before() -> None:
    table = TopicTable()
    table.mark_damaged()
    table.begin_round(0.0)
    table.add(0.0, PUBLISHER, info(125))
    table.reset()
    table.begin_round(1.0)
    assert table.end_round(2.0) is True


def test_rounds_before_the_board_answers_do_not_count() -> None:
    table = TopicTable()
    for number in range(MOST_ROUNDS - 1):
        table.begin_round(float(number), is_answering=False)
        table.mark_damaged()
    table.begin_round(100.0)
    table.mark_damaged()
    assert table.end_round(101.0) is False


def test_invalid_topic_needs_two_equal_announcements() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    table.add(0.0, PUBLISHER, info(125, "my-topic"))
    table.add(0.0, PUBLISHER, info(126, "good"))
    assert names(table) == ["good"]
    assert table.end_round(1.0) is False
    table.begin_round(1.0)
    table.add(1.0, PUBLISHER, info(125, "other-topic"))  # damage, then
    table.add(1.0, PUBLISHER, info(126, "good"))
    assert names(table) == ["good"] and table.end_round(2.0) is False
    table.begin_round(2.0)
    table.add(2.0, PUBLISHER, info(125, "other-topic"))
    table.add(2.0, PUBLISHER, info(126, "good"))
    assert table.end_round(3.0) is True
    assert set(names(table)) == {"good", "other-topic"}
    assert table.incoming(125) is not None


def test_single_invalid_announcement_is_dropped_on_restart() -> None:
    table = TopicTable()
    for number in range(2):
        table.reset()
        table.begin_round(float(number))
        table.add(float(number), PUBLISHER, info(125, "my-topic"))
        assert table.endpoints() == []


def test_round_waits_as_long_as_the_board_may_take() -> None:
    table = TopicTable(1.0)
    table.begin_round(0.0, True, 7.0)
    assert table.end_round(6.9) is None
    table.add(6.9, PUBLISHER, info(125))
    assert table.end_round(6.9 + SETTLED_S + 0.9) is None
    assert table.end_round(6.9 + SETTLED_S + 1.1) is True


def test_known_topics_may_change_in_full_table() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    for number in range(MOST_TOPICS):
        assert table.add(0.0, PUBLISHER, info(100 + number))
    assert not table.add(0.0, PUBLISHER, info(5000))
    assert table.add(0.0, PUBLISHER, info(100, "other"))
    assert len(table.endpoints()) == MOST_TOPICS


def test_longest_message_is_from_publishers() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    assert table.longest == 0
    table.add(0.0, SUBSCRIBER, info(100, size=900))
    table.add(0.0, PUBLISHER, info(125, size=300))
    table.add(0.0, PUBLISHER, info(126, size=200))
    assert table.longest == 300


def test_incoming_topic_follows_later_announcements() -> None:
    table = TopicTable()
    table.begin_round(0.0)
    for _ in "ab":
        table.add(0.0, PUBLISHER, info(125, "old"))
    table.end_round(1.0)
    found = [table.incoming(125)]
    table.begin_round(1.0)
    table.add(1.0, PUBLISHER, info(125, "new"))
    found.append(table.incoming(125))
    table.end_round(2.0)
    for time in (2.0, 3.0):
        table.begin_round(time)
        table.add(time, PUBLISHER, info(126, "other"))
        found.append(table.incoming(125))
        table.end_round(time + 0.5)
    found += [table.incoming(125), table.incoming(126)]
    table.reset()
    found.append(table.incoming(126))
    heard = [one and one.name for one in found]
    assert heard == ["old", "new", "new", "new", None, "other", None]
