"""Tests of arguments of a wrong type, which are rejected at the call."""

import asyncio
import functools
import math
from typing import Any, Callable, Iterator, List, Tuple, Type

import pytest
import rospy
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import (
    Client,
    FollowedParameter,
    ManagedNode,
    Node,
    ParameterClient,
    SingleThreadedExecutor,
    call_service,
    host,
    host_all,
    probe_service,
    run,
)
from nodekit.argument_checks import check_function
from nodekit.groups.callback_groups import NoGroup
from nodekit.managed.activation_gate import ActivationGate
from nodekit.managed.lifecycle_scope import LifecycleScope
from nodekit.master import MasterClient
from nodekit.node.callbacks import Callback
from nodekit.node.clients import CallFuture
from nodekit.node.names import Names

NO_WATCHER: Any = None


async def awaited(*_: Any) -> None:
    """Coroutine that is never awaited."""


async def awaited_often(*_: Any) -> Any:
    yield 1


def generator(*_: Any) -> Iterator[int]:
    yield 1


class Mistaken:
    """Class with methods, and a call, that are not callbacks."""

    async def on_message(self, _: Any) -> None:
        pass

    async def __call__(self, *_: Any) -> None:
        pass


def node() -> Any:
    return Node(Names("/lab/one", True))


def client() -> Any:
    return Client("/lab/ask", Trigger, Callback(NoGroup(), print, "done"))


def future() -> Any:
    return CallFuture(client(), 1.0)


def lifecycle_scope() -> Any:
    return LifecycleScope(node(), ActivationGate(), "configure")


#: Methods that take a function, and its purpose in the error.
TAKERS: List[Tuple[str, Callable[[Any], Any]]] = [
    ("/lab/topic", lambda given: node().create_subscription("topic", String, given)),
    ("/lab/topic", lambda given: node().create_subscription("topic", String, given, finite=True)),
    ("/lab/topic", lambda given: node().create_batch_subscription("topic", String, given)),
    ("/lab/ask", lambda given: node().create_service("ask", Trigger, given)),
    ("/lab/one: ", lambda given: node().create_timer(1.0, given)),
    ("/lab/one: on_shutdown", lambda given: node().on_shutdown(given)),
    ("/lab/one: before_deactivate", lambda given: node().before_deactivate(given)),
    ("/lab/one: before_deactivate", lambda given: lifecycle_scope().before_deactivate(given)),
    ("/lab/ask: add_done_callback", lambda given: future().add_done_callback(given)),
    ("/lab/key", lambda given: FollowedParameter("/lab/key", NO_WATCHER, given)),
    ("/lab/one: class", lambda given: node().host("one", "/lab", given)),
    ("run: class", lambda given: run("one", given)),
]


def refusal(give: Callable[[], Any], kind: Type[Exception] = TypeError) -> str:
    """Return why something is refused."""
    with pytest.raises(kind) as caught:
        give()
    return str(caught.value)


@pytest.mark.parametrize("what, take", TAKERS)
@pytest.mark.parametrize("given", [None, "text", 5.0])
def test_callback_that_is_not_a_function_is_refused(
    what: str, take: Callable[[Any], Any], given: Any
) -> None:
    text = refusal(lambda: take(given))
    assert text.startswith(what)
    assert text.endswith(f": refused {given!r}: must be a function")


@pytest.mark.parametrize("what, take", TAKERS)
def test_async_callback_is_refused(what: str, take: Callable[[Any], Any]) -> None:
    text = refusal(lambda: take(awaited))
    assert text.startswith(what)
    assert ": refused awaited: must not be async def, as it is never awaited: " in text
    assert text.endswith("write def, and in it asyncio.run(...) around what must be awaited")


#: Number of arguments that the functions of TAKERS are called with.
COUNTS = [1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1]


class Beating:
    """A class with callbacks of all numbers of arguments."""

    def take_0(self) -> None:
        pass

    def take_1(self, first: Any) -> None:
        pass

    def take_2(self, first: Any, second: Any) -> None:
        pass

    def take_1_or_2(self, first: Any, second: int = 5) -> None:
        pass


@pytest.mark.parametrize("taker, count", list(zip(TAKERS, COUNTS)))
def test_callback_with_another_number_of_arguments_is_refused_at_its_line(
    taker: Tuple[str, Callable[[Any], Any]], count: int
) -> None:
    what, take = taker
    given = Beating().take_1 if count == 0 else Beating().take_0
    text = refusal(lambda: take(given))
    assert text.startswith(what)
    assert f": refused Beating.{given.__name__}: must take " in text
    parameters, number = ("(first)", "no") if count == 0 else ("()", "one")
    assert text.endswith(f"must take {number} argument, and its parameters are {parameters}")


