"""Manager of the parameter panels of all nodes that use nodekit or dynamic_reconfigure."""

import time
from functools import partial
from typing import Any, Callable, Collection, Dict, Iterable, List, Mapping, Tuple

import rospy
import tornado.ioloop

from nodekit import (
    ChangeRefused,
    DescriptionError,
    FollowedParameter,
    ParameterClient,
    Throttle,
    follow_parameter,
)
from topic_scope.controls import dynamic_reconfigure_panels, service_buttons
from topic_scope.controls.managed_nodes import ManagedNodes
from topic_scope.controls.panel import ParameterPanel
from topic_scope.controls.node_status import PERIOD_S, NodeStatuses, topics_of
from topic_scope.controls.parameter_sender import (
    Answer,
    ChangeReply,
    ParameterSender,
    value_message,
)
from topic_scope.graph.worker import Worker
from topic_scope.graph.master_watch import GraphState
from topic_scope.sampling.raw_subscriptions import RawSubscriptions, SteadyClock

#: Most panels, e.g. in a fleet of hundreds of nodes: the first by name.
PANELS = 64
#: Time until a node that did not answer is asked again [s].
RETRY_S = 5.0
#: Services of nodes that describe their parameters; they have no button.
_INTERNAL = ("describe", "change")
_END = "/" + _INTERNAL[0]
#: The same for dynamic_reconfigure servers.
_FOREIGN = "/" + dynamic_reconfigure_panels.SERVICE


class _NoPanel(Exception):
    """Error of a node that does not describe its parameters."""


