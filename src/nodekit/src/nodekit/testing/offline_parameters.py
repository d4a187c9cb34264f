"""Parameters that are validated as in a node, without a node or a master."""

from typing import Any, Dict, Generic, List, Mapping, Type

from nodekit.parameters.declaration import Snapshot
from nodekit.parameters.parameter_types import ParameterError
from nodekit.parameters.reconciler import Observation, Reconciler
from nodekit.parameters.validation import on_wire

#: Time between two readings [s]: long enough for inconsistent values to settle.
_BETWEEN_S = 10.0


class OfflineParameters(Generic[Snapshot]):
    """A node's parameters with a private parameter server.

    :param declaration: the class that declares them

    :ivar server: values on the server, by name
    """

    def __init__(self, declaration: Type[Snapshot]) -> None:
        self._reconciler = Reconciler(declaration)
        self.server: Dict[str, Any] = on_wire(self._reconciler.values)
        self._now = 0.0

    @property
    def values(self) -> Snapshot:
        """The current values."""
        return self._reconciler.values

    def set(self, raw: Mapping[str, Any]) -> List[ParameterError]:
        """Set values as ``rosparam set`` does, and validate them once they have settled.

        :param raw: new values by name, of any type
        :returns: the errors of rejected values, which are reset
        """
        self.server.update(raw)
        again = True
        while again:
            self._now += _BETWEEN_S
            decision = self._reconciler.step(Observation(dict(self.server)), self._now)
            again = decision.again
        self.server.update(decision.writes)
        self._reconciler.written(self._now)
        return list(decision.errors)

    def change(self, values: Mapping[str, Any]) -> None:
        """Change all of some values or none, as the service ``~change`` does.

        :param values: new values by name
        :raises ParameterError: if one of them is rejected
        """
        self._reconciler.adopt(self._reconciler.validate(values), self._now)
        self.server.update(on_wire(self.values))
