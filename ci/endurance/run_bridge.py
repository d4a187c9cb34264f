"""Bridge to ROS 2 at 1 kHz, then with images in simulated time; then it and both sides are killed.

Each direction has a quarter of the time. All messages at 1 kHz must arrive, and the bridge's memory
must not grow meanwhile. Goals of actions run in both directions, half of them cancelled at random
times; each must end once, with its own result and in a legal state. Then a ROS 2 node subscribes to
a ROS 1 talker, and republishes its messages for ROS 1.
"""

import contextlib
import json
import math
import pathlib
import random
import sys
import threading
import time
from typing import Any, Dict, Iterator, List

import rosgraph

from ..benchmark import images, record
from ..benchmark.action_client import ABORT, SUCCEED, ActionClient, start
from ..benchmark.bridge import (
    LIMIT,
    TO_ROS1,
    TO_ROS2,
    bridge_command,
    run_bridge,
    run_cameras,
    run_ends,
)
from ..benchmark.peer_programs import RCLPY, SCRIPTS, executable, make_rclpy, rclpy_environment
from ..benchmark.recorder import wait_until
from .checks import Check, at_most, none_of, reported
from .context import Soak
from .usage import Sampler, not_grown

RATE = 1000.0
#: Longest time to warm up [s].
WARM_UP = 30.0
#: Most kills of each process.
KILLS = 20
#: Longest time until messages arrive again after the restart of a killed process [s].
BACK_WITHIN = 10.0
#: Time for messages of a killed process to arrive [s].
ON_THE_WAY = 0.5
#: Most images that may be lost, of 6.2 MB at 30 Hz [%].
IMAGES_LOST = 1.0
#: Sizes of Linux's receive buffers [bytes], which decide how many images are lost: see
#: docs/ros2_bridge.md.
BUFFERS = [pathlib.Path("/proc/sys/net/core", name) for name in ("rmem_max", "rmem_default")]
#: Growth of the bridge's memory with images, as some wait at times [%].
IMAGES_GROWTH = 5.0
CLOCK = str(pathlib.Path(__file__).with_name("clock.py"))
#: Longest delay of the simulated time in ROS 2 [s], in 99 of 100 cases.
CLOCK_LATE = 0.5
#: Names of the actions, by their servers' ROS, and the other ROS.
NAMES = {"1": "/soak/arm", "2": "/soak/hand"}
OTHER = {"1": "2", "2": "1"}
#: Pause between two groups of goals [s], their size, and the longest duration of a goal [s].
PAUSE, GROUP, LONGEST = 10.0, 5, 4.0
#: Longest time that a goal may take in addition [s].
LATE = 10.0
#: Final states of a goal, and of a cancelled goal by its client's ROS.
_FINAL = {"SUCCEEDED", "ABORTED"}
_CANCELLED = {"1": _FINAL | {"PREEMPTED", "RECALLED"}, "2": _FINAL | {"CANCELED"}}


def run(soak: Soak) -> List[Check]:
    """Send for the given time, then kill."""
    reason = make_rclpy()
    if reason:
        return [Check("the environment with ROS 2", "exists", reason, False)]
    checks: List[Check] = []
    with run_bridge(soak.session) as pid, goals(soak, checks):
        for way in (TO_ROS2, TO_ROS1):
            checks += send(soak, way, pid)
    with simulated_time(soak, checks), run_bridge(soak.session) as pid, goals(soak, checks):
        for way in (TO_ROS2, TO_ROS1):
            checks += send_images(soak, way, pid)
    checks += kill(soak)
    # The log of the master has a traceback if a process is killed in the middle of a request, and
    # rospy's warnings may have one.
    logs = [text for text in soak.session.logs() if "[rosmaster.main]" not in text]
    lines = [line for text in logs for line in text.splitlines() if "Traceback" in line]
    return [*checks, none_of("exceptions", [one for one in lines if "[rospy.internal]" not in one])]


def send(soak: Soak, way: str, pid: int) -> List[Check]:
    """Send in one direction; check the received messages and the bridge's resources."""
    file, seconds = soak.session.directory / way, 0.25 * soak.seconds
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


def send_images(soak: Soak, way: str, pid: int) -> List[Check]:
    """Send images of 6.2 MB in one direction; check losses and the bridge's resources."""
    seconds = 0.25 * soak.seconds
    with run_cameras(soak.session, way) as files:
        time.sleep(min(WARM_UP, 0.2 * seconds))
        since = time.monotonic()
        with Sampler({"bridge": pid}) as sampler:
            time.sleep(seconds)
        until = time.monotonic()
        time.sleep(images.DRAIN_S)
    sent, received = map(record.read, files)
    due = {one.value for one in sent if since <= one.moment <= until}
    lost = due - {one.value for one in received}
    buffers = ", ".join(f"{file.name} {file.read_text().strip()}" for file in BUFFERS)
    return [
        reported(f"{way}: images", f"{len(due)}, with {buffers} bytes"),
        at_most("lost", 100.0 * len(lost) / len(due), IMAGES_LOST, "%"),
        *not_grown("the bridge", sampler.samples["bridge"], IMAGES_GROWTH, min),
    ]


