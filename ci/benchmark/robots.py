"""What simulated robots cost: a hundred, one that scans or is driven, and how soon one is up."""

import contextlib
import time
from typing import Callable, Iterator, List

from . import stacks
from .context import Bench, Figures
from .cost import cpu_share, resident_memory
from .observers import Recorder
from .pausing import going, standing

FLEET, SCAN = "100 robots", "a robot that scans"
HOSTED, PAIR = "a robot and its controller", "the same in two processes"
START = "start of a robot"

COUNT = 100
ODOMETRY, JOINTS, RANGES = "nav_msgs/Odometry", "sensor_msgs/JointState", "sensor_msgs/LaserScan"
COMMANDS = "geometry_msgs/Twist"
#: A square of 6 m and a wall within it.
WALLS = "[[3,-3,3,3],[3,3,-3,3],[-3,3,-3,-3],[-3,-3,3,-3],[1,1,2,1.5]]"
#: How long a robot and its controller are given to be on their way again, and are watched, s.
SETTLE_S, TURN_S = 0.5, 2.0
MEMBERS = [
    "diff_drive_sim.nodes.diff_drive:DiffDrive",
    "bot_controller_demo.nodes.proportional_controller:ProportionalController",
]


def measure(bench: Bench, subject: str) -> Figures:
    """Measure a hundred robots, one that scans, or a start."""
    return {FLEET: _fleet, SCAN: _scan, START: _start}[subject](bench)


def _fleet(bench: Bench) -> Figures:
    seconds = 2.0 if bench.quick else 5.0
    with bench.session.running(_command("diff_drive_fleet", f"_count:={COUNT}")) as pids:
        with bench.session.node() as node:
            Recorder(node, f"/robot{COUNT}/odom", ODOMETRY).wait()
        time.sleep(2.0)  # until all of them have settled
        alone = cpu_share(pids, seconds)
        with bench.session.node() as node:
            recorders = [
                Recorder(node, f"/robot{number}/{topic}", kind)
                for number in range(1, COUNT + 1)
                for topic, kind in (("odom", ODOMETRY), ("joint_states", JOINTS))
            ]
            for recorder in recorders:
                recorder.wait()
            began = time.monotonic()
            heard = cpu_share(pids, seconds)
            ended = time.monotonic()
        counts = [
            sum(began <= moment < ended for moment, _ in recorder.messages())
            for recorder in recorders
        ]
        return {
            "cpu_percent": alone,
            "cpu_observed_percent": heard,
            # A window cuts off up to one message, for which the goal has room.
            "lowest_hz": min(counts) / (ended - began),
            "resident_mb": resident_memory(pids),
        }


def _scan(bench: Bench) -> Figures:
    with bench.session.node() as node, bench.session.running(
        _command("diff_drive", "_scan_rate:=10", f"_walls:={WALLS}")
    ) as pids:
        for topic, kind in (("/odom", ODOMETRY), ("/joint_states", JOINTS), ("/scan", RANGES)):
            Recorder(node, topic, kind).wait()
        time.sleep(1.0)
        return {"cpu_percent": cpu_share(pids, bench.seconds(5.0, 3.0))}


@contextlib.contextmanager
def stand_ready(bench: Bench, subject: str) -> Iterator[Callable[[], Figures]]:
    """Have a robot at 30 Hz, on the way to where it never comes, and its controller stand ready."""
    if subject == HOSTED:
        commands = [_command("host", *MEMBERS, package="nodekit")]
    else:
        controller = _command("proportional_controller", package="bot_controller_demo")
        commands = [_command("diff_drive"), controller]
    session, group = bench.session, "/hosted" if subject == HOSTED else "/pair"
    with session.node() as node:
        node.master("setParam", group + "/proportional_controller/goal_x", 1000.0)
    with session.running(*commands, environment=session.in_group(group)) as pids:
        with session.node() as node:  # and nobody else is sent anything while it is measured
            for topic, kind in (("/odom", ODOMETRY), ("/cmd_vel", COMMANDS)):
                Recorder(node, group + topic, kind).wait()
        with standing(pids):
            yield lambda: _turn(pids)


def _turn(pids: List[int]) -> Figures:
    with going(pids):
        time.sleep(SETTLE_S)
        return {"cpu_percent": cpu_share(pids, TURN_S)}


def _start(bench: Bench) -> Figures:
    """Measure from where roslaunch would start the process."""
    with bench.session.node() as node:
        recorder = Recorder(node, "/odom", ODOMETRY)
        began = time.monotonic()
        with bench.session.running(_command("diff_drive")):
            return {"first_odom_s": recorder.wait() - began}


def _command(executable: str, *arguments: str, package: str = "diff_drive_sim") -> List[str]:
    return [str(stacks.EXECUTABLES.parent / package / executable), *arguments]
