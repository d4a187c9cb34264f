"""What rclpy's Node gives, on rospy.

This module is the front door. What is named here is public and stable; the rest may change. Each
name is imported when it is first used: a program that only judges parameters does without rospy,
and :mod:`nodekit.entry_point` is there before it.
"""

import importlib
from typing import TYPE_CHECKING, Any, Dict

if TYPE_CHECKING:  # the same once more, for type checkers and editors
    from nodekit.execution.groups import Group as Group
    from nodekit.executors import MultiThreadedExecutor as MultiThreadedExecutor
    from nodekit.executors import SingleThreadedExecutor as SingleThreadedExecutor
    from nodekit.life.clients import CallCancelled as CallCancelled
    from nodekit.life.clients import CallFuture as CallFuture
    from nodekit.life.clients import Client as Client
    from nodekit.life.clients import NestedCall as NestedCall
    from nodekit.life.lifetime import Lifetime as Lifetime
    from nodekit.life.server import CallError as CallError
    from nodekit.life.server import CallTimeout as CallTimeout
    from nodekit.lifecycle.managed_node import ManagedNode as ManagedNode
    from nodekit.lifecycle.table import Outcome as Outcome
    from nodekit.live.live_parameters import LiveParameters as LiveParameters
    from nodekit.live.master import MasterUnreachable as MasterUnreachable
    from nodekit.messaging.publisher import Publisher as Publisher
    from nodekit.messaging.subscription import Latest as Latest
    from nodekit.node import Node as Node
    from nodekit.parameters.bytes_kind import BytesParameter as BytesParameter
    from nodekit.parameters.declaration import ParameterSet as ParameterSet
    from nodekit.parameters.declaration import read_once as read_once
    from nodekit.parameters.declaration import rule as rule
    from nodekit.parameters.kinds import BoolParameter as BoolParameter
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
    "Group": "execution.groups",
    "MultiThreadedExecutor": "executors",
    "SingleThreadedExecutor": "executors",
    "CallCancelled": "life.clients",
    "CallFuture": "life.clients",
    "Client": "life.clients",
    "NestedCall": "life.clients",
    "Lifetime": "life.lifetime",
    "CallError": "life.server",
    "CallTimeout": "life.server",
    "ManagedNode": "lifecycle.managed_node",
    "Outcome": "lifecycle.table",
    "LiveParameters": "live.live_parameters",
    "MasterUnreachable": "live.master",
    "Publisher": "messaging.publisher",
    "Latest": "messaging.subscription",
    "Node": "node",
    "ParameterSet": "parameters.declaration",
    "read_once": "parameters.declaration",
    "rule": "parameters.declaration",
    "BoolParameter": "parameters.kinds",
    "BytesParameter": "parameters.bytes_kind",
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