@pytest.mark.parametrize("name, fits", [("take_1", True), ("take_2", False), ("take_1_or_2", True)])
def test_callback_needs_no_more_arguments_than_it_gets(name: str, fits: bool) -> None:
    function = getattr(Beating(), name)
    if fits:
        node().create_timer(1.0, function)
    else:
        text = refusal(lambda: node().create_timer(1.0, function))
        assert text.endswith("must take one argument, and its parameters are (first, second)")


def test_callback_of_changes_takes_the_new_and_the_old_values() -> None:
    text = refusal(lambda: check_function(Beating().take_1, "on_change", 2))
    must = "must take 2 arguments, and its parameters are (first)"
    assert text == f"on_change: refused Beating.take_1: {must}"


def test_rate_has_no_argument() -> None:
    text = refusal(lambda: node().create_timer(Beating().take_1, print))
    assert text.startswith("/lab/one: rate: refused Beating.take_1: must take no argument")


def test_proposed_replacement_of_async_works() -> None:
    def callback(argument: Any) -> None:
        asyncio.run(awaited(argument))

    check_function(callback, "callback")
    callback(1)


@pytest.mark.parametrize(
    "given, shown",
    [
        (Mistaken().on_message, "Mistaken.on_message"),
        (Mistaken(), "<"),
        (functools.partial(awaited, 1), "functools.partial("),
        (awaited_often, "awaited_often"),
    ],
)
def test_async_in_every_form(given: Any, shown: str) -> None:
    text = refusal(lambda: node().create_subscription("topic", String, given))
    assert text.startswith(f"/lab/topic: refused {shown}")
    assert "must not be async def" in text


def test_generator_would_do_nothing() -> None:
    text = refusal(lambda: node().create_timer(1.0, generator))
    assert text.startswith("/lab/one: generator: refused generator: must not have a yield")


@pytest.mark.parametrize("given", [print, Mistaken, String, [].append, functools.partial(print)])
def test_whatever_can_be_called_is_a_function(given: Any) -> None:
    """A class too, whatever its objects do when they are called."""
    node().create_subscription("topic", String, given)


def test_async_rate_is_refused() -> None:
    text = refusal(lambda: node().create_timer(awaited, print))
    assert text.startswith("/lab/one: rate: refused awaited: must not be async def")


def test_async_callback_of_a_managed_node_is_refused() -> None:
    class Managed(ManagedNode):
        async def on_configure(self, made: Any) -> None:  # type: ignore[override]
            pass

    text = refusal(lambda: Managed(node()))
    assert text.startswith("/lab/one: callback of configuring: refused ")
    assert "Managed.on_configure: must not be async def" in text


@pytest.mark.parametrize(
    "give",
    [
        lambda given: node().create_publisher("topic", given),
        lambda given: node().create_subscription("topic", given, print),
        lambda given: node().create_subscription("topic", given, print, finite=True),
        lambda given: node().create_batch_subscription("topic", given, print),
        lambda given: node().create_latest_message("topic", given),
        lambda given: lifecycle_scope().create_publisher("topic", given),
    ],
)
@pytest.mark.parametrize(
    "given, shown",
    [
        ("std_msgs/Float32", "'std_msgs/Float32'"),
        (None, "None"),
        (String("hello"), 'data: "hello"'),
        (Trigger, "Trigger"),
        (str, "str"),
    ],
)
def test_non_message_class_is_refused(give: Callable[[Any], Any], given: Any, shown: str) -> None:
    must = "must be a message class, such as std_msgs.msg.Float32"
    assert refusal(lambda: give(given)) == f"topic /lab/topic: refused {shown}: {must}"


@pytest.mark.parametrize(
    "give",
    [
        lambda given: node().create_service("ask", given, print),
        lambda given: node().create_client("ask", given),
        lambda given: call_service("/lab/ask", given),
    ],
)
@pytest.mark.parametrize(
    "given, shown",
    [
        ("std_srvs/Trigger", "'std_srvs/Trigger'"),
        (None, "None"),
        (TriggerResponse, "TriggerResponse"),
        (Trigger(), "<"),
    ],
)
def test_non_service_class_is_refused(give: Callable[[Any], Any], given: Any, shown: str) -> None:
    text = refusal(lambda: give(given))
    assert text.startswith(f"service /lab/ask: refused {shown}")
    assert text.endswith(": must be a service class, such as std_srvs.srv.Trigger")


def test_refused_objects_are_not_created() -> None:
    one = node()
    for give in (
        lambda: one.create_subscription("topic", Trigger, print),
        lambda: one.create_service("ask", TriggerResponse, print),
        lambda: one.create_client("ask", TriggerResponse),
    ):
        refusal(give)
    assert not list(one.callbacks())


