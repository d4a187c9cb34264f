"""Processor time of a simulated robot and its controller, in one process and in two."""

import contextlib
import time
from typing import Callable, Iterator

from .context import Bench, Figures
from .cost import cpu_share
from .peer_programs import executable
from .processes import paused, resumed

HOSTED, PAIR = "in one process", "in two processes"
MEMBERS = [
    "diff_drive_sim.nodes.diff_drive:DiffDrive",
    "bot_controller_demo.nodes.proportional_controller:ProportionalController",
]
COMMANDS = {
    HOSTED: [executable("nodekit", "host", *MEMBERS)],
    PAIR: [
        executable("diff_drive_sim", "diff_drive"),
        executable("bot_controller_demo", "proportional_controller"),
    ],
}
#: Time for both to continue driving, and length of a turn [s].
SETTLE_S, TURN_S = 0.5, 1.5


@contextlib.contextmanager
def prepare(bench: Bench, subject: str) -> Iterator[Callable[[], Figures]]:
    """Drive a robot at 30 Hz towards a goal that it does not reach during the measurement."""
    session, group = bench.session, "/hosted" if subject == HOSTED else "/pair"
    session.master.setParam(group + "/proportional_controller/goal_x", 1000.0)
    with session.up(*COMMANDS[subject], environment=session.in_group(group)) as pids:
        # No subscribers from outside during the turns.
        with session.record(group + "/odom", "nav_msgs/Odometry") as odometry:
            with session.record(group + "/cmd_vel", "geometry_msgs/Twist") as commands:
                odometry.wait()
                commands.wait()

        def take_turn() -> Figures:
            with resumed(pids):
                time.sleep(SETTLE_S)
                return {"cpu_percent": cpu_share(pids, TURN_S)}

        with paused(pids):
            yield take_turn
