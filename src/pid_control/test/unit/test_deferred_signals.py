"""Tests of the termination signals of a command."""

import signal
import threading
from typing import Any, Iterator, List

import pytest

from pid_control.programs.deferred_signals import deferred_signals, exit_on_signals

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture
def received() -> Iterator[List[int]]:
    """Collect the signals that handlers receive."""
    found: List[int] = []
    before = {
        number: signal.signal(number, lambda given, _: found.append(given)) for number in NUMBERS
    }
    yield found
    for number, handler in before.items():
        signal.signal(number, handler)


def test_deferred_signals_arrive_at_the_end_also_after_an_error(received: List[int]) -> None:
    with pytest.raises(KeyError), deferred_signals():
        for number in NUMBERS:
            signal.raise_signal(number)
        assert received == []
        raise KeyError
    assert received == list(NUMBERS)
    signal.raise_signal(signal.SIGTERM)
    assert received[3:] == [signal.SIGTERM]


def test_deferred_signals_in_another_thread_changes_nothing(received: List[int]) -> None:
    inside: List[Any] = []

    def defer() -> None:
        with deferred_signals():
            inside.append(signal.getsignal(signal.SIGTERM))

    before = signal.getsignal(signal.SIGTERM)
    thread = threading.Thread(target=defer)
    thread.start()
    thread.join()
    assert inside == [before]


def test_exit_on_signals_has_the_status_of_a_shell_and_keeps_nohup(received: List[int]) -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    exit_on_signals()
    signal.raise_signal(signal.SIGHUP)
    with pytest.raises(SystemExit) as end:
        signal.raise_signal(signal.SIGTERM)
    assert end.value.code == 143
