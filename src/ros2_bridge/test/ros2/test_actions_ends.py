"""Goals that outlive their bridge, and actions of a bridge with its own settings."""

import collections
import contextlib
import itertools
import signal
import threading
from functools import partial
from types import SimpleNamespace
from typing import Any, Dict, List, cast

import both
import pytest
import rospy
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from action_parts import Client1, Client2, Server1, Server2, cancel
from action_server2 import Server
from rclpy.action.graph import get_action_names_and_types
from rclpy.exceptions import InvalidServiceNameException
from rclpy.node import Node
from rclpy.serialization import serialize_message

import nodekit
from nodekit.testing.waiting import wait_until
from ros2_bridge.action_bridge import (
    actionlib_messages,
    ros1_server_in_ros2,
    ros2_server_in_ros1,
)
from ros2_bridge.action_bridge.all_actions import ActionBridge
from ros2_bridge.action_bridge.ros1_server_in_ros2 import Ros1ServerInRos2
from ros2_bridge.action_bridge.ros2_server_in_ros1 import Ros2ServerInRos1
from ros2_bridge.actions.goal_ids import NO_GOAL, bytes_of, text_of
from ros2_bridge.actions.ros1_goal_tracker import Ros1GoalTracker, TimedOutGoals
from ros2_bridge.actions.ros2_goal_tracker import GONE, NO_ANSWER, Ros2GoalTracker
from ros2_bridge.actions.states import Ros1Status
from ros2_bridge.actions.status_list import read_list
from ros2_bridge.environment.ros1_messages import GoalID
from ros2_bridge.environment.ros1_messages import GoalStatusArray as StatusArray1
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.client import NoResponse
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.selection import Route, Rules
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.rules.skip_log import SkipLog


def test_goals_are_aborted_at_shutdown_of_bridge(ros: both.Both) -> None:
    with Server1("/leg/hop") as server1, Server2("/leg/run") as server2, both.Bridge() as bridge:
        client2 = Client2(ros, "/leg/hop")
        client2.send("on", 60.0)
        assert client2.accepted("on")
        with Client1("/leg/run") as client1:
            client1.tell("send on 60.0")
            wait_until(lambda: client1.feedback("on"), lambda: "no feedback")
            assert bridge.interrupt() == 0
            assert client1.end_of("on") == f"ABORTED - {GONE}"
        assert client2.end("on") == GoalStatus.STATUS_ABORTED
        client2.close()
        assert server1.popen.poll() is server2.popen.poll() is None
        assert not bridge.logged("Traceback")


def test_goal_that_the_server_does_not_answer_is_rejected(ros: both.Both) -> None:
    node = Node("late")
    Server(node, "/foot/rest")  # a node that is not spun
    with both.Bridge("_service_timeout:=0.5"), Client1("/foot/rest") as client:
        client.tell("send on 60.0")
        assert client.end_of("on") == f"REJECTED - {NO_ANSWER}"
        recorder = ros.hear2("/foot/rest/_action/status", GoalStatusArray, latched=True, depth=1)
        ros.executor.add_node(node)  # it accepts the goal after all
        wait_until(
            lambda: (
                recorder.heard
                and recorder.heard[-1].status_list[0].status == GoalStatus.STATUS_CANCELED
            ),
            lambda: f"it goes on: {recorder.heard[-1:]}",
        )
        recorder.end()
    ros.executor.remove_node(node)
    node.destroy_node()


def test_action_that_fails_keeps_no_other_from_following() -> None:
    class Pair:
        def __init__(self, error: str) -> None:
            self.error, self.followed = error, 0

        def follow(self) -> None:
            self.followed += 1
            if self.error:
                raise RuntimeError(self.error)

    nothing: Any = None
    skip_log, pairs = SkipLog(), [Pair("it is broken"), Pair("")]
    actions = ActionBridge(nothing, nothing, nothing, skip_log, lambda: 1.0)
    actions.pairs.update({Route(f"/{n}", True): cast(Any, pair) for n, pair in enumerate(pairs)})
    for _ in range(2):
        actions.follow()
    assert [pair.followed for pair in pairs] == [2, 2]
    assert skip_log.next_line(0.0) == "not bridged: /0: it is broken"


