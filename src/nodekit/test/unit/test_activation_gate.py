"""Tests of activation changes while a publisher or a timer of a managed node is in use."""

import threading
from typing import Any, Callable, Iterator, List, Optional

import pytest
from std_msgs.msg import String

from nodekit.groups.callback_groups import Group
from nodekit.managed.activation_gate import ActivationGate, ManagedPublisher, ManagedTimer
from nodekit.messaging.publisher import Publisher
from nodekit.node.timers import NodeTimer, ParameterRates
from nodekit.testing.waiting import in_thread
from nodekit.timing.clocks import MonotonicClock
from nodekit.timing.scheduler import Scheduler

TIMEOUT_S = 10.0


class Sent:
    """Fake sender that calls a test's function during the first message."""

    def __init__(self) -> None:
        self.words: List[str] = []
        self.meanwhile: Callable[[], Any] = lambda: None

    def __call__(self, _publisher: Publisher, message: String) -> None:
        meanwhile, self.meanwhile = self.meanwhile, lambda: None
        meanwhile()
        self.words.append(message.data)


@pytest.fixture
def sent(monkeypatch: "pytest.MonkeyPatch") -> Sent:
    found = Sent()
    monkeypatch.setattr(Publisher, "publish", lambda *args: found(*args))
    return found


@pytest.fixture
def scheduler() -> Iterator[Scheduler]:
    made = Scheduler(MonotonicClock())
    yield made
    made.close()


def wait_for(function: Callable[..., Any], *arguments: Any) -> None:
    thread = in_thread(function, *arguments)
    thread.join(TIMEOUT_S)
    assert not thread.is_alive(), "the gate blocks the sending thread"


@pytest.mark.parametrize("thread", [True, False])
def test_latched_state_is_sent_before_newer_messages(sent: Sent, thread: bool) -> None:
    gate = ActivationGate()
    state = ManagedPublisher(gate, "/state", String, latch=True)
    state.publish(String("older"))

    def publish_newer() -> None:
        state.publish(String("newer"))

    sent.meanwhile = (lambda: wait_for(publish_newer)) if thread else publish_newer
    gate.allow_publishing(True)
    state.publish(String("newest"))
    assert sent.words == ["older", "newer", "newest"]


def test_state_of_before_is_sent_once(sent: Sent) -> None:
    gate = ActivationGate()
    state = ManagedPublisher(gate, "/state", String, latch=True)
    state.publish(String("older"))
    sent.meanwhile = lambda: wait_for(state.update)
    gate.allow_publishing(True)
    state.update()
    assert sent.words == ["older"]


def test_unsendable_state_does_not_hold_back_the_others(
    sent: Sent, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    gate = ActivationGate()
    state = ManagedPublisher(gate, "/state", String, latch=True)
    state.publish(String("bad"))

    def fail() -> None:
        raise ValueError("on purpose")

    sent.meanwhile = fail
    with pytest.raises(ValueError, match="on purpose"):
        gate.allow_publishing(True)
    state.publish(String("good"))
    assert sent.words == ["good"]


@pytest.mark.parametrize("latch", [True, False])
def test_wrong_argument_is_refused_while_the_node_is_not_active(latch: bool) -> None:
    publisher = ManagedPublisher(ActivationGate(), "/words", String, latch)
    for argument in (3, String):
        with pytest.raises(TypeError, match="topic /words: refused"):
            publisher.publish(argument)
    assert publisher.dropped == 0


def test_closed_timer_does_not_ask_for_its_rate(scheduler: Scheduler) -> None:
    asked: List[str] = []

    def rate() -> float:
        asked.append("rate")
        return 0.0

    rates = ParameterRates()
    timer = NodeTimer(scheduler, Group(), rate, lambda _elapsed: None, 0.0, "timer")
    rates.add(timer)
    NodeTimer.start_together([timer])
    rates.update()
    timer.close()
    rates.update()
    assert len(asked) == 2


def test_timer_is_held_that_asks_for_its_rate_as_the_node_ceases_to_be_active(
    scheduler: Scheduler,
) -> None:
    gate = ActivationGate()
    meanwhile: Optional[Callable[[], None]] = None

    def rate() -> float:
        if meanwhile is not None:
            meanwhile()
        return 5.0

    timer = ManagedTimer(gate, scheduler, Group(), rate, lambda elapsed: None, 0.0, "timer")
    ManagedTimer.start_together([timer])
    gate.allow_ticking(True)
    assert timer._timer.timetable.deadline is not None
    meanwhile = lambda: wait_for(gate.allow_ticking, False) if gate.ticks else None  # noqa: E731
    timer.update_rate()
    assert timer._timer.timetable.deadline is None
    timer.close()


@pytest.mark.parametrize("managed", [True, False])
def test_rate_of_before_a_change_is_not_set_after_that_of_it(
    scheduler: Scheduler, managed: bool
) -> None:
    rates = [5.0]
    meanwhile: Optional[Callable[[], None]] = None

    def rate() -> float:
        found = rates[-1]
        if meanwhile is not None and len(rates) == 1:
            rates.append(7.0)
            meanwhile()
        return found

    options = scheduler, Group(), rate, lambda elapsed: None, 0.0, "timer"
    gate = ActivationGate()
    gate.allow_ticking(True)
    timer = ManagedTimer(gate, *options) if managed else NodeTimer(*options)
    NodeTimer.start_together([timer])
    meanwhile = lambda: wait_for(timer.update_rate)  # noqa: E731
    timer.update_rate()
    assert timer._timer.timetable._rate == 7.0
    timer.close()


def test_managed_timer_has_the_rate_that_is_wanted_last(
    scheduler: Scheduler, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    gate = ActivationGate()
    gate.allow_ticking(True)
    timer = ManagedTimer(gate, scheduler, Group(), 5.0, lambda elapsed: None, 0.0, "timer")
    set_rate = timer._timer.set_rate
    other = threading.Thread(target=timer.set_rate, args=(7.0,), daemon=True)

    def set_while_another_one_is_set(rate: float) -> None:
        if other.ident is None:
            other.start()
            other.join(0.1)  # or it waits for its turn
        set_rate(rate)

    monkeypatch.setattr(timer._timer, "set_rate", set_while_another_one_is_set)
    timer.set_rate(6.0)
    other.join(TIMEOUT_S)
    assert timer._timer.timetable._rate == 7.0
    timer.close()
