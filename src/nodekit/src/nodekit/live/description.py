"""Let a node describe its parameters: value, type, unit, range and help."""

from typing import Any, Callable, Dict, List

import rospy
import yaml
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from nodekit.parameters.declaration import ParameterSet, describe

#: Base name of the service, in the namespace of the parameters.
SERVICE = "describe"


def offer_description(namespace: str, values: Callable[[], ParameterSet]) -> rospy.Service:
    """Offer the service ``<namespace>/describe`` (std_srvs/Trigger).

    :param namespace: global name of the namespace of the parameters
    :param values: returns the snapshot in force
    :returns: the service; its answer's ``message`` is a YAML list with one
        entry for each parameter, in the order of declaration
    """

    def answer(_request: TriggerRequest) -> TriggerResponse:
        return TriggerResponse(True, as_yaml(describe(values())))

    return rospy.Service("%s/%s" % (namespace, SERVICE), Trigger, answer)


def as_yaml(description: List[Dict[str, Any]]) -> str:
    """Return a description as YAML.

    :param description: what :func:`parameters.describe` returned
    """
    return str(yaml.safe_dump(description, sort_keys=False, allow_unicode=True, width=1000))


def as_table(description: List[Dict[str, Any]]) -> str:
    """Return a description as lines of text with aligned columns.

    :param description: what :func:`parameters.describe` returned
    """
    rows = [
        (
            entry["name"],
            "= %s" % yaml.safe_dump(entry["value"], default_flow_style=True).split("\n")[0],
            " ".join(filter(None, (entry["type"], entry["range"], entry["unit"]))),
            entry["help"],
        )
        for entry in description
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    return "\n".join(
        "  %s  %s" % ("  ".join(cell.ljust(width) for cell, width in zip(row, widths)), row[3])
        for row in rows
    )
