"""Values that are set: written, confirmed by the node or refused by it, and never forgotten."""

from typing import Any, Callable, Dict, List, Mapping, Tuple

import pytest

from nodekit.live.description import as_yaml
from nodekit.parameters.declaration import FloatParameter, ParameterSet, describe
from topic_scope import settings
from topic_scope.background import Background
from topic_scope.panels import Panel
from topic_scope.settings import Settings

NODE = "/gauge"


class Gauge(ParameterSet):
    """Two numbers."""

    low = FloatParameter(0.0, minimum=-100.0, maximum=100.0, help="lower limit")
    high = FloatParameter(10.0, minimum=-100.0, maximum=100.0, help="upper limit")


class FakeBackground(Background):
    """Does work at once and delivers the result a moment later; a node that hangs has none."""

    def __init__(self, later: Callable[[float, Callable[[], None]], None]) -> None:
        super().__init__(lambda function: later(0.001, function))
        self.hangs = False

    def run(self, what: Any, work: Callable[[], Any], then: Callable[[Any], None]) -> bool:
        if what in self._busy or (self.hangs and what != "write"):
            return False
        self._busy.add(what)
        try:
            result: Any = work()
        except Exception as error:
            result = error

        def finish() -> None:
            self._busy.discard(what)
            then(result)

        self._deliver(finish)
        return True


class World:
    """A node, a master and a clock that a test moves on."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 100.0
        self.in_force: Dict[str, float] = {"low": 0.0, "high": 10.0}
        self.accepts = True
        self.warned: List[str] = []
        self.is_reachable = True
        self.written: List[Mapping[str, Any]] = []
        self.answers: List[Dict[str, Any]] = []
        self.told: List[Tuple[str, Any]] = []
        self._timers: List[Tuple[float, Callable[[], None]]] = []
        self.background = FakeBackground(self.later)
        self.panel = Panel(NODE, self.describe(NODE), {})
        monkeypatch.setattr(settings.time, "monotonic", lambda: self.now)
        self.settings = Settings(
            self.background, self.later, self.write, self.describe, lambda _: self.warned, self.tell
        )

    def later(self, seconds: float, function: Callable[[], None]) -> None:
        self._timers.append((self.now + seconds, function))

    def write(self, values: Mapping[str, Any]) -> None:
        if not self.is_reachable:
            raise ConnectionRefusedError()
        self.written.append(values)
        if self.accepts:
            self.in_force.update({name.rpartition("/")[2]: value for name, value in values.items()})

    def describe(self, _node: str) -> str:
        return as_yaml(describe(Gauge(**self.in_force)))

    def tell(self, panel: Panel, names: List[str]) -> None:
        self.told += [(name, panel.values[name]) for name in names]

    def set(self, name: str, value: Any) -> None:
        self.settings.set(self.panel, name, value, self.answers.append)
        self.wait(0.01)

    def wait(self, seconds: float) -> None:
        end = self.now + seconds
        while self._timers and min(self._timers, key=lambda timer: timer[0])[0] <= end:
            timer = min(self._timers, key=lambda timer: timer[0])
            self._timers.remove(timer)
            self.now = max(self.now, timer[0])
            timer[1]()
        self.now = end

    def is_at_rest(self) -> bool:
        return not self._timers and not self.settings._asked and not self.settings._confirming


@pytest.fixture()
def world(monkeypatch: "pytest.MonkeyPatch") -> World:
    return World(monkeypatch)


def test_a_good_value_is_written_and_told(world: World) -> None:
    world.set("low", 5)
    assert world.written == [{NODE + "/low": 5.0}]
    assert world.told == [("low", 5.0)]
    world.wait(1.0)
    assert world.answers == [] and world.is_at_rest()


def test_a_value_out_of_range_is_not_written(world: World) -> None:
    world.set("low", 500)
    assert world.written == [] and world.told == []
    refused, value = world.answers
    assert refused["type"] == "refused" and "[-100, 100]" in refused["text"]
    assert (value["type"], value["value"]) == ("value", 0.0)


def test_what_the_node_warns_of_is_the_reason(world: World) -> None:
    world.accepts = False
    world.warned = ["parameter /gauge/low: 50 is refused, allowed is less than high"]
    world.set("low", 50)
    world.wait(0.5)
    refused, value = world.answers
    assert refused["text"] == world.warned[0] and refused["value"] == 50.0
    assert value["value"] == 0.0
    assert world.told == [("low", 50.0), ("low", 0.0)]
    assert world.is_at_rest()


def test_a_node_that_says_nothing_has_some_time(world: World) -> None:
    world.accepts = False
    world.set("low", 50)
    world.wait(settings.PATIENCE_S * 0.9)
    assert world.answers == []
    world.in_force["low"] = 50.0
    world.wait(1.0)
    assert world.answers == [] and world.is_at_rest()


def test_a_node_that_never_takes_a_value_has_refused_it(world: World) -> None:
    world.accepts = False
    world.set("low", 50)
    world.wait(10.0)
    assert "has not taken" in world.answers[0]["text"]
    assert world.told[-1] == ("low", 0.0) and world.is_at_rest()


def test_a_node_that_hangs_is_said_to(world: World) -> None:
    world.background.hangs = True
    world.set("low", 50)
    world.wait(10.0)
    assert "does not answer" in world.answers[0]["text"] and world.is_at_rest()


def test_a_master_that_is_gone_is_said_to_be(world: World) -> None:
    world.is_reachable = False
    world.set("low", 50)
    assert "master does not answer" in world.answers[0]["text"]
    world.wait(10.0)
    assert len(world.answers) == 2 and world.is_at_rest()


def test_only_the_last_of_several_values_is_judged(world: World) -> None:
    for value in range(20):
        world.set("low", value)
        world.wait(0.05)
    world.set("high", 99)
    world.wait(1.0)
    assert world.in_force == {"low": 19.0, "high": 99.0}
    assert world.answers == [] and world.is_at_rest()


def test_an_answer_from_before_a_value_says_nothing_of_it(world: World) -> None:
    world.set("low", 5)
    world.wait(settings.CONFIRM_S - 0.0085)  # the node has been asked, its answer is on the way
    world.accepts = False
    world.set("low", 7)
    world.wait(10.0)
    assert "has not taken" in world.answers[0]["text"] and world.is_at_rest()
