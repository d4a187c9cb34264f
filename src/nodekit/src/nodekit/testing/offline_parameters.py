"""Parameters that are judged as a node judges its own, without a node and without a master."""

from typing import Any, Dict, Generic, List, Mapping, Type

from nodekit.parameters.declaration import Snapshot
from nodekit.parameters.judging import on_wire
from nodekit.parameters.kinds import ParameterError
from nodekit.parameters.reconciler import Reconciler, Seen

#: Time between two readings, s: values that do not go together have come to rest by then.
_BETWEEN_S = 10.0


class OfflineParameters(Generic[Snapshot]):
    """A node's parameters, and a parameter server that nobody else writes to.

    :param declaration: the class that declares them

    :ivar server: what the server holds, by name
    """

    def __init__(self, declaration: Type[Snapshot]) -> None:
        self._reconciler = Reconciler(declaration)
        self.server: Dict[str, Any] = on_wire(self._reconciler.values)
        self._now = 0.0

    @property
    def values(self) -> Snapshot:
        """The values in force."""
        return self._reconciler.values

    def set(self, raw: Mapping[str, Any]) -> List[ParameterError]:
        """Set values as ``rosparam set`` does, and have them judged when they have come to rest.

        :param raw: new values by name, of any kind
        :returns: what is refused; the good values are put back
        """
        self.server.update(raw)
        again = True
        while again:
            self._now += _BETWEEN_S
            judged = self._reconciler.step(Seen(dict(self.server)), self._now)
            again = judged.again
        self.server.update(judged.writes)
        self._reconciler.written(self._now)
        return list(judged.refusals)

    def change(self, values: Mapping[str, Any]) -> None:
        """Change all of some values or none, as the service ``~change`` does.

        :param values: new values by name
        :raises ParameterError: if one of them is refused
        """
        self._reconciler.adopt(self._reconciler.judge(values), self._now)
        self.server.update(on_wire(self.values))
