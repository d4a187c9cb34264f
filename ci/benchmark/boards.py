"""Messages of a board through serial_link's node, rosserial_python's, and a bare one.

rosserial_python is in no archive of packages: ROSSERIAL names a folder with its sources.
"""

import json
import os
import pathlib
import struct
import sys
import time
from typing import Dict, List, Tuple

import genpy.generate_initpy
import genpy.generator
import numpy as np
from nodekit.testing.processes import free_port

from .context import Bench, Figures
from .cost import cpu_share
from .peer_programs import WORKSPACE, executable, peer
from .recorder import wait_until

OURS, ROSSERIAL, BARE = "serial_link", "rosserial_python", "bare node"
FOLDER = os.environ.get("ROSSERIAL", "")
#: Generated messages of rosserial.
GENERATED = WORKSPACE / "build" / "benchmark" / "rosserial"
#: Rates of the pings through a serial port and a TCP connection [Hz], and their duration [s].
RATE, TCP_RATE, PING_S = 100.0, 1000.0, 6.0
#: Time after the start in which a host settles, and duration of the idle measurement [s].
SETTLE_S, IDLE_S = 3.0, 6.0
#: Share of damaged bytes, its duration [s], rate of the numbers [Hz], and bytes of their frames.
NOISE, NOISE_S, NUMBERS_HZ, FRAME = 0.05, 20.0, 500.0, 12
LIMIT_S = 40.0
#: Factor of a number for its check value, as in peers/serial_board.py.
CHECK = 40503
_VALUE = struct.Struct("<I")


def prepare() -> Dict[str, str]:
    """Generate rosserial's messages.

    :returns: the reason for omitting rosserial_python, by its name
    """
    root = pathlib.Path(FOLDER)
    missing = "rosserial_python/nodes/serial_node.py", "rosserial_msgs/msg/TopicInfo.msg"
    if not FOLDER:
        return {ROSSERIAL: "ROSSERIAL has to name a clone of ros-drivers/rosserial"}
    for name in missing:
        if not (root / name).is_file():
            return {ROSSERIAL: f"ROSSERIAL={FOLDER} has no {name}"}
    package = GENERATED / "rosserial_msgs"
    for kind, generator in (
        ("msg", genpy.generator.MsgGenerator),
        ("srv", genpy.generator.SrvGenerator),
    ):
        files = [str(path) for path in sorted((root / "rosserial_msgs" / kind).glob(f"*.{kind}"))]
        generator().generate_messages("rosserial_msgs", files, str(package / kind), {})
        genpy.generate_initpy.write_modules(str(package / kind))
    (package / "__init__.py").touch()
    return {}


def measure(bench: Bench, subject: str) -> Figures:
    """Measure a board at a serial port, one at a TCP connection, and one behind a bad cable."""
    figures = _measure_port(bench, subject)
    if subject == BARE:
        return figures
    figures.update(_measure_tcp(bench, subject))
    figures["wrong_of_10000"] = _measure_noise(bench, subject)
    return figures


def host(bench: Bench, subject: str, *words: str) -> Tuple[List[str], Dict[str, str]]:
    """Return the command and the environment of a host."""
    if subject == BARE:
        return peer("serial_bare.py", *words), bench.session.environment
    arguments = [*words, "_baud:=1000000"]
    environment = dict(bench.session.environment)
    if subject == OURS:
        return executable("serial_link", "serial_node.py", *arguments), environment
    root = pathlib.Path(FOLDER) / "rosserial_python"
    places = [str(root / "src"), str(GENERATED), environment["PYTHONPATH"]]
    environment["PYTHONPATH"] = os.pathsep.join(places)
    return [sys.executable, str(root / "nodes" / "serial_node.py"), *arguments], environment


def _measure_port(bench: Bench, subject: str) -> Figures:
    session, link = bench.session, str(bench.session.directory / "board")
    command, environment = host(bench, subject, link)
    with session.up(peer("serial_board.py", link)):
        wait_until(lambda: os.path.islink(link), LIMIT_S, "port of the board")
        with session.up(command, environment=environment) as pids:
            _wait_for_topic(bench, "/pong")
            time.sleep(SETTLE_S)
            idle = cpu_share(pids, bench.seconds(IDLE_S, 1.0))
            took, cpu = _ping(bench, RATE, pids)
    p50, p99 = map(float, np.percentile(took, [50.0, 99.0]))
    return {"p50_ms": p50, "p99_ms": p99, "idle_cpu_percent": idle, "cpu_percent": cpu}


def _measure_tcp(bench: Bench, subject: str) -> Figures:
    number = free_port()
    command, environment = host(bench, subject, "tcp", str(number))
    with bench.session.up(command, environment=environment) as pids:
        with bench.session.up(peer("serial_board.py", str(number))):
            _wait_for_topic(bench, "/pong")
            time.sleep(SETTLE_S)
            took, _ = _ping(bench, TCP_RATE, pids)
    lost = int(TCP_RATE * bench.seconds(PING_S, 1.0)) - len(took)
    return {"tcp_p50_ms": float(np.median(took)), "tcp_lost": float(lost)}


def _measure_noise(bench: Bench, subject: str) -> float:
    """Return the number of wrong values of 10 000 damaged frames."""
    session, link = bench.session, str(bench.session.directory / "board")
    command, environment = host(bench, subject, link)
    seconds = bench.seconds(NOISE_S, 2.0)
    with session.record("/number", "std_msgs/UInt32") as recorder:
        with session.up(peer("serial_board.py", link, str(NOISE))):
            wait_until(lambda: os.path.islink(link), LIMIT_S, "port of the board")
            with session.up(command, environment=environment):
                wait_until(lambda: recorder.messages, LIMIT_S, "number from the board")
                time.sleep(1.0 + seconds)
    values = [_VALUE.unpack(message)[0] for _, message in recorder.messages]
    wrong = sum((value >> 16) * CHECK & 0xFFFF != value & 0xFFFF for value in values)
    damaged = NUMBERS_HZ * seconds * (1.0 - (1.0 - NOISE) ** FRAME)
    return 1e4 * wrong / damaged


def _ping(bench: Bench, rate: float, pids: List[int]) -> Tuple[List[float], float]:
    """Return the times of all answered pings [ms], and the processor time of processes [%]."""
    seconds = bench.seconds(PING_S, 1.0)
    file = bench.session.directory / "answers"
    file.unlink(missing_ok=True)
    with bench.session.up(peer("serial_ping.py", str(file), f"{rate:g}", f"{rate * seconds:.0f}")):
        _wait_for_topic(bench, "/ping")
        time.sleep(1.0)  # the first answer
        cpu = cpu_share(pids, 0.7 * seconds)
        wait_until(file.exists, LIMIT_S + seconds, "answers of the board")
    return [1e3 * took for _, took in json.loads(file.read_text("utf-8"))], cpu


def _wait_for_topic(bench: Bench, topic: str) -> None:
    topics = bench.session.master.getPublishedTopics
    wait_until(lambda: topic in str(topics("")), LIMIT_S, f"publisher of {topic}")