def test_only_allowed_actions_with_servers_in_both_are_reported() -> None:
    nothing: Any = None
    skip_log = SkipLog()
    actions = ActionBridge(nothing, nothing, nothing, skip_log, lambda: 1.0)
    kind, node = "acme_msgs/Grab", {"/hand"}
    names = ("/robot/left", "/robot/right")
    published = {f"{n}/{part}": node for n in names for part in ("status", "feedback", "result")}
    subscribed = {f"{n}/{part}": node for n in names for part in ("goal", "cancel")}
    types = {f"{name}/result": f"{kind}ActionResult" for name in names}
    send_goal = ("acme_msgs/action/Grab_SendGoal", "/foot")
    services2 = {f"{name}/_action/send_goal": send_goal for name in ("/left", "/right")}
    rules = Rules(True, True, ["*"], ["*/right"], Renaming(["/robot=/"]))
    graph = Ros1Graph(published, subscribed, types, {}, 1)
    actions.update_actions(rules, graph, services2, {})
    assert [reason.partition(": ")[0] for reason in skip_log.current()] == ["/robot/left"]


def test_action_ends_with_its_type_and_needs_a_name_in_ros1() -> None:
    nothing: Any = None
    actions: Any = ActionBridge(nothing, nothing, nothing, SkipLog(), lambda: 1.0)
    begun: List[Route] = []
    closed: List[str] = []
    actions._types = SimpleNamespace(ros1_name=lambda name: name.replace("/action", ""))
    actions._begin = begun.append
    pair: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    pair.kind, pair.follow = SimpleNamespace(ros1="acme_msgs/Grab"), lambda: None
    pair.close = partial(closed.append, "/hand")
    actions.pairs[Route("/hand", False)] = pair
    rules = Rules(True, True, ["*"], [], Renaming(["/=/lab"]))
    for kind, ended in (("Grab", []), ("Wave", ["/hand"])):
        server = (f"acme_msgs/action/{kind}_SendGoal", "/robot")
        services2 = {f"{name}/_action/send_goal": server for name in ("/lab/hand", "/foot")}
        actions.update_actions(rules, Ros1Graph({}, {}, {}, {}, 1), services2, {})
        assert (closed, begun) == (ended, [])


