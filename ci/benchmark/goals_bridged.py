"""Goals of actions from one ROS to the other through the bridge, and within each to compare."""

import contextlib
import itertools
from typing import Dict, Tuple

from .analysis import percentile
from .asking import Asker, start
from .bridging import ROSPY, TO_ROS1, TO_ROS2, bridge
from .context import Bench, Figures
from .observers import wait_until
from .stacks import RCLPY

#: Which ROS has the client, and which the server.
_ENDS: Dict[str, Tuple[str, str]] = {
    ROSPY: ("1", "1"),
    RCLPY: ("2", "2"),
    TO_ROS2: ("1", "2"),
    TO_ROS1: ("2", "1"),
}
#: How long a goal takes, s: there is feedback twenty times a second.
_LASTS = 0.2
#: Goals whose figures do not count, as connections settle.
_FIRST = 3
#: longest wait for the end of a goal, s
_ENDED_WITHIN = 20.0

_numbers = itertools.count(1)


def measure(bench: Bench, subject: str) -> Figures:
    """Send goals one after the other, and tell how long the answers and the feedback took."""
    client, server = _ENDS[subject]
    name, goals = f"/measured{next(_numbers)}", int(bench.seconds(40.0, 10.0))
    with contextlib.ExitStack() as stack:
        serving = start(bench.session, "server", server, name)
        stack.callback(bench.session.stop, serving)
        if subject in (TO_ROS2, TO_ROS1):
            stack.enter_context(bridge(bench.session))
        asker = Asker(bench.session, client, name)
        stack.callback(asker.close)
        asker.wait_for_server()
        for number in range(_FIRST + goals):
            if number == _FIRST:
                asker.feedback.clear()
                asker.accepted.clear()
            key = f"goal{number}"
            asker.send(key, _LASTS)
            wait_until(lambda: bool(asker.ends[key]), _ENDED_WITHIN, f"end of {key}")
            if asker.ends[key] != [["SUCCEEDED", key]]:
                raise ValueError(f"{key} ended as {asker.ends[key]}")
    figures: Figures = {}
    for what, took in (("accept", list(asker.accepted.values())), ("feedback", asker.feedback)):
        figures[f"{what}_p50_us"] = percentile(took, 0.5)
        figures[f"{what}_p99_us"] = percentile(took, 0.99)
    figures["lost"] = float(_FIRST + goals - len(asker.ends))
    return figures
