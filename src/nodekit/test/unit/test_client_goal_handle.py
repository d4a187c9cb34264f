"""Tests of the handle of a client's goal."""

from types import SimpleNamespace

from nodekit import GoalState
from nodekit.node.action_types import GoalLost
from nodekit.node.client_goal_handle import ClientGoalHandle, GoalResult


def test_result_that_arrives_just_before_the_goal_is_given_up_counts() -> None:
    client = SimpleNamespace(reject_nested=lambda: None)
    handle = ClientGoalHandle(client, "goal", None, None, 5.0)
    waiting = handle.get_result_async(5.0)
    result = GoalResult(GoalState.SUCCEEDED, "there", None)
    handle.end(result)
    handle.fail(GoalLost("the server has gone"))
    assert handle.status is GoalState.SUCCEEDED
    assert waiting.result() == handle.get_result(5.0) == result
