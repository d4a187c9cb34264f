"""What a board has told of, in rounds that may be damaged."""

from typing import List, Optional

from serial_link.negotiation.payloads import (
    PUBLISHER,
    SERVICE_CLIENT,
    SERVICE_SERVER,
    SUBSCRIBER,
    TopicInfo,
)
from serial_link.negotiation.topic_book import (
    MOST_ROUNDS,
    MOST_TOPICS,
    SETTLED_S,
    Endpoint,
    TopicBook,
)


def info(number: int, name: str = "", size: int = 512) -> TopicInfo:
    return TopicInfo(number, name or f"topic_{number}", "std_msgs/Empty", "0" * 32, size)


def names(book: TopicBook) -> List[str]:
    return [endpoint.name for endpoint in book.endpoints()]


def test_topics_of_either_direction_may_have_one_id() -> None:
    book = TopicBook()
    book.begin(0.0)
    assert book.add(0.0, PUBLISHER, info(125, "out"))
    assert book.add(0.0, SUBSCRIBER, info(125, "in"))
    assert book.endpoints() == [
        Endpoint(PUBLISHER, "out", "std_msgs/Empty", info(125, "out"), None),
        Endpoint(SUBSCRIBER, "in", "std_msgs/Empty", None, info(125, "in")),
    ]
    assert book.incoming(125) == book.endpoints()[0]
    assert book.incoming(126) is None
    assert not any(endpoint.is_service for endpoint in book.endpoints())


def test_a_service_is_known_when_both_halves_are() -> None:
    for kind in (SERVICE_SERVER, SERVICE_CLIENT):
        book = TopicBook()
        book.begin(0.0)
        book.add(0.0, kind + SUBSCRIBER, info(100, "call"))
        book.add(0.0, kind + PUBLISHER, info(126, "another"))
        assert book.endpoints() == [] and book.incoming(126) is None
        book.add(0.0, kind + PUBLISHER, info(125, "call"))
        expected = Endpoint(kind, "call", "std_msgs/Empty", info(125, "call"), info(100, "call"))
        assert book.endpoints() == [expected] and expected.is_service
        assert book.incoming(125) == expected


def test_a_round_is_over_when_nothing_more_comes() -> None:
    book = TopicBook()
    assert book.is_settled and book.settle(9.0) is None
    book.begin(1.0)
    assert not book.is_settled
    assert book.settle(1.0 + 0.9 * SETTLED_S) is None
    book.add(1.15, PUBLISHER, info(125))
    assert book.settle(1.25) is None
    assert book.settle(1.15 + SETTLED_S) is True
    assert book.is_settled and book.settle(9.0) is None


def test_what_a_good_round_leaves_out_is_gone_and_what_a_damaged_one_does_stays() -> None:
    book = TopicBook()
    book.begin(0.0)
    for number in (125, 126):
        book.add(0.0, PUBLISHER, info(number))
    book.settle(1.0)
    book.begin(1.0)
    book.add(1.0, PUBLISHER, info(126))
    book.mark_damaged()
    assert book.settle(2.0) is False
    assert names(book) == ["topic_125", "topic_126"]
    book.begin(2.0)
    book.add(2.0, PUBLISHER, info(126))
    assert book.settle(3.0) is True
    assert names(book) == ["topic_126"]


def test_a_board_that_tells_nothing_loses_nothing() -> None:
    book = TopicBook()
    book.begin(0.0)
    book.add(0.0, PUBLISHER, info(125))
    book.settle(1.0)
    book.begin(1.0)
    assert book.settle(2.0) is True
    assert names(book) == ["topic_125"]


def test_of_a_board_that_was_started_anew_only_what_it_tells_since_then_holds() -> None:
    book = TopicBook()
    book.mark_damaged()  # so that what is told once replaces nothing
    for time in (0.0, 1.0):
        book.begin(time)
        for told_by in (PUBLISHER, SUBSCRIBER):
            book.add(time, told_by, info(100, "old"))
        book.settle(time + 0.5)
    assert book.has_all and book.takes(info(100, "old"))
    book.forget()
    assert not book.has_all and not book.takes(info(100, "old"))
    assert book.endpoints() == [] and book.incoming(100) is None
    book.begin(2.0)
    book.add(2.0, SUBSCRIBER, info(100, "new"))
    assert book.takes(info(100, "new")) and not book.takes(info(100, "old"))
    book.mark_damaged()
    assert book.settle(2.5) is False and not book.has_all
    book.begin(3.0)
    book.add(3.0, SUBSCRIBER, info(100, "new"))
    assert book.settle(3.5) is True and book.has_all
    assert names(book) == ["new"]


