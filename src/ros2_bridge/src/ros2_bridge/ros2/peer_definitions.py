"""Check of the type definitions of other ROS 2 nodes against the bridge's own."""

import contextlib
import json
import pathlib
import sys
import time
from types import SimpleNamespace
from typing import Any, Dict, List, Optional, Set, Tuple

import rospy
from type_description_interfaces.msg import FieldType
from type_description_interfaces.srv import GetTypeDescription

from ros2_bridge.ros2.client import NoResponse, Ros2Client
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.skip_log import Unbridgeable
from ros2_bridge.types.type_descriptions import (
    Field,
    as_text,
    flatten,
    is_renamed_in_order,
    kind_of,
)

#: Timeout for a node's type description [s].
_TIMEOUT_S = 3.0
#: Names of field types, by number.
_KINDS = {
    getattr(FieldType, name): name[len("FIELD_TYPE_") :].lower()
    for name in dir(FieldType)
    if name.startswith("FIELD_TYPE_")
}
#: Placeholder in the graph for an unknown type hash.
_UNKNOWN_HASH = "INVALID"


class _DefinitionRequest:
    """A request for a node's definition.

    :param client: client of the node's service
    :param request: the request

    :ivar deadline: end of the wait, on the monotonic clock [s]
    :ivar fields: the flattened answer; None until then, and without an answer
    """

    def __init__(self, client: Ros2Client, request: Any) -> None:
        self._client, self._request = client, request
        self._is_sent = self._is_closed = False
        self.deadline = time.monotonic() + _TIMEOUT_S
        self.fields: Optional[List[Field]] = None

    def send_once_ready(self) -> None:
        """Send the request as soon as the node's service has been discovered."""
        if not self._is_sent and self._client.is_ready():
            with contextlib.suppress(NoResponse):  # the service has just disappeared
                self._client.send(self._request, self._receive)
                self._is_sent = True

    def _receive(self, response: Any) -> None:
        if response.successful:
            found = response.type_description
            parts = [found.type_description, *found.referenced_type_descriptions]
            self.fields = flatten(dict(map(_as_fields, parts)), self._request.type_name)

    def close(self) -> None:
        """Close the client."""
        if not self._is_closed:
            self._is_closed = True
            self._client.close()


class PeerDefinitions:
    """Checker of the type definitions of other ROS 2 nodes.

    :param participant: the bridge in ROS 2
    """

    def __init__(self, participant: Participant) -> None:
        self._participant = participant
        self._own: Dict[str, Tuple[str, List[Field]]] = {}
        self._questions: Dict[Tuple[str, str, str], _DefinitionRequest] = {}
        self._warned: Set[str] = set()

    def are_known_to_fit(self, topic: str, type_name: str, type_hash: str, node: str) -> bool:
        """Return whether a node's definition of a type matches the bridge's, ignoring field names.

        :param topic: name of the topic, for messages
        :param type_name: ``package/msg/Name``
        :param type_hash: hash of the node's definition
        :param node: name of the node
        :returns: False while the node's answer is pending
        :raises Unbridgeable: if the definitions differ, so that values would be mixed up
        """
        own_hash, ours = self._own_definition(type_name)
        if type_hash in (own_hash, _UNKNOWN_HASH) or not own_hash:
            return True
        key = (type_name, type_hash, node)
        question = self._questions.get(key)
        if question is None:
            name = f"{node}/get_type_description"
            client = Ros2Client(self._participant, GetTypeDescription, name)
            request = GetTypeDescription.Request(type_name=type_name, type_hash=type_hash)
            question = self._questions[key] = _DefinitionRequest(client, request)
        theirs = question.fields
        if theirs is None and time.monotonic() < question.deadline:
            question.send_once_ready()
            return False
        question.close()
        differs = f"{topic}: {node} has another definition of {type_name}"
        if theirs is None:
            del self._questions[key]  # the next poll asks again
            raise Unbridgeable(
                f"{differs} than the bridge ({type_hash[:15]}…, {own_hash[:15]}…), and does not "
                "describe it; build both from one definition"
            )
        if is_renamed_in_order(ours, theirs):
            self._warn_once(
                f"{differs}, with other names: ({as_text(theirs)}) there, ({as_text(ours)}) in the"
                " bridge; values are passed in this order"
            )
            return True
        raise Unbridgeable(
            f"{differs}: ({as_text(theirs)}) there, ({as_text(ours)}) in the bridge; build both "
            "from one definition"
        )

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            rospy.logwarn(text)

    def _own_definition(self, type_name: str) -> Tuple[str, List[Field]]:
        """Return hash and fields of the bridge's own type; an empty hash if it has none."""
        if type_name not in self._own:
            package, kind, name = type_name.split("/")
            path = pathlib.Path(sys.prefix, "share", package, kind, f"{name}.json")
            try:
                found = json.loads(path.read_text("utf-8"))
                hashes = {each["type_name"]: each["hash_string"] for each in found["type_hashes"]}
                description = found["type_description_msg"]
                parts = [description["type_description"]]
                parts += description["referenced_type_descriptions"]
                types = dict(map(_as_fields, map(_as_object, parts)))
                self._own[type_name] = hashes[type_name], flatten(types, type_name)
            except (OSError, ValueError, KeyError):
                self._own[type_name] = "", []
        return self._own[type_name]


def _as_fields(part: Any) -> Tuple[str, List[Field]]:
    """Return the name of a type, and its fields.

    :param part: an IndividualTypeDescription, or an object with the same attributes
    """
    return part.type_name, [
        Field(
            each.name,
            kind_of(_KINDS[each.type.type_id], each.type.nested_type_name, each.type.capacity),
        )
        for each in part.fields
    ]


def _as_object(value: Any) -> Any:
    """Return decoded JSON as objects with attributes, like messages."""
    if isinstance(value, dict):
        return SimpleNamespace(**{name: _as_object(each) for name, each in value.items()})
    return [_as_object(each) for each in value] if isinstance(value, list) else value
