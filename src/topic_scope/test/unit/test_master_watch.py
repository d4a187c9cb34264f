"""Thread that polls the master, and survives exceptions."""

import threading
from typing import List
from unittest import mock

from nodekit.master import SystemState
from nodekit.testing.waiting import wait_until
from topic_scope.graph import master_watch
from topic_scope.graph.master_watch import GraphState, MasterWatch
from topic_scope.messages.layout_cache import Layouts


def test_an_exception_does_not_end_it() -> None:
    states: List[GraphState] = []
    over = threading.Event()
    subscriptions = mock.Mock(**{"adjust.side_effect": [ValueError("an invalid name"), None, None]})
    master = mock.Mock()
    master.system_state.return_value = SystemState([("/a", ["/node"])], [], [])
    master.topic_types.return_value = {"/a": "std_msgs/Float32"}
    patches = (
        mock.patch.object(master_watch, "MasterClient", return_value=master),
        mock.patch("rospy.is_shutdown", over.is_set),
        mock.patch("rospy.logerr"),
    )
    with patches[0], patches[1], patches[2] as log:
        watch = MasterWatch(subscriptions, Layouts())
        watch.start(states.append, mock.Mock())
        watch.refresh()
        wait_until(lambda: states, lambda: "no state")
        over.set()
        watch.refresh()
        threads = threading.enumerate
        wait_until(lambda: "master" not in [one.name for one in threads()], lambda: "it continues")
    assert "an invalid name" in log.call_args[0][1]
    assert states[0].published_types == {"/a": "std_msgs/Float32"}
