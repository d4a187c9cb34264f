"""Parameters, both ways."""

import collections
import math
import pathlib
import queue
import threading
from functools import partial
from types import SimpleNamespace
from typing import Any, Dict, Iterator, List, cast

import both
import pytest
import rospy
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import (
    Parameter,
    ParameterDescriptor,
    ParameterEvent,
    ParameterType,
    SetParametersResult,
)
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.node import Node
from rclpy.parameter import Parameter as Value
from rclpy.serialization import serialize_message
from test_topics import publisher1

from nodekit.testing.waiting import wait_until
from ros2_bridge.parameters import parameter_services
from ros2_bridge.parameters.messages import descriptor, to_message
from ros2_bridge.parameters.ros1_parameters import Parameter as Known
from ros2_bridge.parameters.ros1_parameters import ServerParameters
from ros2_bridge.parameters.ros1_mirror import ParametersToRos1
from ros2_bridge.parameters.parameter_services import ParametersToRos2
from ros2_bridge.ros2.client import NoResponse
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.parameters.values import BYTES, DOUBLE, DOUBLES, INTEGER, STRING, STRINGS, changes

GENERATOR = "/tuned_generator"


@pytest.fixture(scope="module")
def generator(bridge: both.Bridge) -> Iterator[both.Running]:
    with both.Running("basic_comms", "signal_generator.py", f"__name:={GENERATOR[1:]}") as running:
        yield running


def value(name: str, plain: Any) -> Parameter:
    return Value(name, value=plain).to_parameter_msg()


def get(ros: both.Both, *names: str, node: str = GENERATOR) -> List[Any]:
    answer = ros.call2(GetParameters, f"{node}/get_parameters", names=names)
    return [Value.from_parameter_msg(Parameter(value=one)).value for one in answer.values]


def set_one(ros: both.Both, name: str, plain: Any, node: str = GENERATOR) -> Any:
    request = [value(name, plain)]
    (result,) = ros.call2(SetParameters, f"{node}/set_parameters", parameters=request).results
    return result


def test_list_and_types(ros: both.Both, generator: both.Running) -> None:
    result = ros.call2(ListParameters, f"{GENERATOR}/list_parameters").result
    assert {"amplitude", "frequency", "waveform"} <= set(result.names)
    listing = {"prefixes": ["no_such_thing"]}
    result = ros.call2(ListParameters, f"{GENERATOR}/list_parameters", **listing).result
    assert (list(result.names), list(result.prefixes)) == ([], [])
    names = ["amplitude", "waveform"]
    types = ros.call2(GetParameterTypes, f"{GENERATOR}/get_parameter_types", names=names).types
    assert list(types) == [ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_STRING]
    assert not get(ros, "amplitude", "no_such_thing")  # as rclpy: all or nothing


def test_set_and_refuse(ros: both.Both, generator: both.Running) -> None:
    result = set_one(ros, "amplitude", 3.5)
    assert (result.successful, result.reason) == (True, "")
    assert get(ros, "amplitude") == [3.5]
    assert rospy.get_param(f"{GENERATOR}/amplitude") == 3.5
    result = set_one(ros, "amplitude", -1.0)
    assert not result.successful
    assert "amplitude" in result.reason and "-1" in result.reason
    assert get(ros, "amplitude") == [3.5]
    result = set_one(ros, "amplitud", 1.0)
    assert not result.successful and "amplitude" in result.reason  # the nearest known one
    assert not set_one(ros, "amplitude", "loud").successful


def test_a_whole_number_for_a_double_is_refused_as_by_rclpy(
    ros: both.Both, bridge: both.Bridge, generator: both.Running
) -> None:
    node = Node("strict")
    node.declare_parameter("amplitude", 1.0)
    ros.executor.add_node(node)
    refused = set_one(ros, "amplitude", 2, "/strict")
    assert not refused.successful and refused.reason
    ros.executor.remove_node(node)
    node.destroy_node()
    assert set_one(ros, "amplitude", 2).reason == refused.reason
    answer = ros.call2(
        SetParametersAtomically,
        f"{GENERATOR}/set_parameters_atomically",
        parameters=[value("offset", 0.5), value("amplitude", 2)],
    )
    assert (answer.result.successful, answer.result.reason) == (False, refused.reason)
    rospy.set_param("/ros2_bridge/integers_for_doubles", True)
    bridge.wait_for_log("integers_for_doubles: False -> True")
    assert set_one(ros, "amplitude", 2).successful and get(ros, "amplitude") == [2.0]
    rospy.set_param("/ros2_bridge/integers_for_doubles", False)
    bridge.wait_for_log("integers_for_doubles: True -> False")


