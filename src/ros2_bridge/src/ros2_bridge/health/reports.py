"""Reports of the bridge's health: statuses for ``/diagnostics``, and a table for a terminal."""

from typing import Dict, List, Mapping, NamedTuple, Sequence, Tuple

from ros2_bridge.health.topic_health import FAULTS, TopicHealth
from ros2_bridge.rules.selection import Route

#: Levels, as in diagnostic_msgs/DiagnosticStatus.
OK, WARN, ERROR = 0, 1, 2
#: Maximum number of topics that a message names.
_MOST_NAMED = 3
#: Counters of messages in the table, and its columns.
_COUNTERS = ("passed", *FAULTS, "thinned")
_COLUMNS = ("topic", "to", "Hz", *_COUNTERS, "queue")


class BridgeHealth(NamedTuple):
    """State of the bridge.

    :param topics: state of each topic
    :param services, actions: numbers of bridged services and actions
    :param not_bridged: current reasons why names are not bridged
    :param trouble: reason why nothing new is bridged; empty without one
    :param memory: resident memory of the process [bytes]
    """

    topics: Mapping[Route, TopicHealth]
    services: int
    actions: int
    not_bridged: Sequence[str]
    trouble: str
    memory: int


class Status(NamedTuple):
    """Status, as in diagnostic_msgs/DiagnosticStatus.

    :param name: its name, without the node's
    """

    level: int
    name: str
    message: str
    values: List[Tuple[str, str]]


def statuses(health: BridgeHealth) -> List[Status]:
    """Return the statuses: always the same four, so none becomes stale when a topic ends."""
    return [
        _bridge_status(health),
        _topics_status(health, to_ros2=True),
        _topics_status(health, to_ros2=False),
        _not_bridged_status(health.not_bridged),
    ]


def is_well(health: BridgeHealth) -> bool:
    """Return whether no status is above OK."""
    return all(status.level == OK for status in statuses(health))


def _bridge_status(health: BridgeHealth) -> Status:
    values = [
        ("topics to ROS 2", str(len(_topics(health, True)))),
        ("topics to ROS 1", str(len(_topics(health, False)))),
        ("services", str(health.services)),
        ("actions", str(health.actions)),
        ("memory [bytes]", str(health.memory)),
    ]
    if health.trouble:
        return Status(ERROR, "bridge", health.trouble, values)
    return Status(OK, "bridge", "follows both graphs", values)


def _topics(health: BridgeHealth, to_ros2: bool) -> Dict[str, TopicHealth]:
    return {
        route.name: state
        for route, state in sorted(health.topics.items())
        if route.to_ros2 == to_ros2
    }


def _is_active(state: TopicHealth) -> bool:
    """Return whether a topic has had messages."""
    return any(getattr(state.counts, name) for name in _COUNTERS)


def _topics_status(health: BridgeHealth, to_ros2: bool) -> Status:
    topics = _topics(health, to_ros2)
    active = {name: state for name, state in topics.items() if _is_active(state)}
    values = [(name, _topic_text(state, to_ros2)) for name, state in active.items()]
    values.append(("topics without messages", str(len(topics) - len(active))))
    faulty = [f"{name} ({_faults(state)})" for name, state in active.items() if state.recent]
    name = f"topics to ROS {2 if to_ros2 else 1}"
    if faulty:
        more = len(faulty) - _MOST_NAMED
        text = ", ".join(faulty[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
        return Status(WARN, name, f"in the last 10 s: {text}", values)
    rate = sum(state.rate for state in active.values())
    return Status(OK, name, f"{rate:.1f} messages/s; topics with messages: {len(active)}", values)


def _faults(state: TopicHealth) -> str:
    return ", ".join(f"{count} {FAULTS[name]}" for name, count in state.recent.items())


def _topic_text(state: TopicHealth, to_ros2: bool) -> str:
    counts = state.counts
    found = [f"{state.rate:.1f} Hz", f"{counts.passed} passed"]
    found += [
        f"{getattr(counts, name)} {what}" for name, what in FAULTS.items() if getattr(counts, name)
    ]
    if counts.thinned:
        found.append(f"{counts.thinned} dropped by max_rate")
    return ", ".join([*found, f"queue {_queue(counts.held, to_ros2)}"])


def _queue(held: int, to_ros2: bool) -> str:
    """Return the size of a queue; to ROS 2, its upper bound."""
    return f"at most {held} bytes" if to_ros2 else f"{held} bytes"


def _not_bridged_status(reasons: Sequence[str]) -> Status:
    values = [(str(number), reason) for number, reason in enumerate(reasons, 1)]
    if not reasons:
        return Status(OK, "not bridged", "nothing", values)
    what = f"{len(reasons)}, such as {reasons[0]}" if len(reasons) > 1 else reasons[0]
    return Status(WARN, "not bridged", f"{what}; ~deny excludes a name", values)


def table(node: str, health: BridgeHealth) -> str:
    """Return the report for a terminal.

    :param node: name of the bridge
    """
    head, *others = statuses(health)
    numbers = ", ".join(f"{name} {what}" for name, what in head.values)
    lines = [f"{node}: {'ERROR ' if head.level else ''}{head.message}; {numbers}"]
    rows: List[Tuple[str, ...]] = [_COLUMNS]
    idle = 0
    for route, state in sorted(health.topics.items()):
        if _is_active(state):
            rows.append(_row(route, state))
        else:
            idle += 1
    widths = [max(map(len, column)) for column in zip(*rows)]
    if len(rows) > 1:
        for row in rows:
            cells = [row[0].ljust(widths[0]), row[1].ljust(widths[1])]
            cells += [cell.rjust(width) for cell, width in zip(row[2:], widths[2:])]
            lines.append("  ".join(cells).rstrip())
    lines.append(f"topics without messages: {idle}")
    lines += [f"WARN {one.name}: {one.message}" for one in others[:2] if one.level]
    lines += [f"not bridged: {reason}" for reason in health.not_bridged]
    return "\n".join(lines)


def _row(route: Route, state: TopicHealth) -> Tuple[str, ...]:
    return (
        route.name,
        "ROS 2" if route.to_ros2 else "ROS 1",
        f"{state.rate:.1f}",
        *(str(getattr(state.counts, name)) for name in _COUNTERS),
        _queue(state.counts.held, route.to_ros2),
    )
