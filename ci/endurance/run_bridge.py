"""The bridge to ROS 2 at 1 kHz, each way for half of the time; then it and both sides are killed.

What is sent at 1 kHz has to arrive, and the bridge may not grow meanwhile, while goals of actions
run both ways. Then a talker of ROS 1 is heard by a node of ROS 2, which repeats it for ROS 1: the
talker, the bridge and that node are killed in turn, and started again at once. So are the servers
of actions.
"""

import json
import subprocess
import time
from typing import Any, Callable, Dict, List

from ..benchmark.bridging import BRIDGE, LIMIT, TO_ROS1, TO_ROS2, bridge, ends
from ..benchmark.observers import wait_until
from ..benchmark.peer_programs import DOMAIN, RCLPY, SCRIPTS, make_rclpy, rclpy_environment
from . import run_goals
from .checks import Check, at_most, none_of, reported
from .streams import Arrivals
from .surroundings import EXECUTABLES, Soak, logs
from .usage import Sampler, added, growth
from .watching import TEXT, Watch

RATE = 1000.0
TIMES = 20
#: longest time until messages are back after whoever was killed has been started again, s
BACK_WITHIN = 10.0
#: how long what is under way from one who was killed may take, s
UNDER_WAY = 0.5
#: longest time that everything is left to warm up, s
WARM_UP = 30.0
#: by how much the bridge's memory may grow, %
GROWTH = 1.0


def run(soak: Soak) -> List[Check]:
    """Send for as long as was asked for, then kill."""
    reason = make_rclpy()
    if reason:
        return [Check("the environment with ROS 2", "is there", reason, False)]
    checks: List[Check] = []
    with bridge(soak.session) as pid, run_goals.at_random(soak, checks):
        for way in (TO_ROS2, TO_ROS1):
            checks += sent(soak, way, pid)
    checks += killed(soak)
    checks += run_goals.among_kills(soak, soak.times or TIMES)
    # Where somebody is killed in the middle of a request, the master's own log has a traceback.
    others = [text for text in logs(soak.session.directory) if "[rosmaster.main]" not in text]
    found = [error for text in others for error in raised(text)]
    return [*checks, none_of("exceptions", found)]


def raised(log: str) -> List[str]:
    """Return the last line of each traceback in a log; not of those that rospy itself survives."""
    lines = log.splitlines()
    found = []
    for number, line in enumerate(lines):
        if "Traceback" in line and "[rospy.internal][WARNING]" not in line:
            rest = (one for one in lines[number + 1 :] if not one.startswith(" "))
            found.append(next(rest, line))
    return found


def sent(soak: Soak, way: str, pid: int) -> List[Check]:
    """Send one way, and look what arrives and what the bridge takes for it."""
    file = soak.session.directory / way
    seconds = 0.5 * soak.seconds
    with ends(soak.session, way, file, RATE, seconds, 1):
        wait_until(file.with_suffix(".first").exists, LIMIT, "the first message")
        time.sleep(min(WARM_UP, 0.2 * seconds))
        with Sampler({"bridge": pid}) as sampler:
            wait_until(file.exists, seconds + LIMIT, "the last message")
    heard: Any = json.loads(file.read_text("utf-8"))
    took = sorted(heard["took"])
    seen = sampler.samples["bridge"]
    memory = [one.memory for one in seen]
    return [
        reported(f"{way}: messages", str(len(took))),
        at_most("lost", heard["lost"], 0),
        reported("of these dropped, as ROS 2 tells whoever hears", str(heard["dropped"])),
        reported("took", f"{took[len(took) // 2]:.0f} us, at most {took[-1] / 1000.0:.1f} ms"),
        reported(
            "memory of the bridge",
            f"{memory[0] / 1024.0:.1f} MB, then {memory[-1] / 1024.0:.1f} MB",
        ),
        at_most("its growth", round(100.0 * growth(memory), 2), GROWTH, "%"),
        at_most("its new threads", added([one.threads for one in seen]), 0),
        at_most("its new descriptors", added([one.descriptors for one in seen]), 0),
    ]


def killed(soak: Soak) -> List[Check]:
    """Kill the bridge and both sides in turn, so many times each."""
    session = soak.session
    echo = str(SCRIPTS / "bridge" / "echo.py")
    on_domain = dict(session.environment, ROS_DOMAIN_ID=DOMAIN)
    start: Dict[str, Callable[[], "subprocess.Popen[bytes]"]] = {
        "the talker of ROS 1": lambda: session.start([str(EXECUTABLES / "talker.py")]),
        "the node of ROS 2": lambda: session.start([str(RCLPY), echo], rclpy_environment()),
        "the bridge": lambda: session.start([str(BRIDGE)], on_domain),
    }
    running = {name: begin() for name, begin in start.items()}
    took: Dict[str, List[float]] = {name: [] for name in start}
    wrong: List[str] = []
    with session.node() as node:
        watch = Watch(node, "/heard", TEXT)
        wait_until(lambda: watch.arrivals.count > 0, LIMIT, "the first message")
        for _ in range(soak.times or TIMES):
            for name, begin in start.items():
                running[name].kill()
                running[name].wait()
                time.sleep(UNDER_WAY)
                watch.arrivals = Arrivals()
                began = time.monotonic()
                running[name] = begin()
                wait_until(lambda: watch.arrivals.count > 0, 2.0 * LIMIT, f"/heard after {name}")
                took[name].append(time.monotonic() - began)
                gone = [one for one, process in running.items() if process.poll() is not None]
                wrong += [f"{one} has ended, too" for one in gone]
    session.stop(*running.values())
    return [
        *(
            at_most(
                f"{name} killed {len(of_one)} times: back within",
                round(max(of_one), 2),
                BACK_WITHIN,
                "s",
            )
            for name, of_one in took.items()
        ),
        none_of("others that ended", wrong),
    ]