def test_each_is_checked_by_itself(ros: both.Both, generator: both.Running) -> None:
    given = [value("offset", 0.5), value("amplitude", -2.0), value("frequency", 3.0)]
    answer = ros.call2(SetParameters, f"{GENERATOR}/set_parameters", parameters=given)
    assert [result.successful for result in answer.results] == [True, False, True]
    assert get(ros, "offset", "frequency") == [0.5, 3.0]


def test_set_atomically(ros: both.Both, generator: both.Running) -> None:
    before = get(ros, "amplitude", "offset")
    for last, is_good in ((-2.0, False), (1.25, True)):
        answer = ros.call2(
            SetParametersAtomically,
            f"{GENERATOR}/set_parameters_atomically",
            parameters=[value("offset", 0.75), value("amplitude", last)],
        )
        assert answer.result.successful is is_good
        assert get(ros, "amplitude", "offset") == ([1.25, 0.75] if is_good else before)


def test_describe(ros: both.Both, generator: both.Running) -> None:
    names = ["amplitude", "waveform"]
    answer = ros.call2(DescribeParameters, f"{GENERATOR}/describe_parameters", names=names)
    amplitude, waveform = answer.descriptors
    assert amplitude.type == ParameterType.PARAMETER_DOUBLE and amplitude.description
    (limits,) = amplitude.floating_point_range
    assert not set_one(ros, "amplitude", limits.from_value - 1e-3).successful
    assert set_one(ros, "amplitude", limits.from_value).successful
    assert waveform.additional_constraints.startswith("one of sine, ")
    names.append("no_such_thing")  # as rclpy: all or nothing
    service = f"{GENERATOR}/describe_parameters"
    assert not ros.call2(DescribeParameters, service, names=names).descriptors


def test_events(ros: both.Both, generator: both.Running) -> None:
    recorder = ros.hear2("/parameter_events", ParameterEvent)
    wait_until(
        lambda: ros.node.count_publishers("/parameter_events") > 1,
        lambda: "no events are published",
    )
    wait_until(lambda: get(ros, "amplitude"), lambda: "it is not in ROS 2")

    def told(name: str) -> List[Any]:
        return [
            Value.from_parameter_msg(one).value
            for event in recorder.heard
            if event.node == GENERATOR
            for one in event.changed_parameters
            if one.name == name
        ]

    set_one(ros, "amplitude", 4.5)
    wait_until(lambda: 4.5 in told("amplitude"), lambda: str(recorder.heard))
    set_one(ros, "amplitude", -4.5)  # refused: there is no event
    rospy.set_param(f"{GENERATOR}/amplitude", 5.5)
    wait_until(lambda: 5.5 in told("amplitude"), lambda: str(recorder.heard))
    assert told("amplitude") == [4.5, 5.5]
    recorder.end()


def test_the_bridge_has_its_own_live(ros: both.Both, bridge: both.Bridge) -> None:
    def topics() -> List[str]:
        return [name for name, _ in ros.node.get_topic_names_and_types()]

    out = publisher1(ros, "/hidden/one", "std_msgs/Float32")
    wait_until(lambda: "/hidden/one" in topics(), lambda: str(topics()))
    names = ros.call2(ListParameters, "/ros2_bridge/list_parameters").result.names
    assert {"allow", "deny", "max_nodes", "use_sim_time"} <= set(names)
    refused = set_one(ros, "max_nodes", -1, "/ros2_bridge")
    assert not refused.successful and "refused -1" in refused.reason
    assert set_one(ros, "deny", ["/hidden/*"], "/ros2_bridge").successful
    wait_until(lambda: "/hidden/one" not in topics(), lambda: str(topics()))
    assert get(ros, "deny", node="/ros2_bridge") == [["/hidden/*"]]
    assert set_one(ros, "deny", [""], "/ros2_bridge").successful
    wait_until(lambda: "/hidden/one" in topics(), lambda: str(topics()))
    out.unregister()


