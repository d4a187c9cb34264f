"""What simulated robots cost: a hundred, one that scans or is driven, and how soon one is up."""

import time
from typing import List

import stacks
from context import Bench, Figures
from cost import cpu_share, resident_memory
from observers import Recorder

FLEET, SCAN = "100 robots", "a robot that scans"
HOSTED, PAIR = "a robot and its controller", "the same in two processes"
START = "start of a robot"
SUBJECTS = [SCAN, HOSTED, PAIR, START]

COUNT = 100
ODOMETRY, JOINTS, RANGES = "nav_msgs/Odometry", "sensor_msgs/JointState", "sensor_msgs/LaserScan"
COMMANDS = "geometry_msgs/Twist"
#: A square of 6 m and a wall within it.
WALLS = "[[3,-3,3,3],[3,3,-3,3],[-3,3,-3,-3],[-3,-3,3,-3],[1,1,2,1.5]]"
#: How long a robot and its controller are watched, s: on a virtual machine the same two processes
#: take twice as much of the processor in some spells of up to a minute as in others.
PAIR_S = 30.0


def measure(bench: Bench, subject: str) -> Figures:
    """Measure one of SUBJECTS, or FLEET."""
    measures = {FLEET: _fleet, SCAN: _scan, HOSTED: _hosted, PAIR: _pair, START: _start}
    return measures[subject](bench)


def _fleet(bench: Bench) -> Figures:
    seconds = 2.0 if bench.quick else 5.0
    with bench.session.node() as node, bench.session.running(
        _command("diff_drive_fleet", f"_count:={COUNT}")
    ) as pids:
        Recorder(node, f"/robot{COUNT}/odom", ODOMETRY).wait()
        time.sleep(2.0)  # until all of them have settled
        alone = cpu_share(pids, seconds)
        recorders = [
            Recorder(node, f"/robot{number}/{topic}", kind)
            for number in range(1, COUNT)
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
        # A window cuts off up to one message.
        return {
            "cpu_percent": alone,
            "cpu_observed_percent": heard,
            "lowest_hz": (min(counts) + 1) / (ended - began),
            "resident_mb": resident_memory(pids),
        }


def _scan(bench: Bench) -> Figures:
    with bench.session.node() as node, bench.session.running(
        _command("diff_drive", "_scan_rate:=10", f"_walls:={WALLS}")
    ) as pids:
        for topic, kind in (("/odom", ODOMETRY), ("/joint_states", JOINTS), ("/scan", RANGES)):
            Recorder(node, topic, kind).wait()
        time.sleep(1.0)
        return {"cpu_percent": cpu_share(pids, 3.0 if bench.quick else 10.0)}


def _hosted(bench: Bench) -> Figures:
    """Measure a robot at 30 Hz and its controller at 20 Hz in one process."""
    members = [
        "diff_drive_sim.nodes.diff_drive:DiffDrive",
        "bot_controller_demo.nodes.proportional_controller:ProportionalController",
    ]
    return _driving(bench, _command("host", *members, package="nodekit"))


def _pair(bench: Bench) -> Figures:
    """Measure the same in two processes."""
    controller = _command("proportional_controller", package="bot_controller_demo")
    return _driving(bench, _command("diff_drive"), controller)


def _driving(bench: Bench, *commands: List[str]) -> Figures:
    """Measure a robot on the way to where it never comes."""
    with bench.session.node() as node:
        node.master("setParam", "/proportional_controller/goal_x", 1000.0)
    with bench.session.running(*commands) as pids:
        with bench.session.node() as node:  # and nobody else is sent anything while it is measured
            for topic, kind in (("/odom", ODOMETRY), ("/cmd_vel", COMMANDS)):
                Recorder(node, topic, kind).wait()
        time.sleep(1.0)
        return {"cpu_percent": cpu_share(pids, 3.0 if bench.quick else PAIR_S)}


def _start(bench: Bench) -> Figures:
    """Measure from where roslaunch would start the process."""
    with bench.session.node() as node:
        recorder = Recorder(node, "/odom", ODOMETRY)
        began = time.monotonic()
        with bench.session.running(_command("diff_drive")):
            return {"first_odom_s": recorder.wait() - began}


def _command(executable: str, *arguments: str, package: str = "diff_drive_sim") -> List[str]:
    return [str(stacks.EXECUTABLES.parent / package / executable), *arguments]
