"""rclpy's Node on rospy.

The names here are public and stable; modules below may change. Each name is imported at its first
use, so that a program that only validates parameters does not import rospy, and
:mod:`nodekit.entry_point` runs before it.
"""

import importlib
import os
import sys
from typing import TYPE_CHECKING, Any, Dict

from nodekit.deprecated import OLD_NAMES, warn_once
from nodekit.shadowed_modules import check_script_folder, warn_of_hidden_modules

check_script_folder(sys.argv)
warn_of_hidden_modules(os.environ)

if TYPE_CHECKING:  # the same names for type checkers and editors
    from nodekit.actions.goal_states import GoalState as GoalState
    from nodekit.node.action_client import ActionClient as ActionClient
    from nodekit.node.action_responses import CancelResponse as CancelResponse
    from nodekit.node.action_responses import GoalResponse as GoalResponse
    from nodekit.node.action_server import ActionServer as ActionServer
    from nodekit.node.action_types import GoalError as GoalError
    from nodekit.node.action_types import GoalLost as GoalLost
    from nodekit.node.action_types import GoalRejected as GoalRejected
    from nodekit.node.action_types import GoalTimeout as GoalTimeout
    from nodekit.node.client_goal_handle import ClientGoalHandle as ClientGoalHandle
    from nodekit.node.client_goal_handle import GoalFuture as GoalFuture
    from nodekit.node.client_goal_handle import GoalResult as GoalResult
    from nodekit.node.server_goal_handle import ServerGoalHandle as ServerGoalHandle
    from nodekit.executors import MultiThreadedExecutor as MultiThreadedExecutor
    from nodekit.executors import SingleThreadedExecutor as SingleThreadedExecutor
    from nodekit.groups.callback_groups import CallbackGroup as CallbackGroup
    from nodekit.groups.callback_groups import Group as Group
    from nodekit.groups.callback_groups import (
        MutuallyExclusiveCallbackGroup as MutuallyExclusiveCallbackGroup,
    )
    from nodekit.groups.callback_groups import ReentrantCallbackGroup as ReentrantCallbackGroup
    from nodekit.lifecycle_states import Outcome as Outcome
    from nodekit.managed.managed_node import ManagedNode as ManagedNode
    from nodekit.master import MasterUnreachable as MasterUnreachable
    from nodekit.messaging.finite import LARGEST_FLOAT32 as LARGEST_FLOAT32
    from nodekit.messaging.finite import to_float32 as to_float32
    from nodekit.messaging.publisher import Publisher as Publisher
    from nodekit.messaging.subscription import LatestMessage as LatestMessage
    from nodekit.messaging.subscription import Subscription as Subscription
    from nodekit.node.clients import CallCancelled as CallCancelled
    from nodekit.node.clients import CallError as CallError
    from nodekit.node.clients import CallFuture as CallFuture
    from nodekit.node.clients import CallTimeout as CallTimeout
    from nodekit.node.clients import Client as Client
    from nodekit.node.clients import NestedCall as NestedCall
    from nodekit.node.clients import call_service as call_service
    from nodekit.node.clients import probe_service as probe_service
    from nodekit.node.name_rules import LEGAL_NAME as LEGAL_NAME
    from nodekit.node.name_rules import IllegalName as IllegalName
    from nodekit.node.name_rules import is_legal_name as is_legal_name
    from nodekit.node.names import Names as Names
    from nodekit.node.ros_node import Node as Node
    from nodekit.node.node_scope import Maker as Maker
    from nodekit.node.node_scope import NodeScope as NodeScope
    from nodekit.node.parameter_client import ChangeRefused as ChangeRefused
    from nodekit.node.parameter_client import ParameterClient as ParameterClient
    from nodekit.parameter_server.followed_parameter import FollowedParameter as FollowedParameter
    from nodekit.parameter_server.followed_parameter import follow_parameter as follow_parameter
    from nodekit.parameter_server.live_parameters import LiveParameters as LiveParameters
    from nodekit.parameters.declaration import ParameterSet as ParameterSet
    from nodekit.parameters.declaration import read_once as read_once
    from nodekit.parameters.declaration import rule as rule
    from nodekit.parameters.numeric_types import FloatParameter as FloatParameter
    from nodekit.parameters.numeric_types import IntParameter as IntParameter
    from nodekit.parameters.numeric_types import RateParameter as RateParameter
    from nodekit.parameters.parameter_types import BoolParameter as BoolParameter
    from nodekit.parameters.parameter_types import BytesParameter as BytesParameter
    from nodekit.parameters.parameter_types import EnumParameter as EnumParameter
    from nodekit.parameters.parameter_types import ListParameter as ListParameter
    from nodekit.parameters.parameter_types import Parameter as Parameter
    from nodekit.parameters.parameter_types import ParameterError as ParameterError
    from nodekit.parameters.parameter_types import StringParameter as StringParameter
    from nodekit.parameters.parameter_types import format_value as format_value
    from nodekit.parameters.parameter_types import to_wire as to_wire
    from nodekit.parameters.schema import DescriptionError as DescriptionError
    from nodekit.parameters.schema import describe as describe
    from nodekit.parameters.schema import parameter_of as parameter_of
    from nodekit.process.host import host as host
    from nodekit.process.host import host_all as host_all
    from nodekit.process.run import abort as abort
    from nodekit.process.run import init_node as init_node
    from nodekit.process.run import run as run
    from nodekit.round_robin import RoundRobin as RoundRobin
    from nodekit.throttle import Throttle as Throttle

    Latest = LatestMessage
    give_up = abort