def test_plain_node_has_parameters_of_server(ros: both.Both, bridge: both.Bridge) -> None:
    out = rospy.Publisher("/of_the_tests", ros.types.message("std_msgs/String").raw, queue_size=1)
    rospy.set_param("/tests", {"gain": 2, "pid": {"p": 0.5}, "name": "x"})
    names = ros.call2(ListParameters, "/tests/list_parameters").result.names
    assert set(names) == {"gain", "pid.p", "name", "use_sim_time"}
    assert get(ros, "pid.p", "gain", node="/tests") == [0.5, 2]
    result = set_one(ros, "pid.p", 0.75, node="/tests")
    said = "pid.p: written to the parameter server; /tests may read it at its start only"
    assert (result.successful, result.reason) == (True, said)
    assert rospy.get_param("/tests/pid/p") == 0.75
    result = set_one(ros, "gain", 2**40, node="/tests")
    assert not result.successful and "integers of 32 bits" in result.reason
    out.unregister()


#: A node with a dynamic_reconfigure server, which halves one of its values.
STOCK = """
import rospy
from dynamic_reconfigure.cfg import TestConfig
from dynamic_reconfigure.server import Server

def change(config, level):
    config.double_no_minmax = min(config.double_no_minmax, 50.0)
    return config

rospy.init_node("stock")
server = Server(TestConfig, change)
rospy.spin()
"""


def test_stock_node_is_set_and_described_by_dynamic_reconfigure(
    ros: both.Both, bridge: both.Bridge, tmp_path: pathlib.Path
) -> None:
    script = tmp_path / "stock.py"
    script.write_text(STOCK)
    process = both.Process(str(script))
    try:
        name = "/stock/describe_parameters"
        wait_until(lambda: ros.offers2(name), lambda: "the node has no parameters in ROS 2")

        def described() -> Any:
            request = {"names": ["int_"]}
            return ros.call2(DescribeParameters, name, **request).descriptors[0]

        wait_until(lambda: described().integer_range, lambda: "the node is not described")
        limits = described().integer_range[0]
        assert set_one(ros, "int_", limits.to_value, node="/stock").successful
        assert get(ros, "int_", node="/stock") == [limits.to_value]
        result = set_one(ros, "int_", limits.to_value + 1, node="/stock")
        assert not result.successful
        assert f"must be from {limits.from_value} to {limits.to_value}" in result.reason
        result = set_one(ros, "double_no_minmax", 80.0, node="/stock")
        assert not result.successful
        assert result.reason == "double_no_minmax: /stock has set it to 50.0"
        assert get(ros, "double_no_minmax", "int_", node="/stock") == [50.0, limits.to_value]
    finally:
        process.interrupt()

    def followed() -> List[str]:
        _, subscribed, _ = rospy.get_master().getSystemState()[2]
        return dict(subscribed).get("/stock/parameter_updates", [])

    wait_until(lambda: not followed(), lambda: f"{followed()} follow it")


def test_node_that_has_just_begun_to_check_is_not_passed_over() -> None:
    written: List[Any] = []
    client: Any = SimpleNamespace(write=written.append)
    for uri in ("rosrpc://localhost:1", None):
        client.lookup_service = {"/generator/describe": uri}.get
        why = ServerParameters(client, "/generator").change({"pid.p": 2})
        assert ("/generator now checks" in why) is (uri is not None)
    assert written == [{"/generator/pid/p": 2}]