class PanelManager:
    """Panels of the graph's nodes; all methods are for the web thread.

    :param deliver: runs a function in the web thread
    :param send: sends a message to all pages, with its subject
    """

    def __init__(
        self,
        deliver: Callable[[Callable[[], None]], None],
        send: Callable[..., None],
    ) -> None:
        self._deliver, self._send = deliver, send
        self._worker = Worker(deliver)
        self._panels: Dict[str, ParameterPanel] = {}
        self._followed: Dict[str, FollowedParameter] = {}
        self._failed: Dict[str, float] = {}
        self._throttle = Throttle(60.0)
        self._foreign: Collection[str] = ()
        self._sender = ParameterSender(
            self._worker, self._change, self._send_values, self._read_again
        )
        self._managed = ManagedNodes(self._worker, send)
        subscriptions = RawSubscriptions(SteadyClock())
        self._statuses = NodeStatuses(subscriptions, self._worker, send)
        tornado.ioloop.PeriodicCallback(self._statuses.update, PERIOD_S * 1e3).start()

    def messages(self) -> List[Dict[str, Any]]:
        """Return the messages for a new page."""
        return [self.message(), self._managed.message(), self._statuses.message()]

    def message(self) -> Dict[str, Any]:
        """Return all panels."""
        panels = [self._panels[node].message() for node in sorted(self._panels)]
        return {"type": "panels", "panels": panels}

    def on_state(self, state: GraphState) -> None:
        """Update the state of the graph."""
        self.on_services([name for name, nodes in state.services if nodes])
        self._statuses.follow(topics_of(self._panels, state.publishers, state.types))

    def on_services(self, names: Collection[str]) -> None:
        """Update the services on the graph."""
        self._managed.on_services(names)
        nodes = sorted(name[: -len(_END)] for name in names if name.endswith(_END))
        if dynamic_reconfigure_panels.AVAILABLE:
            others = {name[: -len(_FOREIGN)] for name in names if name.endswith(_FOREIGN)}
            self._foreign = others.difference(nodes)
        nodes = (nodes + sorted(self._foreign))[:PANELS]
        gone = set(self._panels) - set(nodes)
        for node in gone:
            del self._panels[node]
            self._sender.forget(node)
            leave = self._followed.pop(node).close
            self._worker.run(("leave", node), leave, lambda _: None)
        if gone:
            self._send(self.message())
        self._failed = {node: until for node, until in self._failed.items() if node in nodes}
        for node in nodes:
            if node not in self._panels and time.monotonic() > self._failed.get(node, 0.0):
                inspect = partial(self._inspect, node, list(names))
                self._worker.run(node, inspect, partial(self._on_inspected, node))

    def _inspect(
        self, node: str, names: Collection[str]
    ) -> Tuple[ParameterPanel, FollowedParameter]:
        own = [name for name in names if name.startswith(node + "/")]
        own = [name for name in own if name[len(node) + 1 :] not in _INTERNAL]
        datatype = service_buttons.type_of(node + _FOREIGN) if node in self._foreign else None
        if datatype not in (None, dynamic_reconfigure_panels.TYPE):
            raise _NoPanel
        types = {name: service_buttons.kind_of(name) for name in own}
        # Before the description is read, so that no later change is missed.
        followed = follow_parameter(
            node, lambda raw: self._deliver(partial(self._on_values, node, raw))
        )
        try:
            offered = {name: kind for name, kind in types.items() if kind}
            return ParameterPanel(node, self._describe(node), offered), followed
        except Exception:
            followed.close()
            raise

    def _on_inspected(self, node: str, result: Any) -> None:
        if isinstance(result, Exception):
            self._failed[node] = time.monotonic() + RETRY_S
            if isinstance(result, DescriptionError):
                if self._throttle.is_due(node):
                    rospy.logwarn("no panel for %s: %s", node, result)
            return
        self._panels[node], followed = result
        self._followed[node] = followed
        followed.report_again()  # changes before the panel existed were lost
        self._send(self.message())

    def _on_values(self, node: str, raw: Any) -> None:
        panel = self._panels.get(node)
        if panel is not None and isinstance(raw, dict):
            self._send_values(panel, panel.follow(raw))

    def _read_again(self, node: str) -> None:
        followed = self._followed.get(node)
        if followed is not None:
            followed.report_again()

    def _send_values(self, panel: ParameterPanel, names: List[str]) -> None:
        for name in names:
            self._send(value_message(panel, name), panel.node, name)

    def set(self, node: str, name: str, value: Any, answer: Answer) -> None:
        """Set a parameter; if the node rejects the value, the page receives the reason.

        :param node: namespace of the parameter
        :param name: its name in the namespace
        :param value: value from the page
        :param answer: sends a message to the page
        :raises ValueError: if there is no such parameter on a panel
        """
        panel = self._panels.get(node)
        if panel is None or name not in panel.entries:
            raise ValueError(f"there is no parameter {node}/{name}")
        self._sender.set(panel, name, value, answer)

    def call(self, service: str, data: Any, answer: Answer) -> None:
        """Call a service that has a button.

        :param service: its name
        :param data: for SetBool, the Boolean
        :param answer: receives the reply
        :raises ValueError: if there is no such button, or the data have the wrong type
        """
        for panel in self._panels.values():
            if service in panel.services:
                service_buttons.call(self._worker, service, panel.services[service], data, answer)
                return
        raise ValueError(f"no service {service} to call")

    def change_state(self, node: str, label: str, answer: Answer) -> None:
        """Request a transition of a managed node.

        :param node: its name
        :param label: label of the transition
        :param answer: reports the result to the page
        :raises ValueError: if the transition is unavailable now
        """
        self._managed.change(node, label, answer)

    def _describe(self, node: str) -> Iterable[Mapping[str, Any]]:
        if node in self._foreign:
            return dynamic_reconfigure_panels.describe(node)
        return ParameterClient(node).describe().values()

    def _change(self, node: str, values: Mapping[str, Any]) -> ChangeReply:
        """Change parameters of a node.

        :raises CallError: if the node does not answer in time
        """
        if node in self._foreign:
            return dynamic_reconfigure_panels.change(node, values)
        try:
            return ChangeReply(True, "", ParameterClient(node).change(values))
        except ChangeRefused as error:
            return ChangeReply(False, str(error), {})
