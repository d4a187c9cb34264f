"""Reasons for skipped topics are logged once, and rate-limited."""

from ros2_bridge.rules.skip_log import SkipLog, Unbridgeable


def test_each_reason_is_logged_once() -> None:
    log = SkipLog()
    assert log.next_line(0.0) is None
    log.report("/a, since it is odd")
    log.report("/b, too")
    log.report("/a, since it is odd")
    assert log.next_line(0.0) == "not bridged: /a, since it is odd; /b, too"
    log.report("/b, too")
    assert log.next_line(9.0) is None


def test_five_reasons_a_line_and_a_line_a_second() -> None:
    log = SkipLog()
    for number in range(7):
        log.report(f"/{number}")
    assert log.next_line(20.0) == "not bridged: /0; /1; /2; /3; /4"
    assert log.next_line(20.9) is None
    assert log.next_line(21.0) == "not bridged: /5; /6"


def test_whatever_fails_is_a_reason() -> None:
    log = SkipLog()
    for error in (
        Unbridgeable("pkg/A differs"),
        ValueError("bad name:\n  '/1'\n    ^"),
        KeyError(),
    ):
        with log.catching("/1"):
            raise error
    with log.catching("/fine"):
        pass
    assert log.next_line(0.0) == "not bridged: pkg/A differs; /1: bad name; /1: KeyError()"


def test_reason_is_current_while_polls_report_it() -> None:
    log = SkipLog()
    log.report("/b")
    log.report("/a")
    assert log.current() == ["/a", "/b"]
    log.end_poll()
    log.report("/a")
    assert log.current() == ["/a", "/b"]  # the current poll may not have reached /b yet
    log.end_poll()
    assert log.current() == ["/a"]
    log.end_poll()
    log.end_poll()
    assert log.current() == []
    log.report("/b")
    assert log.current() == ["/b"]