def test_node_of_ros2_is_on_the_server(ros: both.Both, bridge: both.Bridge) -> None:
    node = Node("motor_of_ros2")
    node.declare_parameter("drift", math.nan)
    node.declare_parameter("sample_time", 0.02)
    node.declare_parameter("pid.p", 3)
    node.declare_parameter("limits", [1.5, 2.5])
    node.declare_parameter("mask", [b"a", b"b"])
    node.declare_parameter("serial", 5, ParameterDescriptor(read_only=True))

    checked: List[str] = []

    def check(parameters: List[Any]) -> SetParametersResult:
        checked.extend(one.name for one in parameters)
        bad = [one for one in parameters if one.name == "sample_time" and one.value <= 0.0]
        return SetParametersResult(successful=not bad, reason="must be above 0" if bad else "")

    node.add_on_set_parameters_callback(check)
    ros.executor.add_node(node)
    key = "/motor_of_ros2/sample_time"
    wait_until(lambda: rospy.get_param(key, None) == 0.02, lambda: "not on the server")
    assert rospy.get_param("/motor_of_ros2/pid/p") == 3
    rospy.set_param(key, 1)  # a whole number stands for another
    wait_until(lambda: node.get_parameter("sample_time").value == 1.0, lambda: "not taken")
    rospy.set_param(key, -1.0)
    bridge.wait_for_log("refused by ROS 2: ", f"{key}=-1.0 (must be above 0; 1.0 stays)")
    wait_until(lambda: rospy.get_param(key) == 1.0, lambda: "not put back")
    rospy.set_param("/motor_of_ros2/serial", 6)
    why = "Trying to set a read-only parameter: serial; 5 stays"
    bridge.wait_for_log("refused by ROS 2: ", f"/motor_of_ros2/serial=6 ({why})")
    wait_until(lambda: rospy.get_param("/motor_of_ros2/serial") == 5, lambda: "not put back")
    rospy.set_param("/motor_of_ros2/sample_tme", 1.0)
    said = "the node in ROS 2 has no such parameter; did you mean sample_time?"
    bridge.wait_for_log(f"/motor_of_ros2/sample_tme: {said}")
    limits, mask = "/motor_of_ros2/limits", "/motor_of_ros2/mask"
    assert rospy.get_param(limits) == [1.5, 2.5] and rospy.get_param(mask) == [97, 98]
    rospy.set_param(limits, [])
    rospy.set_param(mask, [1, 2])
    wait_until(lambda: len(node.get_parameter("limits").value) == 0, lambda: "not emptied")
    wait_until(lambda: node.get_parameter("mask").value == [b"\1", b"\2"], lambda: "not taken")
    node.set_parameters([Value("sample_time", value=0.5)])
    wait_until(lambda: rospy.get_param(key) == 0.5, lambda: "its own change is not told")
    assert math.isnan(rospy.get_param("/motor_of_ros2/drift"))
    assert "drift" not in checked  # NaN is not set repeatedly
    ros.executor.remove_node(node)
    node.destroy_node()
    wait_until(lambda: not rospy.has_param("/motor_of_ros2/pid/p"), lambda: "it stays there")
    service = "/motor_of_ros2/set_parameters"
    wait_until(lambda: not ros.node.count_clients(service), lambda: "a client stays")


def test_malformed_responses_of_ros2_node(ros: both.Both, bridge: both.Bridge) -> None:
    node = Node("odd_of_ros2", start_parameter_services=False)
    asked: List[Any] = []

    def listed(_: Any, response: Any) -> Any:
        response.result.names = ["gain"]
        return response

    def got(_: Any, response: Any) -> Any:
        response.values = [Value("gain", value=1.5).get_parameter_value()]
        return response

    def taken(request: Any, response: Any) -> Any:
        asked.append(request.parameters)
        return response  # no result for what was to be set

    node.create_service(ListParameters, "~/list_parameters", listed)
    node.create_service(GetParameters, "~/get_parameters", got)
    node.create_service(SetParameters, "~/set_parameters", taken)
    ros.executor.add_node(node)
    key = "/odd_of_ros2/gain"
    wait_until(lambda: rospy.get_param(key, None) == 1.5, lambda: "not on the server")
    for number in range(2):  # who bridges it outlives the first
        rospy.set_param(key, 2.5)
        wait_until(lambda: len(asked) > number, lambda: str(asked))
        wait_until(lambda: rospy.get_param(key) == 1.5, lambda: "not put back")
    ros.executor.remove_node(node)
    node.destroy_node()


def test_each_node_that_does_not_spin_is_named(ros: both.Both, bridge: both.Bridge) -> None:
    nodes = [Node("asleep"), Node("dozing")]
    for node in nodes:
        name = node.get_name()
        bridge.wait_for_log(f"parameters of /{name} in ROS 2: /{name}/list_parameters")
    for node in nodes:
        node.destroy_node()


def test_that_a_node_does_not_answer_is_logged_seldom(monkeypatch: "pytest.MonkeyPatch") -> None:
    logged: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", logged.append)
    parameters: Any = ParametersToRos1.__new__(ParametersToRos1)
    parameters._quiet_until = 0.0
    for _ in range(3):
        parameters._warn_seldom("it sleeps")
    assert logged == ["it sleeps"]
    parameters._quiet_until -= 601.0
    parameters._warn_seldom("still")
    assert logged == ["it sleeps", "still"]


def test_all_is_written_again_after_a_call_without_an_answer() -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._name, mirror._quiet_until, mirror._is_closed = "/motor", math.inf, False
    mirror._work, mirror._is_written = queue.SimpleQueue(), True

    def fail() -> None:
        raise NoResponse("/motor/get_parameters in ROS 2: no answer within 2 s")

    for step in (fail, mirror._end):
        mirror._work.put(step)
    mirror._run()
    mirror.retry_write_all()
    assert mirror._work.get_nowait() == mirror._write_all