def test_messages_of_any_type_and_of_services_are_messages() -> None:
    for kind in (rospy.AnyMsg, Float32, TriggerResponse):
        node().create_subscription("topic", kind, print)
        node().create_publisher("topic", kind)


@pytest.mark.parametrize(
    "give, what",
    [
        (
            lambda: node().create_publisher(String, "topic"),
            "name, which comes first: refused String",
        ),
        (
            lambda: node().create_subscription(print, String, "topic"),
            "name, which comes first: refused ",
        ),
        (lambda: node().create_timer(print, 5.0), "/lab/one: a timer: refused 5.0"),
        (lambda: run(Mistaken, "one"), "run: name, which comes first: refused Mistaken"),
        (lambda: node().host("one", Mistaken, "/lab"), "namespace: refused Mistaken"),
        (lambda: host_all(node(), [(Mistaken, "/lab", "one")]), "node name: refused Mistaken"),
    ],
)
def test_arguments_in_another_order(give: Callable[[], Any], what: str) -> None:
    text = refusal(give)
    assert text.startswith(what)
    assert text.endswith((": must be text", ": must be a function"))


@pytest.mark.parametrize(
    "members, what",
    [
        ({"one": Mistaken}, "members: refused {'one': <class"),
        ("abc", "members: refused 'abc': must be a list; each"),
        (Mistaken, "members: refused <class"),
        (zip("a", "b", "c"), "members: refused <zip object"),
        (None, "members: refused None: must be a list; each"),
        (["one", "two"], "member: refused 'one'"),
        ([("one", "", Mistaken), ("two", Mistaken)], "member: refused ('two', <class"),
        ([Mistaken], "member: refused <class"),
        (["abc"], "member: refused 'abc'"),
    ],
)
def test_members_that_cannot_be_hosted(members: Any, what: str) -> None:
    must = " must be (name, namespace, class), such as ('talker', 'robot1', Talker)"
    for give in (lambda: host_all(node(), members), lambda: host("host", members)):
        text = refusal(give)
        assert text.startswith("host: " + what)
        assert text.endswith(must)


@pytest.mark.parametrize(
    "timeout", [None, 0.0, -1.0, math.nan, math.inf, 2e9, "5", rospy.Duration(5)]
)
@pytest.mark.parametrize(
    "give",
    [
        lambda timeout: client().call(Trigger._request_class(), timeout=timeout),
        lambda timeout: client().call_async(Trigger._request_class(), timeout),
        lambda timeout: call_service("/lab/ask", Trigger, timeout=timeout),
        lambda timeout: probe_service("/lab/ask", timeout),
        lambda timeout: ParameterClient("/lab/one", timeout),
        lambda timeout: MasterClient("/lab/one", timeout=timeout),
    ],
)
def test_request_without_a_time_out(give: Callable[[Any], Any], timeout: Any) -> None:
    text = refusal(lambda: give(timeout), ValueError)
    assert text == f"timeout: refused {timeout!r} s: must be a number in (0, 1e+09]"


@pytest.mark.parametrize("timeout", [None, math.nan, "5", rospy.Duration(5)])
@pytest.mark.parametrize(
    "give",
    [
        lambda timeout: client().wait_for_service(timeout),
        lambda timeout: SingleThreadedExecutor().shutdown(timeout),
    ],
)
def test_waiting_without_a_time_out(give: Callable[[Any], Any], timeout: Any) -> None:
    text = refusal(lambda: give(timeout), ValueError)
    must = "must be a number, or math.inf for no limit"
    assert text == f"timeout: refused {timeout!r} s: {must}"


def test_waiting_without_a_limit() -> None:
    assert SingleThreadedExecutor().shutdown(math.inf)


@pytest.mark.parametrize("declaration", [None, String, "Settings", object()])
def test_parameters_that_are_not_declared_in_a_class(declaration: Any) -> None:
    text = refusal(lambda: node().declare_parameters(declaration))
    assert text.startswith("/lab/one: parameters: refused ")
    assert text.endswith(": must be a class that derives from ParameterSet")


def test_decorated_callback_is_checked_by_the_parameters_of_the_decorator() -> None:
    def without() -> None:
        """Take nothing."""

    @functools.wraps(without)
    def with_message(_message: object) -> None:
        without()

    check_function(with_message, "what", 1)


def test_callable_with_an_odd_signature_is_accepted() -> None:
    class Proxy:
        def __getattr__(self, name: str) -> object:
            return object()

        def __call__(self, *_arguments: object) -> None:
            """Take anything."""

    check_function(Proxy(), "what", 1)
