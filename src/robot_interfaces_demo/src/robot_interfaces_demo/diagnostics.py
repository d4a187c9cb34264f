"""Findings as diagnostic messages."""

from typing import Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from robot_interfaces_demo.monitoring.robot import Finding


def as_message(node: str, findings: Sequence[Finding]) -> DiagnosticArray:
    """Return findings as a message.

    :param node: name of the monitor
    :param findings: each becomes a status named ``NODE: NAME``, that of the fleet ``NODE``
    """
    prefix = node.lstrip("/")
    return DiagnosticArray(
        Header(stamp=rospy.get_rostime()),
        [
            DiagnosticStatus(
                int(level),
                f"{prefix}: {name}" if name else prefix,
                message,
                name,
                [KeyValue(key, value) for key, value in values.items()],
            )
            for name, level, message, values in findings
        ],
    )