def test_unknown_parameter_is_named_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._name, mirror._values, mirror._warned = "/motor", {"gain": 1}, set()
    for names in (["gain", "gian"], ["gian"], ["xyz"]):
        mirror._warn_of_unknown(names)
    said = "the node in ROS 2 has no such parameter"
    assert lines == [f"/motor/gian: {said}; did you mean gain?", f"/motor/xyz: {said}"]


def test_events_name_new_changed_and_deleted_parameters() -> None:
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    events: List[ParameterEvent] = []
    parameters._other, parameters._turn, parameters._publish = (
        "/arm",
        threading.Lock(),
        events.append,
    )
    parameters._clock = SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: Time(sec=5)))
    parameters._known, parameters._is_known = {}, False
    for values in ({"a": 1, "b": 1}, {"a": 1, "b": 1}, {"b": 2, "c": 1}, {"b": 2, "c": 1}):
        known = {name: Known(plain, INTEGER, None) for name, plain in values.items()}
        parameters._parameters = SimpleNamespace(read=lambda known=known: known)
        assert parameters._publish_changes() == values
    (event,) = events  # its first values are no change
    parts = (event.new_parameters, event.changed_parameters, event.deleted_parameters)
    assert [[one.name for one in part] for part in parts] == [["c"], ["b"], ["a"]]
    assert (event.node, event.stamp.sec) == ("/arm", 5)


def test_change_is_published_at_once_unless_it_is_refused() -> None:
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    published: List[str] = []
    results: List[SetParametersResult] = []
    parameters._publish_changes = lambda: published.append("changes")
    for why in ("", "must be above 0"):
        parameters._parameters = SimpleNamespace(
            change=lambda _, why=why: why, caution=lambda names: f"{names} may be read later"
        )
        results.append(parameters._change([value("name", "x")]))
    assert [(one.successful, one.reason) for one in results] == [
        (True, "['name'] may be read later"),
        (False, "must be above 0"),
    ]
    assert published == ["changes"]
    parameters._is_kind = lambda: True
    assert "integers of 32 bits" in parameters._change([value("name", 2**40)]).reason

    def fail() -> Any:
        raise parameter_services.UnreadableParameters("no answer of /arm")

    parameters._is_kind, parameters._parameters.read = (lambda: False), fail
    assert parameters._change([value("rate", 2)]).reason == "no answer of /arm"


def test_second_change_is_awaited_as_long_as_the_first(monkeypatch: "pytest.MonkeyPatch") -> None:
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    parameters._lock, parameters._is_reading = threading.Lock(), True
    parameters._server, parameters._again = {"gain": 1}, True
    reads: List[int] = []

    def read() -> Dict[str, Any]:
        reads.append(1)
        if len(reads) == 2:
            parameters._again = True  # another change on the server, too late for this read
        return {"gain": 2}

    parameters._publish_changes = read
    monkeypatch.setattr(parameter_services, "_MOST_READS", 3)
    monkeypatch.setattr(parameter_services, "time", SimpleNamespace(sleep=lambda _: None))
    parameters._publish_until_in_force()
    assert len(reads) == 2 + 3 and not parameters._is_reading


def test_described_range_has_its_step() -> None:
    entry = {"type": "float", "minimum": 0.5, "maximum": 2.0, "step": 0.25}
    (limits,) = descriptor("gain", entry).floating_point_range
    assert (limits.from_value, limits.to_value, limits.step) == (0.5, 2.0, 0.25)
    (limits,) = descriptor("count", {"type": "int", "minimum": 1, "step": 2}).integer_range
    assert (limits.from_value, limits.to_value, limits.step) == (1, 2**31 - 1, 2)


def test_failed_write_is_retried_once_at_a_time() -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._work, mirror._is_written = queue.SimpleQueue(), False
    for _ in range(2):
        mirror.retry_write_all()
    assert mirror._work.get_nowait() == mirror._write_all and mirror._work.empty()
    mirror._is_written = True
    mirror.retry_write_all()
    assert mirror._work.empty()


