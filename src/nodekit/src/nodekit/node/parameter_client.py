"""Client of another node's parameters."""

from typing import Any, Dict, Mapping

from std_srvs.srv import Trigger

from nodekit.argument_checks import check_timeout
from nodekit.node.clients import ANSWER_S, CallError, call_service
from nodekit.parameter_server.parameter_services import CHANGE, DESCRIBE
from nodekit.parameters import yaml_text
from nodekit.parameters.parameter_types import to_wire
from nodekit.parameters.schema import DescriptionError, description_in
from nodekit_msgs.srv import SetParameters


class ChangeRefused(ValueError):
    """Error of a change that a node rejects; the text is the node's message for each value."""


class ParameterClient:
    """Client that reads and changes the parameters of one node.

    The node must describe its parameters, as nodes of nodekit do. For any other node, each method
    raises a :class:`.CallError` with the name of the missing service: use the parameter server
    instead, see :class:`nodekit.master.MasterClient`.

    :param node: global name of the node
    :param timeout: longest wait for a response [s]
    :raises ValueError: if the time-out is invalid
    """

    def __init__(self, node: str, timeout: float = ANSWER_S) -> None:
        check_timeout(timeout)
        self.node, self._timeout = node.rstrip("/"), timeout

    def describe(self) -> Dict[str, Dict[str, Any]]:
        """Return the description of all parameters.

        :returns: by name, in the order of declaration, the entry of :func:`nodekit.describe`: its
            ``value``, ``type``, ``unit``, ``range``, ``default``, ``help`` and more;
            :func:`nodekit.parameter_of` returns a parameter for it that validates values
        :raises CallError: if the node does not respond
        :raises DescriptionError: if the response is malformed
        """
        service = f"{self.node}/{DESCRIBE}"
        answer = call_service(service, Trigger, timeout=self._timeout).result()
        try:
            return {str(entry["name"]): entry for entry in description_in(answer.message)}
        except DescriptionError as error:
            raise DescriptionError(f"{service} sent a malformed reply: {error}") from None

    def get(self) -> Dict[str, Any]:
        """Return the current values by name.

        :raises CallError: if the node does not respond
        :raises DescriptionError: if the response is malformed
        """
        return {name: entry["value"] for name, entry in self.describe().items()}

    def change(self, values: Mapping[str, Any]) -> Dict[str, Any]:
        """Change parameters, all or none.

        :param values: new values by name
        :returns: the current values of all parameters, by name
        :raises ChangeRefused: if the node rejects one of them; nothing has changed then
        :raises CallError: if the node does not respond; it is unknown then whether it has changed
        """
        service = f"{self.node}/{CHANGE}"
        text = request_text(values)
        answer = call_service(service, SetParameters, text, timeout=self._timeout).result()
        if not answer.success:
            raise ChangeRefused(answer.message or "rejected without a reason")
        try:
            in_force = yaml_text.load(answer.values)
        except ValueError:
            in_force = None
        if not isinstance(in_force, dict):
            raise CallError(f"{service} sent a malformed reply: {answer.values!r:.80}")
        return in_force


def request_text(values: Mapping[str, Any]) -> str:
    """Return the request for a node's ``~change``.

    :param values: new values by name
    :raises ValueError: if a value has a type that no parameter has
    """
    plain = {name: to_wire(value) for name, value in values.items()}
    try:
        return yaml_text.dump(plain)
    except ValueError as error:
        raise ValueError(f"not a value of a parameter: {error}") from None
