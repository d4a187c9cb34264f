"""The parameters of another node: what they are, and changes that are answered."""

from typing import Any, Dict, Mapping

from std_srvs.srv import Trigger

from nodekit.node.clients import ANSWER_S, CallError, call_service
from nodekit.parameter_server.services import CHANGE, DESCRIBE
from nodekit.parameters import yaml_text
from nodekit.parameters.kinds import to_wire
from nodekit.parameters.schema import DescriptionError, description_in
from nodekit.validation import check_timeout
from nodekit_msgs.srv import SetParameters


class ChangeRefused(ValueError):
    """A change that a node refuses; the text is what the node says of each value."""


class ParameterClient:
    """Asks one node for its parameters, and has it change them.

    Meant for nodes that describe their parameters, as those of nodekit do. Of any other, each
    method raises a :class:`.CallError` that names the service it does not offer: its parameters
    are on the parameter server alone, see :class:`nodekit.master.MasterClient`.

    :param node: global name of the node
    :param timeout: longest wait for an answer, s
    :raises ValueError: if that is none
    """

    def __init__(self, node: str, timeout: float = ANSWER_S) -> None:
        check_timeout(timeout)
        self.node, self._timeout = node.rstrip("/"), timeout

    def describe(self) -> Dict[str, Dict[str, Any]]:
        """Ask for all parameters.

        :returns: of each, by name and in the order of declaration, what :func:`nodekit.describe`
            says: its ``value``, ``type``, ``unit``, ``range``, ``default``, ``help`` and more;
            :func:`nodekit.parameter_of` makes of it a parameter that judges values
        :raises CallError: if the node does not answer
        :raises DescriptionError: if it answers with something else
        """
        service = f"{self.node}/{DESCRIBE}"
        answer = call_service(service, Trigger, timeout=self._timeout).result()
        try:
            return {str(entry["name"]): entry for entry in description_in(answer.message)}
        except DescriptionError as error:
            raise DescriptionError(f"{service} sent a malformed reply: {error}") from None

    def get(self) -> Dict[str, Any]:
        """Ask for the values in force.

        :returns: the values by name
        :raises CallError: if the node does not answer
        :raises DescriptionError: if it answers with something else
        """
        return {name: entry["value"] for name, entry in self.describe().items()}

    def change(self, values: Mapping[str, Any]) -> Dict[str, Any]:
        """Have parameters changed, all of them or none.

        :param values: new values by name
        :returns: the values in force of all parameters, by name
        :raises ChangeRefused: if the node refuses one of them; nothing has changed then
        :raises CallError: if the node does not answer: then nobody knows what has changed
        """
        service = f"{self.node}/{CHANGE}"
        text = request_text(values)
        answer = call_service(service, SetParameters, text, timeout=self._timeout).result()
        if not answer.success:
            raise ChangeRefused(answer.message or "refused without a reason")
        try:
            in_force = yaml_text.load(answer.values)
        except ValueError:
            in_force = None
        if not isinstance(in_force, dict):
            raise CallError(f"{service} sent a malformed reply: {answer.values!r:.80}")
        return in_force


def request_text(values: Mapping[str, Any]) -> str:
    """Return values as a node's ``~change`` takes them.

    :param values: by name
    :raises ValueError: if one of them is of a kind that no parameter has
    """
    plain = {name: to_wire(value) for name, value in values.items()}
    try:
        return yaml_text.dump(plain)
    except ValueError as error:
        raise ValueError(f"not a value of a parameter: {error}") from None