def test_value_that_ros1_cannot_represent_is_reported_at_each_poll() -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._name, mirror._values, mirror._kinds, mirror._unfit = "/far", {}, {}, {}
    mirror._master, mirror._skip_log = SimpleNamespace(request=list), SkipLog()
    mirror._write_server, mirror._work = (lambda values: None), queue.SimpleQueue()

    def reasons_after(plain: Any) -> List[str]:
        changed = [value("gain", plain)] if plain else []
        gone = [] if plain else [value("gain", 1)]
        mirror.write_event(
            SimpleNamespace(new_parameters=[], changed_parameters=changed, deleted_parameters=gone)
        )
        mirror._work.get()()
        for _ in range(3):
            mirror._skip_log.end_poll()
            mirror.report_unfit()
        return mirror._skip_log.current()

    too_large = ["/far: gain: refused 1099511627776: ROS 1 carries integers of 32 bits only"]
    assert [reasons_after(plain) for plain in (5, 2**40, 5, 2**40, None)] == [
        *([], too_large, []),
        *(too_large, []),
    ]


def test_latest_server_value_is_sent() -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._is_written = False
    mirror._work, mirror._latest = queue.SimpleQueue(), collections.deque(maxlen=1)
    taken: List[Any] = []
    mirror._send_changes = taken.append
    for tree in ({"pid": {"p": 1}}, {"pid": {"p": 2}}, 3, {"pid": {"p": 4}}):
        mirror._send_soon(tree)  # while it waits for the node
    while not mirror._work.empty():
        mirror._work.get()()
    assert taken == [{"pid.p": 4}]
    named: List[Any] = []
    mirror._is_written, mirror._warn_of_unknown = True, named.append
    mirror._send_soon({"pid": {"p": 4}, "gian": 1})  # another node may be below /motor/pid
    mirror._work.get()()
    assert named == [["gian"]]


def test_rejected_values_are_logged_in_one_line(monkeypatch: "pytest.MonkeyPatch") -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._name, mirror._values = "/motor", {"gain": 1, "tau": 2}
    mirror._kinds = dict.fromkeys(mirror._values, INTEGER)
    written: List[Any] = []
    lines: List[str] = []
    mirror._send, mirror._write_server = (lambda *_: "no"), written.append
    monkeypatch.setattr(rospy, "logwarn", lambda text, *given: lines.append(text % given))
    mirror._send_changes({"gain": 3, "tau": -1})
    told = "/motor/gain=3 (no; 1 stays), /motor/tau=-1 (no; 2 stays)"
    assert lines == [f"refused by ROS 2: {told}"]
    assert written == [{"/motor/gain": 1, "/motor/tau": 2}]
    mirror._send = lambda *_: ""
    mirror._send_changes({"gain": 3, "tau": 2})
    assert mirror._values == {"gain": 3, "tau": 2} and len(written) == 1


@pytest.mark.parametrize(
    ("plain", "results", "why"),
    [
        (2, [SetParametersResult(successful=True, reason="as you like")], ""),
        (2, [SetParametersResult(reason="must be above 2.")], "must be above 2"),
        (2, [SetParametersResult()], "no reason given"),
        (2, [SetParametersResult()] * 2, "the node sent 2 results for one parameter"),
        (2, None, "/motor/set_parameters in ROS 2: no answer"),
        ([1, "a"], [], "parameters of ROS 2 cannot have such a value"),
    ],
)
def test_value_that_a_node_of_ros2_does_not_take_has_a_reason(
    plain: Any, results: Any, why: str
) -> None:
    def call(request: Any, _: float) -> Any:
        ((name, sent),) = [(one.name, Value.from_parameter_msg(one)) for one in request.parameters]
        assert (name, sent.value) == ("gain", 2)
        if results is None:
            raise NoResponse("/motor/set_parameters in ROS 2: no answer")
        return SimpleNamespace(results=results)

    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._kinds, mirror._set = {"gain": INTEGER}, SimpleNamespace(call=call)
    assert mirror._send("gain", plain) == why


