# Pure: knows no ROS.
"""Sender of parameter changes to nodes; resends rejected values with later changes.

A value is sent to the node's service ``~change``, whose reply states whether it was accepted, and
why not. The service changes several parameters in one step, so rejected values are kept, and sent
again together with each later change, until they are accepted or set again. This makes it possible
to change, one after another, lists that must have the same length.
"""

from functools import partial
from typing import Any, Callable, Dict, List, Mapping, NamedTuple

from nodekit import ParameterError, to_wire
from topic_scope.controls.panel import ParameterPanel
from topic_scope.graph.worker import Worker

#: Sends a message to one page.
Answer = Callable[[Dict[str, Any]], None]


class ChangeReply(NamedTuple):
    """Reply of a node to a change.

    :param success: whether all values were accepted
    :param message: why they were not
    :param values: current values, by name
    """

    success: bool
    message: str
    values: Mapping[str, Any]


class ChangeRequest(NamedTuple):
    """Value that a page has set.

    :param panel: the node's panel
    :param value: the value
    :param answer: sends a message to the page
    """

    panel: ParameterPanel
    value: Any
    answer: Answer


class ParameterSender:
    """Sender of parameter changes; all methods are for the web thread.

    :param worker: worker that waits for nodes
    :param change: changes parameters of a node by name; raises an exception if it does not answer
    :param send_values: sends changed values to all pages
    :param read_again: updates the panel of a node from the parameter server
    """

    def __init__(
        self,
        worker: Worker,
        change: Callable[[str, Mapping[str, Any]], ChangeReply],
        send_values: Callable[[ParameterPanel, List[str]], None],
        read_again: Callable[[str], None],
    ) -> None:
        self._worker, self._change, self._send_values = worker, change, send_values
        self._read_again = read_again
        #: By node and parameter: the newest value to send; and rejected values, which may be
        #: accepted together with other values.
        self._waiting: Dict[str, Dict[str, ChangeRequest]] = {}
        self._rejected: Dict[str, Dict[str, Any]] = {}

    def set(self, panel: ParameterPanel, name: str, value: Any, answer: Answer) -> None:
        """Set a parameter; if the value is rejected, the page receives the reason.

        :param panel: its panel
        :param name: its name
        :param value: value from the page
        :param answer: sends a message to the page
        """
        try:
            checked = panel.check(name, value)
        except ParameterError as error:
            _refuse(panel, name, value, str(error), answer)
            return
        self._rejected.get(panel.node, {}).pop(name, None)
        self._waiting.setdefault(panel.node, {})[name] = ChangeRequest(panel, checked, answer)
        self._send(panel.node)

    def forget(self, node: str) -> None:
        """Drop the rejected values of a node that has disappeared.

        :param node: its name
        """
        self._rejected.pop(node, None)

    def _send(self, node: str) -> None:
        """Send the waiting values; values set meanwhile are sent afterwards."""
        asked = self._waiting.get(node)
        if asked is None:
            return
        wanted = {name: to_wire(ask.value) for name, ask in asked.items()}
        work = partial(self._try, node, wanted, dict(self._rejected.get(node, {})))
        if self._worker.run(("change", node), work, partial(self._on_answer, node, asked)):
            del self._waiting[node]

    def _try(
        self, node: str, wanted: Mapping[str, Any], rejected: Mapping[str, Any]
    ) -> ChangeReply:
        """Change values together with those rejected before, or without them if that fails."""
        answer = self._change(node, {**rejected, **wanted})
        if rejected and not answer.success:
            answer = self._change(node, wanted)
        return answer

    def _on_answer(self, node: str, asked: Mapping[str, ChangeRequest], result: Any) -> None:
        newer = set(self._waiting.get(node, {}))
        self._send(node)
        if isinstance(result, Exception):
            result = ChangeReply(False, f"{node} does not answer: {result}", {})
        panel = next(iter(asked.values())).panel
        self._send_values(panel, panel.follow(result.values))
        self._read_again(panel.node)  # another client's change may be newer than this reply
        rejected = self._rejected.setdefault(node, {})
        if result.success:
            for name in [name for name in rejected if rejected[name] == result.values.get(name)]:
                del rejected[name]
            return
        for name, ask in asked.items():
            if name not in newer:
                rejected[name] = to_wire(ask.value)
                _refuse(panel, name, ask.value, result.message, ask.answer, kept=True)


def value_message(panel: ParameterPanel, name: str) -> Dict[str, Any]:
    """Return the message with a parameter's value."""
    return {"type": "value", "node": panel.node, "name": name, "value": panel.shown_value(name)}


def _refuse(
    panel: ParameterPanel, name: str, value: Any, text: str, answer: Answer, kept: bool = False
) -> None:
    """Send a page the reason for a rejection, and whether the value will be tried again."""
    message = {"type": "refused", "node": panel.node, "name": name, "value": to_wire(value)}
    answer({**message, "text": text, "kept": kept})
    answer(value_message(panel, name))
