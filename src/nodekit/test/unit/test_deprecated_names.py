"""Tests of old public names: they work, and warn once with the new name."""

import importlib
import sys
import warnings
from typing import Any, Dict, Iterator, List

import pytest
from std_msgs.msg import String
from std_srvs.srv import Trigger

import nodekit
from nodekit import (
    FloatParameter,
    MutuallyExclusiveCallbackGroup,
    Node,
    ParameterSet,
    ReentrantCallbackGroup,
    deprecated,
)
from nodekit.node.names import Names
from nodekit.node.old_methods import OldMethods
from nodekit.process_context import ProcessContext
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder


class Settings(ParameterSet):
    gain = FloatParameter(1.0, help="a number")


#: Old methods: the new name, and arguments to call it with.
METHODS: Dict[str, Any] = {
    "publisher": ("create_publisher", ("topic", String)),
    "subscribe": ("create_subscription", ("topic", String, print)),
    "subscribe_batches": ("create_batch_subscription", ("topic", String, print)),
    "latest": ("create_latest_message", ("topic", String)),
    "service": ("create_service", ("service", Trigger, print)),
    "client": ("create_client", ("service", Trigger)),
    "every": ("create_timer", (1.0, print)),
    "parameters": ("declare_parameters", (Settings,)),
    "follow": ("on_parameter", ("key", print)),
    "before_end": ("on_shutdown", (print,)),
    "stream_log": ("create_rate_limited_log", ()),
    "lifetime": ("create_scope", ()),
}


@pytest.fixture(autouse=True)
def nothing_warned(monkeypatch: Any) -> None:
    monkeypatch.setattr(deprecated, "PROCESS", ProcessContext())


@pytest.fixture
def node() -> Iterator[Node]:
    node = Node(Names("/lab/one", True))
    yield node
    node.close()


def texts(caught: "List[warnings.WarningMessage]") -> List[str]:
    """Return the text of each warning; all must be deprecations that point to this file."""
    assert {(each.category, each.filename) for each in caught} <= {(DeprecationWarning, __file__)}
    return [str(each.message) for each in caught]


def test_table_has_each_old_method() -> None:
    old = [name for name, value in vars(OldMethods).items() if type(value).__name__ == "OldMethod"]
    assert sorted(old) == sorted(METHODS)


@pytest.mark.parametrize("old", METHODS)
def test_old_method_calls_the_new_one_and_warns_once(
    old: str, node: Node, monkeypatch: Any
) -> None:
    new, arguments = METHODS[old]
    calls: List[Any] = []
    monkeypatch.setattr(node, new, lambda *given, **named: calls.append((given, named)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            getattr(node, old)(*arguments)
    assert calls == 2 * [(arguments, {})]
    assert texts(caught) == [f"{old}(): deprecated name; use {new}()"]


@pytest.mark.parametrize("new, arguments", METHODS.values())
def test_new_method_does_not_warn(new: str, arguments: Any, node: Node, monkeypatch: Any) -> None:
    monkeypatch.setattr("nodekit.node.node_scope.LiveParameters", lambda *_: None)
    if new in ("declare_parameters", "on_parameter"):  # need a master
        assert callable(getattr(node, new))
        return
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        getattr(node, new)(*arguments)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_old_argument_of_every_is_the_new_one_of_create_timer(node: Node) -> None:
    timer = node.every(rate=5.0, callback=print, steady=True)
    assert type(timer) is type(node.create_timer(rate_hz=5.0, callback=print))
    with pytest.raises(TypeError, match="rate"):
        node.create_timer(rate=5.0, callback=print)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    "options, kind, is_urgent",
    [
        ({}, MutuallyExclusiveCallbackGroup, False),
        ({"urgent": True}, MutuallyExclusiveCallbackGroup, True),
        ({"exclusive": False}, ReentrantCallbackGroup, False),
    ],
)
def test_old_group_method_returns_a_group_and_warns_once(
    options: Any, kind: type, is_urgent: bool, node: Node
) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        groups = [node.group(**options), node.group(**options)]
    assert [(type(each), each.urgent) for each in groups] == 2 * [(kind, is_urgent)]
    new = "MutuallyExclusiveCallbackGroup or ReentrantCallbackGroup"
    assert texts(caught) == [f"group(): deprecated name; use {new}"]


@pytest.mark.parametrize("old, new", deprecated.OLD_NAMES.items())
def test_old_name_of_the_package_is_the_new_one_and_warns_once(old: str, new: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = [getattr(nodekit, old), getattr(nodekit, old)]
    assert found == 2 * [getattr(nodekit, new)]
    assert texts(caught) == [f"nodekit.{old}: deprecated name; use nodekit.{new}"]


def test_import_of_an_old_name_warns_at_the_line_of_the_import() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        from nodekit import give_up
    assert give_up is nodekit.abort
    assert texts(caught) == ["nodekit.give_up: deprecated name; use nodekit.abort"]


@pytest.mark.parametrize(
    "alias, name", [("Maker", "NodeScope"), ("Group", "MutuallyExclusiveCallbackGroup")]
)
def test_short_alias_does_not_warn(alias: str, name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        assert getattr(nodekit, alias) is getattr(nodekit, name)


def test_old_method_of_the_graph_calls_the_new_one_and_warns_once(monkeypatch: Any) -> None:
    graph = Graph.__new__(Graph)  # without a master
    monkeypatch.setattr(Graph, "connected_subscribers", lambda self, *names: {names})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = [graph.hearers("/talker", "/chatter") for _ in range(2)]
    assert found == 2 * [{("/talker", "/chatter")}]
    assert texts(caught) == ["hearers(): deprecated name; use connected_subscribers()"]


@pytest.mark.parametrize("name", ["console", "costs"])
def test_deprecated_module_warns_when_it_is_imported(name: str, monkeypatch: Any) -> None:
    monkeypatch.delitem(sys.modules, f"nodekit.testing.{name}", raising=False)
    with pytest.warns(DeprecationWarning, match=f"nodekit.testing.{name}: deprecated module"):
        importlib.import_module(f"nodekit.testing.{name}")


def test_old_module_of_the_recorder_has_it_under_its_old_name_and_warns(monkeypatch: Any) -> None:
    monkeypatch.delitem(sys.modules, "nodekit.testing.hearing", raising=False)
    with pytest.warns(DeprecationWarning, match="use nodekit.testing.message_recorder"):
        hearing = importlib.import_module("nodekit.testing.hearing")
    assert hearing.Ear is MessageRecorder


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_deprecated_console_parses_and_compares() -> None:
    console = importlib.import_module("nodekit.testing.console")
    page = "```console\n$ echo one\none\n```\n"
    (instruction,) = console.instructions_of(page)
    assert instruction.typed == "echo one"
    assert console.is_all(instruction.expected, "one\n")
    assert console.find(instruction.expected, console.plain("\x1b[0mone\r\n")) == 3


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_deprecated_costs_measure() -> None:
    costs = importlib.import_module("nodekit.testing.costs")
    assert 0.0 < costs.time_in_a_group() < 1e3