_HOMES: Dict[str, str] = {
    "GoalState": "actions.goal_states",
    "ActionClient": "node.action_client",
    "CancelResponse": "node.action_responses",
    "GoalResponse": "node.action_responses",
    "ActionServer": "node.action_server",
    "GoalError": "node.action_types",
    "GoalLost": "node.action_types",
    "GoalRejected": "node.action_types",
    "GoalTimeout": "node.action_types",
    "ClientGoalHandle": "node.client_goal_handle",
    "GoalFuture": "node.client_goal_handle",
    "GoalResult": "node.client_goal_handle",
    "ServerGoalHandle": "node.server_goal_handle",
    "MultiThreadedExecutor": "executors",
    "SingleThreadedExecutor": "executors",
    "CallbackGroup": "groups.callback_groups",
    "Group": "groups.callback_groups",
    "MutuallyExclusiveCallbackGroup": "groups.callback_groups",
    "ReentrantCallbackGroup": "groups.callback_groups",
    "Outcome": "lifecycle_states",
    "ManagedNode": "managed.managed_node",
    "MasterUnreachable": "master",
    "LARGEST_FLOAT32": "messaging.finite",
    "to_float32": "messaging.finite",
    "Publisher": "messaging.publisher",
    "LatestMessage": "messaging.subscription",
    "Subscription": "messaging.subscription",
    "call_service": "node.clients",
    "CallCancelled": "node.clients",
    "CallError": "node.clients",
    "CallFuture": "node.clients",
    "CallTimeout": "node.clients",
    "Client": "node.clients",
    "NestedCall": "node.clients",
    "probe_service": "node.clients",
    "IllegalName": "node.name_rules",
    "is_legal_name": "node.name_rules",
    "LEGAL_NAME": "node.name_rules",
    "Names": "node.names",
    "Node": "node.ros_node",
    "Maker": "node.node_scope",
    "NodeScope": "node.node_scope",
    "ChangeRefused": "node.parameter_client",
    "ParameterClient": "node.parameter_client",
    "follow_parameter": "parameter_server.followed_parameter",
    "FollowedParameter": "parameter_server.followed_parameter",
    "LiveParameters": "parameter_server.live_parameters",
    "ParameterSet": "parameters.declaration",
    "read_once": "parameters.declaration",
    "rule": "parameters.declaration",
    "BoolParameter": "parameters.parameter_types",
    "BytesParameter": "parameters.parameter_types",
    "EnumParameter": "parameters.parameter_types",
    "format_value": "parameters.parameter_types",
    "ListParameter": "parameters.parameter_types",
    "Parameter": "parameters.parameter_types",
    "ParameterError": "parameters.parameter_types",
    "StringParameter": "parameters.parameter_types",
    "to_wire": "parameters.parameter_types",
    "FloatParameter": "parameters.numeric_types",
    "IntParameter": "parameters.numeric_types",
    "RateParameter": "parameters.numeric_types",
    "describe": "parameters.schema",
    "DescriptionError": "parameters.schema",
    "parameter_of": "parameters.schema",
    "host": "process.host",
    "host_all": "process.host",
    "abort": "process.run",
    "init_node": "process.run",
    "run": "process.run",
    "RoundRobin": "round_robin",
    "Throttle": "throttle",
}

__all__ = sorted([*_HOMES, *OLD_NAMES])


def __getattr__(name: str) -> Any:
    if name in OLD_NAMES:
        warn_once(f"nodekit.{name}", f"nodekit.{OLD_NAMES[name]}")
        name = OLD_NAMES[name]
    if name not in _HOMES:
        raise AttributeError(f"module 'nodekit' has no attribute {name!r}")
    value = getattr(importlib.import_module("nodekit." + _HOMES[name]), name)
    globals()[name] = value
    return value
