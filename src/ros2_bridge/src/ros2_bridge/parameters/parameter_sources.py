"""Where the parameters of a node of ROS 1 are, and who judges a change of them."""

from typing import Any, Dict, Mapping, NamedTuple, Optional, Union

from nodekit import CallError, ChangeRefused, MasterUnreachable, ParameterClient
from nodekit.master import MasterClient
from ros2_bridge.parameters.parameter_values import (
    BOOL,
    HIGHEST,
    LOWEST,
    declared_kind,
    flat,
    kind_of,
    ros1_key,
)

#: How long a node may take to describe its parameters, or to judge a change, s.
TIMEOUT_S = 2.0


class Parameter(NamedTuple):
    """A parameter.

    :param kind: as ROS 2 numbers them
    :param entry: of the node's description, None where it has none
    """

    value: Any
    kind: int
    entry: Optional[Mapping[str, Any]]


class Unreadable(Exception):
    """Parameters that cannot be had; the text says why."""


class Described:
    """A node made with nodekit, which describes its parameters and judges changes itself.

    :param name: global name of the node
    """

    def __init__(self, name: str) -> None:
        self._node = ParameterClient(name, TIMEOUT_S)

    def read(self) -> Dict[str, Parameter]:
        """Return the parameters in force.

        :raises Unreadable: if the node does not tell
        """
        try:
            return {
                name.replace("/", "."): Parameter(entry["value"], declared_kind(entry), entry)
                for name, entry in self._node.describe().items()
            }
        except CallError as error:
            raise Unreadable(str(error)) from None
        except (KeyError, TypeError) as error:
            raise Unreadable(f"it sent a malformed description: {error!r}") from None

    def change(self, values: Mapping[str, Any]) -> str:
        """Change all of some parameters, or none.

        :returns: why not; empty where they are in force
        """
        try:
            self._node.change({ros1_key(name): value for name, value in values.items()})
        except (CallError, ChangeRefused) as error:
            return str(error)
        return ""


class Plain:
    """Any other node: what stands on the parameter server, which takes everything.

    :param client: asks the master
    :param name: global name of the node
    """

    def __init__(self, client: MasterClient, name: str) -> None:
        self._client, self._name = client, name

    def read(self) -> Dict[str, Parameter]:
        """Return what stands in the node's namespace.

        :raises Unreadable: if the master does not answer
        """
        try:
            tree = self._client.read([self._name]).values[self._name]
        except MasterUnreachable as error:
            raise Unreadable(str(error)) from None
        if not isinstance(tree, dict):
            return {}
        return {
            name: Parameter(value, kind_of(value), None)
            for name, value in flat(tree).items()
            if kind_of(value)
        }

    def change(self, values: Mapping[str, Any]) -> str:
        """Set parameters on the server.

        :returns: why not; empty where they are there
        """
        keys = {f"{self._name}/{ros1_key(name)}": value for name, value in values.items()}
        try:
            # A managed one that was configured since the last poll?
            if self._client.lookup_service(f"{self._name}/describe"):
                return f"{self._name} has just begun to judge its parameters itself: try again"
            self._client.write(keys)
        except MasterUnreachable as error:
            return f"the master does not answer ({error})"
        return ""


class WithSimTime:
    """The parameters of a node, and whether it goes by simulated time, which each has in ROS 2.

    In ROS 1 that is one parameter for all nodes, so it is not set here.

    :param source: of the node's own
    :param client: asks the master
    """

    NAME, ROS1_NAME = "use_sim_time", "/use_sim_time"

    def __init__(self, source: Union[Described, Plain], client: MasterClient) -> None:
        self._source, self._client = source, client

    def read(self) -> Dict[str, Parameter]:
        """Return the parameters in force.

        :raises Unreadable: if the node or the master does not tell
        """
        own = self._source.read()
        try:
            value = self._client.read([self.ROS1_NAME]).values[self.ROS1_NAME]
        except MasterUnreachable as error:
            raise Unreadable(str(error)) from None
        return {**own, self.NAME: Parameter(value is True, BOOL, None)}

    def change(self, values: Mapping[str, Any]) -> str:
        """Change all of some parameters, or none.

        :returns: why not; empty where they are in force
        """
        if self.NAME in values:
            return f"{self.NAME} is shared by all nodes of ROS 1: rosparam set {self.ROS1_NAME}"
        return self._source.change(values)


def unfit(name: str, value: Any) -> str:
    """Return why ROS 1 cannot carry a value; empty where it can."""
    several = value if isinstance(value, list) else [value]
    for one in several:
        if one is None:
            return f"{name} cannot be removed: ROS 1's nodes keep their parameters"
        if type(one) is int and not LOWEST <= one <= HIGHEST:
            return f"{name}: refused {one}: ROS 1 carries integers of 32 bits only"
        if type(one) is str and any(ord(sign) < 32 and sign not in "\t\n\r" for sign in one):
            return f"{name}: refused {one!r}: ROS 1 carries no control characters"
    return ""