def test_an_id_that_is_told_anew_is_what_was_told_last() -> None:
    book = TopicBook()
    book.begin(0.0)
    book.add(0.0, PUBLISHER, info(125, "motor_outqut"))
    book.mark_damaged()
    book.settle(1.0)
    book.begin(1.0)
    book.add(1.0, PUBLISHER, info(125, "motor_output"))
    assert names(book) == ["motor_output"]


def test_where_bytes_are_damaged_each_topic_has_to_be_told_twice_alike() -> None:
    book = TopicBook()
    book.mark_damaged()
    told = ["motor_outqut", "motor_output", "motor_output"]
    for time, (name, is_complete) in enumerate(zip(told, [False, False, True])):
        book.begin(float(time))
        book.add(float(time), PUBLISHER, info(125, name))
        assert book.settle(time + 0.5) is is_complete
        assert names(book) == [name]
    book.begin(3.0)  # what is known is told once more
    book.add(3.0, PUBLISHER, info(125, "motor_output"))
    assert book.settle(3.5) is True


def test_where_bytes_are_damaged_what_is_told_once_replaces_nothing() -> None:
    book = TopicBook()
    book.mark_damaged()
    for time, name in enumerate(["old", "old", "new", "new"]):
        book.begin(float(time))
        book.add(float(time), PUBLISHER, info(125, name))
        assert book.settle(time + 0.5) is (time == 1)
        assert names(book) == ["new" if time == 3 else "old"]
    book.begin(4.0)
    book.add(4.0, PUBLISHER, info(125, "new"))
    assert book.settle(4.5) is True


def test_rounds_that_never_agree_come_to_an_end() -> None:
    book, rounds = TopicBook(), 0
    book.mark_damaged()
    is_complete: Optional[bool] = False
    while not is_complete:
        book.begin(float(rounds))
        book.add(float(rounds), PUBLISHER, info(125, f"topic_{rounds}"))
        is_complete = book.settle(rounds + 0.5)
        rounds += 1
    assert rounds == MOST_ROUNDS


def test_damaged_rounds_come_to_an_end() -> None:
    book, rounds = TopicBook(), 1
    book.begin(0.0)
    book.mark_damaged()
    while book.settle(float(rounds)) is False:
        rounds += 1
        book.begin(float(rounds) - 0.5)
        book.mark_damaged()
    assert rounds == MOST_ROUNDS
    book.begin(100.0)
    book.mark_damaged()
    assert book.settle(101.0) is False


def test_rounds_that_are_broken_off_come_to_an_end_too() -> None:
    """As by a topic that is told wrong each time, and whose messages have the board asked anew."""
    book, rounds = TopicBook(), 0
    book.begin(0.0)
    while not book.settle(float(rounds)) and rounds < 2 * MOST_ROUNDS:
        book.begin(float(rounds))  # by a message whose id is not known
        book.mark_damaged()
        rounds += 1
    assert rounds < MOST_ROUNDS
    book.forget()
    book.begin(100.0)
    book.mark_damaged()
    assert book.settle(101.0) is False  # a board that was started anew is asked as often again


def test_rounds_before_the_board_answers_do_not_count() -> None:
    book = TopicBook()
    for number in range(MOST_ROUNDS - 1):
        book.begin(float(number), is_answering=False)
        book.mark_damaged()
    book.begin(100.0)
    book.mark_damaged()
    assert book.settle(101.0) is False


def test_there_is_a_limit_and_what_is_known_may_change_beyond_it() -> None:
    book = TopicBook()
    book.begin(0.0)
    for number in range(MOST_TOPICS):
        assert book.add(0.0, PUBLISHER, info(100 + number))
    assert not book.add(0.0, PUBLISHER, info(5000))
    assert book.add(0.0, PUBLISHER, info(100, "other"))
    assert len(book.endpoints()) == MOST_TOPICS


def test_longest_message_is_that_of_what_the_board_sends() -> None:
    book = TopicBook()
    book.begin(0.0)
    assert book.longest == 0
    book.add(0.0, SUBSCRIBER, info(100, size=900))
    book.add(0.0, PUBLISHER, info(125, size=300))
    book.add(0.0, PUBLISHER, info(126, size=200))
    assert book.longest == 300
