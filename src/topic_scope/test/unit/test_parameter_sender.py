"""Values from a page: sent to the node, and accepted or rejected with the reason of the node."""

from typing import Any, Callable, Dict, List, Mapping, Tuple

import pytest

from nodekit import FloatParameter, ListParameter, ParameterError, ParameterSet, describe, rule
from nodekit.testing.offline_parameters import OfflineParameters
from topic_scope.controls.panel import ParameterPanel
from topic_scope.controls.parameter_sender import ChangeReply, ParameterSender
from topic_scope.graph.worker import Worker

NODE = "/gauge"


class Gauge(ParameterSet):
    """Two numbers, and two lists of equal length."""

    low = FloatParameter(0.0, minimum=-100.0, maximum=100.0, help="lower limit")
    high = FloatParameter(10.0, minimum=-100.0, maximum=100.0, help="upper limit")
    xs = ListParameter([1.0], element=FloatParameter(0.0, help=""), help="a list")
    ys = ListParameter([2.0], element=FloatParameter(0.0, help=""), help="another")

    @rule("low", "high")
    def _ordered(self) -> None:
        if self.low > self.high:
            raise ValueError("low <= high")

    @rule("xs", "ys")
    def _one_length(self) -> None:
        if len(self.xs) != len(self.ys):
            raise ValueError("two lists of one length")


class SlowWorker(Worker):
    """Worker that runs jobs on request, and delivers results immediately."""

    def __init__(self) -> None:
        super().__init__(lambda function: function())
        self.work: List[Callable[[], None]] = []

    def run(self, what: Any, work: Callable[[], Any], then: Callable[[Any], None]) -> bool:
        if what in self._busy:
            return False
        self._busy.add(what)

        def do() -> None:
            try:
                result: Any = work()
            except Exception as error:
                result = error
            self._busy.discard(what)
            then(result)

        self.work.append(do)
        return True


class World:
    """A node with validated parameters, and a page."""

    def __init__(self) -> None:
        self.node = OfflineParameters(Gauge)
        self.is_silent = False
        #: Changes by another client before the response to a change arrives.
        self.overtaking: Dict[str, Any] = {}
        self.sent: List[Mapping[str, Any]] = []
        self.answers: List[Dict[str, Any]] = []
        self.reply: List[Tuple[str, Any]] = []
        self.worker = SlowWorker()
        self.panel = ParameterPanel(NODE, describe(self.node.values), {})
        self.sender = ParameterSender(self.worker, self.change, self.send, self.read_again)

    def change(self, node: str, values: Mapping[str, Any]) -> ChangeReply:
        assert node == NODE
        if self.is_silent:
            raise TimeoutError("no answer within 2 s")
        self.sent.append(values)
        try:
            self.node.change(values)
        except ParameterError as error:
            return ChangeReply(False, str(error), self.values())
        answer = ChangeReply(True, "", self.values())
        self.node.change(self.overtaking)
        self.read_again(NODE)
        return answer

    def read_again(self, node: str) -> None:
        assert node == NODE
        self.send(self.panel, self.panel.follow(self.values()))

    def values(self) -> Dict[str, Any]:
        return dict(self.node.server)

    def send(self, panel: ParameterPanel, names: List[str]) -> None:
        self.reply += [(name, panel.values[name]) for name in names]

    def ask(self, name: str, value: Any) -> None:
        self.sender.set(self.panel, name, value, self.answers.append)

    def work(self) -> None:
        while self.worker.work:
            self.worker.work.pop(0)()

    def set(self, name: str, value: Any) -> None:
        self.ask(name, value)
        self.work()

    def errors(self) -> List[str]:
        return [answer["text"] for answer in self.answers if answer["type"] == "refused"]


@pytest.fixture()
def world() -> World:
    return World()


def test_valid_value_is_sent_and_reported(world: World) -> None:
    world.set("low", 5)
    assert world.sent == [{"low": 5.0}]
    assert world.reply == [("low", 5.0)]
    assert world.answers == []


def test_reply_does_not_override_a_newer_change(world: World) -> None:
    world.overtaking = {"low": 2.0}
    world.set("low", 5)
    assert world.reply[-1] == ("low", 2.0)
    assert world.panel.values["low"] == 2.0


def test_value_out_of_range_is_not_sent(world: World) -> None:
    world.set("low", 500)
    assert world.sent == [] and world.reply == []
    refused, value = world.answers
    assert refused["type"] == "refused" and "[-100, 100]" in refused["text"]
    assert not refused["kept"]
    assert (value["type"], value["value"]) == ("value", 0.0)


def test_value_rejected_by_the_node_is_reported_with_its_reason(world: World) -> None:
    world.set("low", 50)
    (text,) = world.errors()
    assert "low <= high" in text
    assert world.answers[0]["kept"]  # it is sent again with the next change
    assert world.answers[-1] == {"type": "value", "node": NODE, "name": "low", "value": 0.0}


def test_newest_value_is_sent_after_a_busy_node_replies(world: World) -> None:
    for value in (1, 2, 3, 4):
        world.ask("low", value)
    world.work()
    assert world.sent == [{"low": 1.0}, {"low": 4.0}]
    assert world.reply[-1] == ("low", 4.0)


def test_lists_that_must_have_one_length_are_changed_one_after_the_other(world: World) -> None:
    world.set("xs", "[1, 2, 3]")
    assert len(world.errors()) == 1
    world.set("ys", "[4, 5, 6]")
    assert len(world.errors()) == 1
    assert world.node.values.xs == (1.0, 2.0, 3.0) and world.node.values.ys == (4.0, 5.0, 6.0)
    assert dict(world.reply) == {"xs": (1.0, 2.0, 3.0), "ys": (4.0, 5.0, 6.0)}


def test_rejected_value_does_not_block_others(world: World) -> None:
    world.set("xs", "[1, 2, 3]")
    world.set("high", 20)
    assert world.node.values.high == 20.0
    assert len(world.errors()) == 1
    world.set("ys", "[4, 5, 6]")
    assert world.node.values.xs == (1.0, 2.0, 3.0)


def test_newer_value_replaces_a_rejected_one(world: World) -> None:
    world.set("low", 50)
    world.set("low", 5)
    world.set("high", 60)  # with it, the node would accept the rejected value, too
    assert (world.node.values.low, world.node.values.high) == (5.0, 60.0)


def test_value_that_is_set_meanwhile_replaces_the_one_that_is_being_rejected(
    world: World,
) -> None:
    world.ask("low", 50)
    world.ask("low", 5)
    world.work()
    assert world.errors() == []
    world.set("high", 60)
    assert (world.node.values.low, world.node.values.high) == (5.0, 60.0)


def test_disappeared_node_is_dropped(world: World) -> None:
    world.set("xs", "[1, 2, 3]")
    world.sender.forget(NODE)
    world.set("high", 20)
    assert world.sent == [{"xs": [1.0, 2.0, 3.0]}, {"high": 20.0}]


def test_node_that_does_not_answer_is_named(world: World) -> None:
    world.is_silent = True
    world.set("low", 5)
    assert world.errors() == ["/gauge does not answer: no answer within 2 s"]
    assert world.answers[-1]["value"] == 0.0
    world.is_silent = False
    world.set("low", 6)
    assert world.reply == [("low", 6.0)]
