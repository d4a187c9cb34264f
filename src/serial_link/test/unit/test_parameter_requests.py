"""Which parameter request of a board may be answered."""

from serial_link.host.parameter_requests import ANSWER_WITHIN_S, PAUSE_S, ParameterRequests


def test_only_the_last_request_is_pending_and_only_for_a_while() -> None:
    requests = ParameterRequests()
    first = requests.add(10.0)
    assert requests.is_pending(10.0, first)
    second = requests.add(10.1)
    assert not requests.is_pending(10.1, first)
    assert requests.is_pending(10.1 + 0.99 * ANSWER_WITHIN_S, second)
    assert not requests.is_pending(10.1 + 1.01 * ANSWER_WITHIN_S, second)


def test_first_request_after_a_pause_is_not_answered_and_the_next_one_is() -> None:
    requests = ParameterRequests()
    for now in (10.0, 10.2, 10.4 + PAUSE_S):
        requests.poll(now)
    now = 10.4 + PAUSE_S
    assert not requests.is_pending(now, requests.add(now))
    assert requests.is_pending(now, requests.add(now))


def test_request_long_after_a_pause_is_answered() -> None:
    requests = ParameterRequests()
    requests.poll(10.0)
    requests.poll(12.0)
    requests.poll(12.5)
    now = 12.1 + PAUSE_S
    assert requests.is_pending(now, requests.add(now))


def test_first_poll_is_not_a_pause() -> None:
    requests = ParameterRequests()
    requests.poll(100.0)
    assert requests.is_pending(100.0, requests.add(100.0))
