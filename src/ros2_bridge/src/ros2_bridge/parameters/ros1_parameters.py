"""Parameters of a ROS 1 node: read from the server, changed through the node's own checks."""

from typing import Any, Dict, List, Mapping, NamedTuple, Optional

from nodekit import (
    CallError,
    ChangeRefused,
    DescriptionError,
    MasterUnreachable,
    ParameterClient,
)
from nodekit.master import MasterClient
from ros2_bridge.parameters.values import BOOL, declared_kind, flat, kind_of, ros1_key

#: Timeout for a node's description of its parameters, and for the check of a change [s].
TIMEOUT_S = 2.0
#: A parameter of every ROS 2 node; in ROS 1 all nodes share one, so the bridge does not set it.
_SIM_TIME, _SIM_TIME_IN_ROS1 = "use_sim_time", "/use_sim_time"


class Parameter(NamedTuple):
    """A parameter.

    :param kind: type, as numbered in ROS 2
    :param entry: of the node's description; None without one
    """

    value: Any
    kind: int
    entry: Optional[Mapping[str, Any]]


class UnreadableParameters(Exception):
    """Parameters that cannot be read; the text gives the cause."""


class Ros1Parameters:
    """Parameters of a ROS 1 node, including use_sim_time.

    :param client: client of the master
    :param name: global name of the node
    """

    def __init__(self, client: MasterClient, name: str) -> None:
        self._client, self.name = client, name

    def read(self) -> Dict[str, Parameter]:
        """Return the current parameters, by ROS 2 name.

        :raises UnreadableParameters: if the node or the master does not answer
        """
        try:
            found = self._read()
            value = self._client.read([_SIM_TIME_IN_ROS1]).values[_SIM_TIME_IN_ROS1]
        except (CallError, DescriptionError, MasterUnreachable) as error:
            raise UnreadableParameters(str(error)) from None
        found[_SIM_TIME] = Parameter(value is True, BOOL, None)
        return found

    def change(self, values: Mapping[str, Any]) -> str:
        """Change all of the given parameters, or none.

        :param values: new values, by ROS 2 name
        :returns: the reason for a rejection; empty on success
        """
        if _SIM_TIME in values:
            return f"{_SIM_TIME} is shared by all nodes of ROS 1: rosparam set {_SIM_TIME_IN_ROS1}"
        try:
            return self._change({ros1_key(name): value for name, value in values.items()})
        except (CallError, ChangeRefused, MasterUnreachable) as error:
            return str(error)

    def caution(self, names: List[str]) -> str:
        """Return a warning about a change of parameters; empty for none.

        :param names: ROS 2 names of the parameters
        """
        del names
        return ""

    def _read(self) -> Dict[str, Parameter]:
        raise NotImplementedError

    def _change(self, values: Mapping[str, Any]) -> str:
        raise NotImplementedError


class DescribedParameters(Ros1Parameters):
    """Parameters of a nodekit node, which describes them and validates changes itself."""

    def _read(self) -> Dict[str, Parameter]:
        entries = ParameterClient(self.name, TIMEOUT_S).describe()
        try:
            return {
                name.replace("/", "."): Parameter(entry["value"], declared_kind(entry), entry)
                for name, entry in entries.items()
            }
        except (KeyError, TypeError) as error:
            raise UnreadableParameters(f"malformed description of {self.name}: {error!r}") from None

    def _change(self, values: Mapping[str, Any]) -> str:
        ParameterClient(self.name, TIMEOUT_S).change(values)
        return ""


class ServerParameters(Ros1Parameters):
    """Parameters of any other node, on the parameter server, which accepts every value."""

    def _read(self) -> Dict[str, Parameter]:
        tree = self._client.read([self.name]).values[self.name]
        values = flat(tree) if isinstance(tree, dict) else {}
        kinds = {name: kind_of(value) for name, value in values.items()}
        return {name: Parameter(values[name], kind, None) for name, kind in kinds.items() if kind}

    def _change(self, values: Mapping[str, Any]) -> str:
        # Has a managed node been configured since the last poll?
        if self._client.lookup_service(f"{self.name}/describe"):
            return f"{self.name} now checks its parameters itself; try again"
        self._client.write({f"{self.name}/{key}": value for key, value in values.items()})
        return ""

    def caution(self, names: List[str]) -> str:
        if not names:
            return ""
        which = ", ".join(names)
        return (
            f"{which}: written to the parameter server; {self.name} may read it at its start only"
        )
