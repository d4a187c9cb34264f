"""What rclpy's Node gives, on rospy.

This module is the front door. What is named here is public and stable; the rest may change. Each
name is imported when it is first used: a program that only judges parameters does without rospy,
and :mod:`nodekit.entry_point` is there before it.
"""

import importlib
from typing import TYPE_CHECKING, Any, Dict

if TYPE_CHECKING:  # the same once more, for type checkers and editors
    from nodekit.executors import MultiThreadedExecutor as MultiThreadedExecutor
    from nodekit.executors import SingleThreadedExecutor as SingleThreadedExecutor
    from nodekit.groups.groups import Group as Group
    from nodekit.managed.managed_node import ManagedNode as ManagedNode
    from nodekit.managed.table import Outcome as Outcome
    from nodekit.master import MasterUnreachable as MasterUnreachable
    from nodekit.messaging.publisher import Publisher as Publisher
    from nodekit.messaging.subscription import Latest as Latest
    from nodekit.node.clients import CallCancelled as CallCancelled
    from nodekit.node.clients import CallFuture as CallFuture
    from nodekit.node.clients import Client as Client
    from nodekit.node.clients import NestedCall as NestedCall
    from nodekit.node.maker import Maker as Maker
    from nodekit.node.node import Node as Node
    from nodekit.node.server import CallError as CallError
    from nodekit.node.server import CallTimeout as CallTimeout
    from nodekit.parameter_server.live_parameters import LiveParameters as LiveParameters
    from nodekit.parameters.declaration import ParameterSet as ParameterSet
    from nodekit.parameters.declaration import read_once as read_once
    from nodekit.parameters.declaration import rule as rule
    from nodekit.parameters.kinds import BoolParameter as BoolParameter
    from nodekit.parameters.kinds import BytesParameter as BytesParameter
    from nodekit.parameters.kinds import EnumParameter as EnumParameter
    from nodekit.parameters.kinds import ListParameter as ListParameter
    from nodekit.parameters.kinds import Parameter as Parameter
    from nodekit.parameters.kinds import ParameterError as ParameterError
    from nodekit.parameters.kinds import StringParameter as StringParameter
    from nodekit.parameters.number_kinds import FloatParameter as FloatParameter
    from nodekit.parameters.number_kinds import IntParameter as IntParameter
    from nodekit.parameters.number_kinds import RateParameter as RateParameter
    from nodekit.process.host import host as host
    from nodekit.process.host import host_all as host_all
    from nodekit.process.run import run as run

_HOMES: Dict[str, str] = {
    "Group": "groups.groups",
    "MultiThreadedExecutor": "executors",
    "SingleThreadedExecutor": "executors",
    "CallCancelled": "node.clients",
    "CallFuture": "node.clients",
    "Client": "node.clients",
    "NestedCall": "node.clients",
    "Maker": "node.maker",
    "CallError": "node.server",
    "CallTimeout": "node.server",
    "ManagedNode": "managed.managed_node",
    "Outcome": "managed.table",
    "LiveParameters": "parameter_server.live_parameters",
    "MasterUnreachable": "master",
    "Publisher": "messaging.publisher",
    "Latest": "messaging.subscription",
    "Node": "node.node",
    "ParameterSet": "parameters.declaration",
    "read_once": "parameters.declaration",
    "rule": "parameters.declaration",
    "BoolParameter": "parameters.kinds",
    "BytesParameter": "parameters.kinds",
    "EnumParameter": "parameters.kinds",
    "FloatParameter": "parameters.number_kinds",
    "IntParameter": "parameters.number_kinds",
    "ListParameter": "parameters.kinds",
    "Parameter": "parameters.kinds",
    "ParameterError": "parameters.kinds",
    "RateParameter": "parameters.number_kinds",
    "StringParameter": "parameters.kinds",
    "host": "process.host",
    "host_all": "process.host",
    "run": "process.run",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'nodekit' has no attribute {name!r}")
    value = getattr(importlib.import_module("nodekit." + _HOMES[name]), name)
    globals()[name] = value
    return value