@contextlib.contextmanager
def simulated_time(soak: Soak, checks: List[Check]) -> Iterator[None]:
    """Set ``/use_sim_time`` and publish ``/clock`` in ROS 1; a ROS 2 node compares its time.

    :param checks: receives the figures
    """
    session, summary = soak.session, soak.session.directory / "clock.json"
    master = rosgraph.Master("/soak", session.master_uri)
    master.setParam("/use_sim_time", True)
    source = session.start([sys.executable, CLOCK, "publish"])
    user = session.start([str(RCLPY), CLOCK, "use", str(summary)], rclpy_environment())
    try:
        yield
    finally:
        session.stop(user)
        session.stop(source)
        master.deleteParam("/use_sim_time")
    late = sorted(json.loads(summary.read_text()))
    usual = late[int(0.99 * len(late))] if late else math.inf  # no time has arrived
    checks.append(reported("simulated time in ROS 2 compared", f"{len(late)} times"))
    checks.append(at_most("late", usual, CLOCK_LATE, "s"))


def kill(soak: Soak) -> List[Check]:
    """Kill the bridge and both sides in turn, and restart each immediately."""
    session, times = soak.session, min(KILLS, soak.times)
    echo = [str(RCLPY), str(SCRIPTS / "bridge" / "echo.py")]
    start = {
        "the talker of ROS 1": (executable("basic_comms", "talker.py"), session.environment),
        "the node of ROS 2": (echo, rclpy_environment()),
        "the bridge": bridge_command(session),
    }
    running = {name: session.start(*command) for name, command in start.items()}
    took: Dict[str, List[float]] = {name: [] for name in start}
    wrong: List[str] = []
    with session.record("/heard", "std_msgs/String") as recorder:
        wait_until(lambda: recorder.messages, LIMIT, "the first message")
        for name in list(start) * times:
            running[name].kill()
            running[name].wait()
            time.sleep(ON_THE_WAY)
            recorder.messages.clear()
            began = time.monotonic()
            running[name] = session.start(*start[name])
            wait_until(lambda: recorder.messages, 2.0 * LIMIT, f"/heard after {name}")
            took[name].append(time.monotonic() - began)
            wrong += [one for one, process in running.items() if process.poll() is not None]
    session.stop(*running.values())
    what = f"killed {times} times: back within"
    checks = [at_most(f"{name} {what}", max(took[name]), BACK_WITHIN, "s") for name in start]
    return [*checks, none_of("others that ended", wrong)]


@contextlib.contextmanager
def goals(soak: Soak, checks: List[Check]) -> Iterator[None]:
    """Send goals in both directions during the context, from each ROS to the other's server.

    :param checks: receives the figures
    """
    ended = threading.Event()
    with contextlib.ExitStack() as stack:
        for ros, name in NAMES.items():
            stack.callback(soak.session.stop, start(soak.session, "server", ros, name))
        clients = [ActionClient(soak.session, ros, NAMES[OTHER[ros]]) for ros in NAMES]
        threads = []
        for client in clients:
            stack.callback(client.close)
            client.wait_for_server()
            arguments = (client, random.Random(soak.seed), ended)
            threads.append(threading.Thread(target=_send_goals, args=arguments))
        for thread in threads:
            thread.start()
            stack.callback(thread.join)
        stack.callback(ended.set)
        yield
        ended.set()
        for thread, client in zip(threads, clients):
            thread.join()
            with contextlib.suppress(TimeoutError):  # lost goals are reported below
                wait_until(lambda: len(client.ends) >= len(client.sent), LATE + LONGEST, "end")
            states = [ends[0][0] for ends in client.ends.values() if ends]
            counts = ", ".join(f"{states.count(one)} {one}" for one in sorted(set(states)))
            what = f"goals of ROS {client.ros} in the other"
            checks.append(reported(what, f"{len(client.sent)}: {counts}"))
            checks.append(none_of("lost, invented or mistaken", errors(client)))


def _send_goals(client: ActionClient, chance: random.Random, ended: threading.Event) -> None:
    while not ended.wait(PAUSE):
        keys = [f"goal{client.ros}-{len(client.sent) + number}" for number in range(GROUP)]
        for key in keys:
            outcome = chance.choice((SUCCEED, SUCCEED, ABORT))
            client.send(key, chance.uniform(0.0, LONGEST), outcome)
        for key in keys:
            if chance.random() < 0.5:
                time.sleep(chance.uniform(0.0, 0.5))
                client.cancel(key)


def errors(client: ActionClient) -> List[str]:
    """Return the errors in the goals of a client, which should all have ended."""
    found = list(client.strange)
    found += [f"{key} is lost" for key in client.sent if not client.ends[key]]
    invented = {*client.ends, *client.heard} - client.sent
    found += [f"{key} was never sent" for key in invented]
    for key, ends in client.ends.items():
        states = _CANCELLED[client.ros] if key in client.cancelled else _FINAL
        results = [key, "-"] if ends and ends[0][0] == "RECALLED" else [key]
        if ends and (len(ends) > 1 or ends[0][0] not in states or ends[0][1] not in results):
            found.append(f"{key} ended as {ends}")
    return found
