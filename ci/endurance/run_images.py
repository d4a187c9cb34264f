"""Large messages through shared memory for long, while other subscribers are killed.

A camera sends pictures of 6.2 MB at 30 Hz, another of 0.3 MB at 500 Hz: in ten minutes as many as
the first in three hours. Viewers with and without views check each picture. A third viewer of each
camera is killed and started again and again.
"""

import json
import os
import pathlib
import signal
import sys
import time
from typing import List

from ..benchmark.recorder import wait_until
from .checks import Check, at_least, at_most
from .context import Soak
from .usage import Sampler, not_grown

NODE = [sys.executable, str(pathlib.Path(__file__).with_name("image_node.py"))]
#: Rate [Hz] and size [bytes] of each camera, by its namespace.
CAMERAS = {"/large": (30, 6_220_800), "/fast": (500, 307_200)}
#: Longest time to warm up, and between two kills [s].
WARM_UP, PERIOD = 30.0, 5.0
#: Time in which a camera gives back unused memory [s].
IDLE = 30.0


def run(soak: Soak) -> List[Check]:
    """Send for the given time."""
    session = soak.session
    cameras, viewers, doomed, summaries = {}, {}, [], {}
    for group, (rate, size) in CAMERAS.items():
        environment = session.in_group(group)
        cameras[group] = session.start([*NODE, "camera", str(rate), str(size)], environment)
        for kind in ("copy", "view"):
            name = f"{group[1:]} {kind}"
            summaries[name] = session.directory / f"{name}.json"
            command = [*NODE, "viewer", kind, str(summaries[name]), f"__name:={kind}"]
            viewers[name] = session.start(command, environment)
        command = [*NODE, "viewer", "view", "/dev/null", "__name:=doomed"]
        doomed.append((command, environment))
    pids = {"camera " + name: one.pid for name, one in cameras.items()}
    pids.update(("viewer " + name, one.pid) for name, one in viewers.items())
    time.sleep(min(WARM_UP, 0.2 * soak.seconds))
    until, kills = time.monotonic() + soak.seconds, 0
    with Sampler(pids) as sampler:
        while time.monotonic() < until:
            victims = [session.start(*one) for one in doomed]
            time.sleep(min(PERIOD, soak.seconds))
            for victim in victims:
                os.killpg(victim.pid, signal.SIGKILL)
                kills += 1
            session.stop(*victims)
    session.stop(*viewers.values())
    checks = [at_least("killed viewers", kills, 2)]
    for name, file in summaries.items():
        summary, rate = json.loads(file.read_text()), CAMERAS["/" + name.split()[0]][0]
        least = 0.9 * rate * soak.seconds
        checks += [
            at_least(f"received, {name}", summary["received"], least),
            at_most("missing", summary["missing"], 0),
            at_most("torn", summary["torn"], 0),
        ]
    for name, seen in sampler.samples.items():
        # The least: how many pictures wait varies, and two are more than the limit.
        checks += not_grown(name, seen, typical=min)
    pid_of = {name: one.pid for name, one in cameras.items()}
    wait_until(lambda: not any(map(segments, pid_of.values())), IDLE, "no segment of a camera")
    return checks


def segments(pid: int) -> int:
    """Return the number of segments that a process has open."""
    links = [os.readlink(link) for link in pathlib.Path(f"/proc/{pid}/fd").iterdir()]
    return sum("memfd:nodekit" in link for link in links)
