"""The bridge to ROS 2 at 1 kHz, each way for half of the time; then it and both sides are killed.

What is sent at 1 kHz has to arrive, and the bridge may not grow meanwhile, while goals of actions
run both ways. Then a talker of ROS 1 is heard by a node of ROS 2, which repeats it for ROS 1: the
talker, the bridge and that node are killed in turn, and restarted at once. So are the servers of
actions.
"""

import json
import subprocess
import time
from typing import Any, Callable, Dict, List

from ..benchmark.bridge import LIMIT, TO_ROS1, TO_ROS2, bridge_command, run_bridge, run_ends
from ..benchmark.peer_programs import RCLPY, SCRIPTS, make_rclpy, rclpy_environment
from ..benchmark.recorder import wait_until
from . import run_goals
from .checks import Check, at_most, none_of, reported
from .context import Soak
from .usage import Sampler, not_grown
from .watching import TEXT, Watch

RATE = 1000.0
TIMES = 20
#: Longest time until messages are back after the restart of a killed process [s].
BACK_WITHIN = 10.0
#: Time for what a killed process has sent to arrive [s].
ON_THE_WAY = 0.5
#: Longest time to warm up [s].
WARM_UP = 30.0


def run(soak: Soak) -> List[Check]:
    """Send for the given time, then kill."""
    reason = make_rclpy()
    if reason:
        return [Check("the environment with ROS 2", "is there", reason, False)]
    checks: List[Check] = []
    with run_bridge(soak.session) as pid, run_goals.at_random(soak, checks):
        for way in (TO_ROS2, TO_ROS1):
            checks += send(soak, way, pid)
    checks += kill(soak)
    checks += run_goals.among_kills(soak, soak.times or TIMES)
    # If a process is killed in the middle of a request, the master's own log has a traceback.
    logs = [text for text in soak.session.logs() if "[rosmaster.main]" not in text]
    return [*checks, none_of("exceptions", [error for text in logs for error in raised(text)])]


def raised(log: str) -> List[str]:
    """Return the last line of each traceback in a log, except those that rospy itself survives."""
    lines = log.splitlines()
    found = []
    for number, line in enumerate(lines):
        if "Traceback" in line and "[rospy.internal][WARNING]" not in line:
            rest = (one for one in lines[number + 1 :] if not one.startswith(" "))
            found.append(next(rest, line))
    return found


def send(soak: Soak, way: str, pid: int) -> List[Check]:
    """Send one way, and check what arrives and what the bridge takes for it."""
    file, seconds = soak.session.directory / way, 0.5 * soak.seconds
    with run_ends(soak.session, way, file, RATE, seconds, 1):
        wait_until(file.with_suffix(".first").exists, LIMIT, "the first message")
        time.sleep(min(WARM_UP, 0.2 * seconds))
        with Sampler({"bridge": pid}) as sampler:
            wait_until(file.exists, seconds + LIMIT, "the last message")
    received: Any = json.loads(file.read_text("utf-8"))
    took = sorted(received["took"])
    return [
        reported(f"{way}: messages", str(len(took))),
        at_most("lost", received["lost"], 0),
        reported("took", f"{took[len(took) // 2]:.0f} us, at most {took[-1] / 1000.0:.1f} ms"),
        *not_grown("the bridge", sampler.samples["bridge"]),
    ]


def kill(soak: Soak) -> List[Check]:
    """Kill the bridge and both sides in turn."""
    session = soak.session
    bridge, variables = bridge_command()
    echo = [str(RCLPY), str(SCRIPTS / "bridge" / "echo.py")]
    start: Dict[str, Callable[[], "subprocess.Popen[bytes]"]] = {
        "the talker of ROS 1": lambda: soak.start("talker.py"),
        "the node of ROS 2": lambda: session.start(echo, rclpy_environment()),
        "the bridge": lambda: session.start(bridge, {**session.environment, **variables}),
    }
    running = {name: begin() for name, begin in start.items()}
    took: Dict[str, List[float]] = {name: [] for name in start}
    wrong: List[str] = []
    with session.node() as node:
        watch = Watch(node, "/heard", TEXT)
        wait_until(lambda: watch.arrivals.count, LIMIT, "the first message")
        for _ in range(soak.times or TIMES):
            for name, begin in start.items():
                running[name].kill()
                running[name].wait()
                time.sleep(ON_THE_WAY)
                watch.restart()
                began = time.monotonic()
                running[name] = begin()
                wait_until(lambda: watch.arrivals.count, 2.0 * LIMIT, f"/heard after {name}")
                took[name].append(time.monotonic() - began)
                gone = [one for one, process in running.items() if process.poll() is not None]
                wrong += [f"{one} has ended, too" for one in gone]
    session.stop(*running.values())
    checks = [
        at_most(f"{name} killed {len(times)} times: back within", max(times), BACK_WITHIN, "s")
        for name, times in took.items()
    ]
    return [*checks, none_of("others that ended", wrong)]
