"""Thread that polls the master in time and on request, and survives exceptions."""

import itertools
import threading
from typing import List
from unittest import mock

import rosgraph

from nodekit.master import SystemState
from nodekit.testing.waiting import wait_until
from topic_scope.graph import master_watch
from topic_scope.graph.master_watch import GraphState, MasterWatch
from topic_scope.messages.layout_cache import Layouts


def test_an_exception_does_not_end_it() -> None:
    states: List[GraphState] = []
    over = threading.Event()
    first = [ValueError("an invalid name"), ConnectionRefusedError()]
    errors = itertools.chain(first, itertools.repeat(None))
    subscriptions = mock.Mock(**{"adjust.side_effect": errors})
    master = mock.Mock()
    master.system_state.return_value = SystemState([("/a", ["/node"]), ("/gone", [])], [], [])
    master.topic_types.return_value = {"/a": "std_msgs/Float32"}
    patches = (
        mock.patch.object(master_watch, "MasterClient", return_value=master),
        mock.patch("rospy.is_shutdown", over.is_set),
        mock.patch("rospy.logerr"),
        mock.patch.object(master_watch, "PERIOD_S", 60.0),
    )
    with patches[0], patches[1], patches[2] as log, patches[3]:
        watch = MasterWatch(subscriptions, Layouts())
        silences: List[str] = []
        watch.start(states.append, silences.append)
        watch.refresh()
        wait_until(lambda: silences, lambda: "the silence is not reported")
        for count in (1, 2):
            watch.refresh()
            wait_until(lambda: len(states) >= count, lambda: "no state")
        over.set()
        watch.refresh()
        threads = threading.enumerate
        wait_until(lambda: "master" not in [one.name for one in threads()], lambda: "it continues")
    assert "an invalid name" in log.call_args[0][1]
    assert len(states) == 2 and silences == [rosgraph.get_master_uri()]
    assert states[0].published_types == {"/a": "std_msgs/Float32"}