def test_value_that_a_node_takes_late_is_published(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(parameter_services, "_PAUSE_S", 0.0)
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    parameters._lock, parameters._again = threading.Lock(), False
    parameters._server, reads = {"gain": 3}, iter([{"gain": 2}] * 10 + [{"gain": 3}, {"gain": 4}])
    parameters._publish_changes = lambda: next(reads)
    parameters._publish_until_in_force()
    assert next(reads) == {"gain": 4} and not parameters._is_reading


def test_parameter_that_no_node_describes_may_change_its_type() -> None:
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    known = {"gain": Known(2, INTEGER, None), "rate": Known(2.5, DOUBLE, {"type": "float"})}
    parameters._parameters = SimpleNamespace(read=lambda: known)
    request = DescribeParameters.Request(names=["rate", "gain"])
    rate, gain = parameters._describe(request).descriptors
    assert (gain.name, gain.type, gain.dynamic_typing) == ("gain", INTEGER, True)
    assert (rate.name, rate.type, rate.dynamic_typing) == ("rate", DOUBLE, False)


def test_whole_numbers_of_the_server_are_sent_as_doubles() -> None:
    mirror: Any = ParametersToRos1.__new__(ParametersToRos1)
    mirror._values = {"gain": 1.0, "gains": [1.0, 2.0], "count": 1, "name": "left"}
    mirror._kinds = {"gain": DOUBLE, "gains": DOUBLES, "count": INTEGER, "name": STRING}
    sent: List[str] = []
    mirror._send = lambda name, plain: sent.append(f"{name} {plain!r}") or ""
    mirror._send_changes({"gain": 2, "gains": [3, 4], "count": 2})
    assert sent == ["gain 2.0", "gains [3.0, 4.0]", "count 2"]
    mirror._send_changes({"gain": 2, "gains": [3, 4], "count": 2})
    assert len(sent) == 3


@pytest.mark.parametrize(
    "nonsense, kind", [("x", INTEGER), ([5], STRINGS), ([], STRING), (5, BYTES)]
)
def test_value_of_wrong_type_is_unset(nonsense: Any, kind: int) -> None:
    message = to_message(nonsense, kind)
    assert message.type == ParameterType.PARAMETER_NOT_SET
    serialize_message(message)


@pytest.mark.parametrize(
    "one, other, kind",
    [(math.nan, 1.0, DOUBLE), ([math.nan] * 3000, [*[math.nan] * 2999, 1.0], DOUBLES)],
)
def test_nan_is_published_only_on_change(one: Any, other: Any, kind: int) -> None:
    before, same, after = ({"x": to_message(plain, kind)} for plain in (one, one, other))
    assert changes(before, same) == ({}, {}, {})
    assert changes(before, after) == ({}, after, {})


def test_a_read_that_fails_is_not_the_last(monkeypatch: "pytest.MonkeyPatch") -> None:
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    parameters._lock, parameters._is_reading = threading.Lock(), False
    reads: List[int] = []
    monkeypatch.setattr(threading, "excepthook", lambda _: None)

    def read() -> Any:
        reads.append(1)
        if len(reads) == 1:
            raise RuntimeError("of ROS 2")
        return {}

    parameters._publish_changes = read
    for count in (1, 2):
        parameters._publish_soon({})
        wait_until(lambda: len(reads) == count and not parameters._is_reading, lambda: str(reads))


def test_unreadable_parameters_are_logged_once(monkeypatch: "pytest.MonkeyPatch") -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    parameters: Any = ParametersToRos2.__new__(ParametersToRos2)
    parameters._parameters = SimpleNamespace(name="/arm")
    parameters._throttle = parameter_services.Throttle(10.0)
    ended = threading.Semaphore(0)

    def answer(request: Any) -> Any:
        ended.release()
        raise parameter_services.UnreadableParameters("no answer")

    before = {*threading.enumerate()}  # of which some may be about to end
    for _ in range(3):
        parameters._beside(answer)(None, lines.append)
        assert ended.acquire(timeout=10.0)
    wait_until(lambda: {*threading.enumerate()} <= before, lambda: "a thread is left")
    assert lines == ["cannot read the parameters of /arm: no answer"]


def test_services_end_if_changes_cannot_be_followed() -> None:
    ended: List[str] = []

    def refuse(*_: Any, **__: Any) -> None:
        raise RuntimeError("of ROS 1")

    scope: Any = SimpleNamespace(on_parameter=refuse, close=partial(ended.append, "scope"))
    participant: Any = SimpleNamespace(
        create_service=lambda _, __, name, *___: partial(ended.append, name)
    )
    node: Any = SimpleNamespace(get_clock=bool)
    known = ServerParameters(cast(Any, None), "/arm")
    with pytest.raises(RuntimeError, match="of ROS 1"):
        ParametersToRos2(scope, participant, node, "/arm", known, ended.append, bool)
    assert {"scope", "/arm/list_parameters", "/arm/set_parameters"} < set(ended)
