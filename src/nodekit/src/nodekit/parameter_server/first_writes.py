"""Write what the namespaces of many nodes lack before the master notifies of their changes.

With each value that it is given, the master looks through all subscriptions of parameters: it took
11 s for the 17 000 values of 500 groups, and 1.6 s where nothing was subscribed yet.
"""

from typing import Any, Dict, Mapping

from nodekit.master import MasterClient
from nodekit.parameters.declaration import ParameterSet
from nodekit.parameters.judging import on_wire
from nodekit.parameters.kinds import MISSING

#: Fewer namespaces are subscribed first: then no value is lost that somebody sets just now.
MANY = 100
#: Most namespaces that are read at a time, so that they are written to soon after it.
_TOGETHER = 20


def write_missing(client: MasterClient, in_force: Mapping[str, ParameterSet]) -> None:
    """Write the values that the server lacks, and none that it holds.

    :param client: asks the master
    :param in_force: values by namespace
    :raises MasterUnreachable: if the master does not answer
    """
    namespaces = list(in_force)
    for start in range(0, len(namespaces), _TOGETHER):
        held = client.read(namespaces[start : start + _TOGETHER]).values
        writes: Dict[str, Any] = {}
        for namespace, raw in held.items():
            tree = {} if raw is MISSING else raw
            if isinstance(tree, dict):
                for name, value in on_wire(in_force[namespace]).items():
                    if name not in tree:
                        writes[f"{namespace}/{name}"] = value
        client.write(writes)
