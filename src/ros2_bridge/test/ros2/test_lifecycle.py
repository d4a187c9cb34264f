"""Managed nodes of ROS 1, as ``ros2 lifecycle`` sees them."""

from typing import Any

import both

from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from nodekit.testing.graph import Graph
from nodekit.testing.waiting import wait_until

NODE = "/lifecycle_aware_node"


def change(ros: both.Both, label: str) -> bool:
    request = Transition(label=label)
    return bool(ros.call2(ChangeState, f"{NODE}/change_state", transition=request).success)


def state(ros: both.Both) -> Any:
    return ros.call2(GetState, f"{NODE}/get_state").current_state.label


def test_managed_node_is_managed_in_ros2(ros: both.Both, bridge: both.Bridge) -> None:
    with both.Running("lifecycle_demo", "lifecycle_aware_node", "_wait_for_manager:=true"):
        assert state(ros) == "unconfigured"
        # "ros2 lifecycle nodes" searches for services of a node of this name.
        offered = dict(ros.node.get_service_names_and_types_by_node("lifecycle_aware_node", "/"))
        assert offered[f"{NODE}/get_state"] == ["lifecycle_msgs/srv/GetState"]
        recorder = ros.hear2(f"{NODE}/transition_event", TransitionEvent)
        available = ros.call2(GetAvailableTransitions, f"{NODE}/get_available_transitions")
        labels = [one.transition.label for one in available.available_transitions]
        assert labels == ["configure", "shutdown"]
        states = ros.call2(GetAvailableStates, f"{NODE}/get_available_states").available_states
        assert len(states) == 11
        topic = f"{NODE}/transition_event"
        wait_until(
            lambda: Graph().connected_subscribers(NODE, topic), lambda: "the bridge does not listen"
        )
        assert not change(ros, "activate")
        assert change(ros, "configure")
        assert change(ros, "activate")
        assert state(ros) == "active"
        wait_until(
            lambda: "active" in [event.goal_state.label for event in recorder.heard],
            lambda: str(recorder.heard),
        )
        assert recorder.heard[-1].timestamp > 0  # rclpy leaves it at 0
        recorder.end()