def test_goals_are_aborted_once_their_server_was_away_for_a_second(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    server: Any = Ros1ServerInRos2.__new__(Ros1ServerInRos2)
    calls: List[Any] = []
    clock = SimpleNamespace(now=0.0)
    fake = SimpleNamespace(monotonic=lambda: clock.now)
    monkeypatch.setattr(ros1_server_in_ros2, "time", fake)
    server._name, server._lock, server._connected = "/leg", threading.Lock(), 0.0
    server._offered = contextlib.ExitStack()
    server._offered.callback(calls.append, "no longer offered")
    server._goals = SimpleNamespace(
        abort_all=lambda now: calls.append(("aborted", now)),
        end_timeouts=lambda now: TimedOutGoals(["unheard"] if now == 1.0 else [], []),
    )
    server._cancel = SimpleNamespace(
        publish=lambda message: calls.append((message.id, message.stamp))
    )
    for now, is_connected in ((1.0, True), (5.0, True), (5.5, False), (5.9, True), (6.8, False)):
        server._is_connected, clock.now = lambda is_connected=is_connected: is_connected, now
        server.follow()
    assert calls == [("unheard", rospy.Time())]  # a server that starts it late ends it
    clock.now = 7.0
    server.follow()
    assert calls[1:] == [("aborted", 7.0)]
    server._scope = SimpleNamespace(close=lambda: calls.append("unsubscribed"))
    server.close()
    assert calls[2:] == [("aborted", 7.0), "unsubscribed", "no longer offered"]


def test_server_of_ros2_leaves_nothing_and_may_have_no_goal_to_cancel(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    calls: List[str] = []
    server._name, server._lock = "/hand", threading.Lock()
    nothing = CancelGoal.Response()
    server._cancel = SimpleNamespace(send=lambda request, receive: receive(nothing))
    for goal in (NO_GOAL, bytes(15) + b"\1"):
        server._cancel_goal(goal)
    (line,) = lines
    assert line.startswith("/hand: the server in ROS 2 does not cancel 00000000-")
    server._goals = SimpleNamespace(abort_goals=lambda senders, _: calls.append(f"of {senders}"))
    server._scope = SimpleNamespace(close=partial(calls.append, "scope"))
    server._ends = [partial(calls.append, "status")]
    server._clients = [SimpleNamespace(close=partial(calls.append, "client"))]
    server.close()
    assert calls == ["of set()", "scope", "status", "client"]


def test_goals_that_a_server_has_already_are_listed_once_it_is_offered() -> None:
    sent: List[bytes] = []
    qualities: List[QosProfile] = []

    def create_publisher(*given: Any) -> Any:
        qualities.append(given[3])
        return SimpleNamespace(publish=sent.append)

    server: Any = Ros1ServerInRos2.__new__(Ros1ServerInRos2)
    server._participant = SimpleNamespace(
        create_publisher=create_publisher,
        create_service=lambda *_: None,
        destroy_publisher=None,
    )
    services = ("CancelGoalService", "GetResultService", "SendGoalService")
    impl = SimpleNamespace(**dict.fromkeys(("FeedbackMessage", *services)))
    server.kind = SimpleNamespace(cls=SimpleNamespace(Impl=impl))
    server.owner, server._other = None, "/leg"
    server._offered, server._lock = None, threading.RLock()
    server._goals = Ros1GoalTracker(lambda: 1.0, server._publish_status)
    server._goals.on_status([("of ROS 1", 5, Ros1Status.ACTIVE)], 0.0)
    assert not sent
    server._offer()
    ((goal,),) = map(read_list, sent)
    assert (goal.stamp, goal.status) == (5, GoalStatus.STATUS_EXECUTING)
    assert qualities == [QosProfile(1, latched=True), QosProfile(1000)]  # of list and feedback


def test_bursts_of_answers_and_of_feedback_are_kept(ros: both.Both) -> None:
    depths: List[int] = []
    qualities: Dict[str, QosProfile] = {}

    def create_client(*given: Any) -> Any:
        depths.append(given[3])
        return None, id

    def subscribe(_: Any, topic: str, quality: QosProfile, __: Any) -> Any:
        qualities[topic] = quality
        return id

    node: Any = SimpleNamespace(create_scope=dict)
    participant: Any = SimpleNamespace(create_client=create_client, create_subscription=subscribe)
    kind = ros.types.action("bot_controller_demo_msgs/GoTo")
    Ros2ServerInRos1(node, participant, "/hand", "/left/hand", kind, lambda: 1.0)
    assert depths == [1000] * 3
    assert qualities == {
        "/left/hand/_action/status": QosProfile(1, latched=True),
        "/left/hand/_action/feedback": QosProfile(1000),
    }


def test_answers_to_a_bounded_number_of_goals_are_awaited(
    ros: both.Both, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(ros2_server_in_ros1, "DEPTH", 2)
    kind = ros.types.action("bot_controller_demo_msgs/GoTo")
    forgotten: List[int] = []
    numbers = itertools.count()
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    server.kind, server._send_type = kind, kind.cls.Impl.SendGoalService
    server._calls, server._lock = collections.deque(), threading.RLock()
    server._goals = Ros2GoalTracker(lambda: 1.0, cast(Any, None), list)
    server._send = SimpleNamespace(send=lambda *_: next(numbers), forget=forgotten.append)
    content = kind.goal.to_ros1(serialize_message(kind.cls.Goal()))
    for text in "abcd":
        server._on_goal(actionlib_messages.write_goal(kind.raw_goal, text, 0, content))
    assert forgotten == [0, 1]


def test_goal_that_cannot_be_sent_is_rejected_at_once(ros: both.Both) -> None:
    def refuse(*_: Any) -> None:
        raise NoResponse("/hand is not offered in ROS 2")

    kind = ros.types.action("bot_controller_demo_msgs/GoTo")
    ends: List[Any] = []
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    server.kind, server._send_type = kind, kind.cls.Impl.SendGoalService
    server._calls, server._lock = collections.deque(), threading.RLock()
    server._goals = Ros2GoalTracker(
        lambda: 60.0, lambda goal, _: ends.append((goal.text, goal.status, goal.why)), list
    )
    server._send = SimpleNamespace(send=refuse)
    content = kind.goal.to_ros1(serialize_message(kind.cls.Goal()))
    for text, data in (("whole", content), ("cut", content[:-1])):
        server._on_goal(actionlib_messages.write_goal(kind.raw_goal, text, 0, data))
    whole, (text, status, why) = ends
    assert whole == ("whole", Ros1Status.REJECTED, "/hand is not offered in ROS 2")
    assert (text, status) == ("cut", Ros1Status.REJECTED) and "GoToGoal: " in why
    assert not server._calls


def test_goals_of_a_server_without_its_services_are_aborted() -> None:
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    served_by: List[Any] = []
    server._is_offered, server._senders, server._lock = True, lambda: {b"leg"}, threading.Lock()
    server._goals = SimpleNamespace(
        is_any_under_way=lambda: True,
        abort_goals=lambda senders, _: served_by.append(senders),
        remove_old=lambda _: None,
        end_timeouts=lambda _: SimpleNamespace(accepted=[], without_result=[]),
    )
    for is_ready in (True, False):
        server._clients = [SimpleNamespace(is_ready=lambda is_ready=is_ready: is_ready)]
        server.follow()
    assert served_by == [{b"leg"}, set()]


def test_action_with_failing_services_is_not_offered(ros: both.Both) -> None:
    long = f"/{'a' * 229}"  # ROS 2 takes its topics, but not its services
    node, participant = nodekit.Node(), Participant("/offering")
    node.start()
    kind = ros.types.action("bot_controller_demo_msgs/GoTo")
    action = Ros1ServerInRos2(node, participant, participant.node, long, long, kind, lambda: 1.0)

    def fails() -> bool:
        try:
            action.follow()
        except InvalidServiceNameException:
            return True
        return False

    with Server1(long):
        wait_until(fails, lambda: "it is offered, or not connected")
        assert fails() and not [topic for topic in participant.topics() if long in topic]
    for part in (action, participant, node):
        part.close()


def test_names_and_rules_are_those_of_the_whole_action(ros: both.Both) -> None:
    rules = ("_remap:=['/arm=/']", "_deny:=['*/secret']")
    with Server1("/arm/reach"), Server1("/arm/secret", "another"), Server2("/grab"), both.Bridge(
        *rules
    ):
        client2 = Client2(ros, "/reach")
        client2.send("up", 0.1)
        assert client2.accepted("up") and client2.end("up") == GoalStatus.STATUS_SUCCEEDED
        client2.close()
        with Client1("/arm/grab") as client1:
            client1.tell("send it 0.1")
            assert client1.end_of("it") == "SUCCEEDED it"
        offered = [name for name, _ in get_action_names_and_types(ros.node)]
        assert "/reach" in offered and "/secret" not in offered and "/arm/reach" not in offered


def test_goal_is_lost_after_bridge_was_killed_and_can_be_cancelled(ros: both.Both) -> None:
    recorder1 = ros.hear1("/leg/walk/status", "actionlib_msgs/GoalStatusArray")
    recorder2 = ros.hear2("/leg/walk/_action/status", GoalStatusArray, latched=True, depth=1)

    def ids() -> List[str]:
        """Return the ids of the goals in the latest list in ROS 1."""
        lists = [StatusArray1().deserialize(message._buff) for message in recorder1.heard[-1:]]
        return [one[0] for latest in lists for one in actionlib_messages.read_statuses(latest)]

    with Server2("/leg/walk"):
        with both.Bridge() as bridge, Client1("/leg/walk") as client:
            client.tell("send on 60.0")
            wait_until(lambda: client.feedback("on"), lambda: "no feedback")
            (text,) = wait_until(ids, lambda: "the goal is not listed")
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
            with both.Bridge():
                assert client.end_of("on") == "LOST -"  # by the rules of ROS 1
                listed = text_of(bytes_of(text)).encode()
                wait_until(
                    lambda: any(listed in one._buff for one in recorder1.heard[-1:]),
                    lambda: "it is not listed",
                )
                canceller = rospy.Publisher("/leg/walk/cancel", GoalID, queue_size=1)
                wait_until(canceller.get_num_connections, lambda: "no connection")
                canceller.publish(actionlib_messages.goal_id(text, 0))
                wait_until(
                    lambda: (
                        [one.status for lists in recorder2.heard[-1:] for one in lists.status_list]
                        == [GoalStatus.STATUS_CANCELED]
                    ),
                    lambda: str(recorder2.heard[-1:]),
                )
    for end in (canceller.unregister, recorder1.end, recorder2.end):
        end()


def test_server_continues_goal_after_bridge_was_killed(ros: both.Both) -> None:
    with Server1("/leg/step") as server:
        with both.Bridge() as bridge:
            client = Client2(ros, "/leg/step")
            client.send("on", 60.0)
            assert client.accepted("on")
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
        with both.Bridge():
            # By the rules of ROS 2 the client still waits; the goal is known by the same id. For a
            # while ROS 2 takes the killed bridge for a server too, which may be asked in vain.
            wait_until(
                lambda: cancel(ros, "/leg/step", client.handles["on"], patience=2.0),
                lambda: "the goal is not known",
            )
            assert "on" not in client.results
        client.close()
        assert server.popen.poll() is None
