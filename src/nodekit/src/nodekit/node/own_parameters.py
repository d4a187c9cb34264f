"""The parameters that a process reads for its nodes, whatever their classes declare."""

from nodekit.parameters.declaration import ParameterSet
from nodekit.parameters.kinds import BoolParameter


class OwnParameters(ParameterSet):
    """Private parameters of every node; read once, before its class is made."""

    managed = BoolParameter(False, help="wait until others configure and activate the node")
