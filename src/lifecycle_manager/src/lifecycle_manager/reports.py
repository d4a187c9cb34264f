"""State of a system, as messages for /diagnostics."""

from typing import List

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from lifecycle_manager.node_state import NodeState, state_text
from lifecycle_manager.system import System

#: Diagnostic level by the level of a node.
_LEVELS = (
    DiagnosticStatus.STALE,
    DiagnosticStatus.WARN,
    DiagnosticStatus.WARN,
    DiagnosticStatus.OK,
)


def reports(manager: str, system: System) -> List[DiagnosticStatus]:
    """Report on a system, and on each of its nodes.

    :param manager: name of the manager
    :param system: the system
    """
    manager = manager.lstrip("/")  # like diagnostic_updater
    level = DiagnosticStatus.OK if system.is_active else DiagnosticStatus.WARN
    whole = DiagnosticStatus(
        level=DiagnosticStatus.ERROR if system.problem else level,
        name=f"{manager}: system",
        message=system.summary,
        hardware_id="none",
    )
    return [whole, *(_report(manager, member) for member in system.members)]


def _report(manager: str, member: NodeState) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=_LEVELS[member.level],
        name=f"{manager}: {member.name}",
        message=state_text(member.state),
        hardware_id="none",
        values=[
            KeyValue("state", str(member.state)),
            KeyValue("heartbeat", "received" if member.is_heard else "silent"),
            KeyValue("under way", member.under_way or "nothing"),
        ],
    )
