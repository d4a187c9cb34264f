"""The goals, and whether the results reach them."""

import enum
from typing import NamedTuple, Optional, Tuple

from . import boards
from .analysis import Estimate
from .bridge import TO_ROS1, TO_ROS2
from .images import NODEKIT, Case
from .loop import LOOP
from .results import Results
from .robots import HOSTED, PAIR
from .stacks import COURSE, OURS, RCLPY, ROSCPP, ROSPY


class Outcome(enum.Enum):
    """Whether a goal is reached: decided only if the whole interval lies on one side of it."""

    PASS = "pass"
    SHORT = "SHORT"
    UNCLEAR = "unclear"


class Goal(NamedTuple):
    """An upper limit for a figure, or for its ratio to the sum of the peers' figures."""

    measurement: str
    what: str
    figure: str
    limit: float
    unit: str
    subject: str = OURS
    peers: Tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The goal in words."""
        return f"<= {number(self.limit)} {'x' if self.peers else self.unit}".rstrip()

    def estimate(self, results: Results) -> Optional[Estimate]:
        """Return the limited value; None if it was not measured."""
        try:
            return results.estimate(self.measurement, self.subject, self.figure, self.peers)
        except LookupError:
            return None

    def outcome(self, value: Estimate) -> Outcome:
        """Compare a value with the limit."""
        if value.high <= self.limit:
            return Outcome.PASS
        return Outcome.UNCLEAR if value.low <= self.limit else Outcome.SHORT


def number(value: float) -> str:
    """Return a number with its significant digits."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


BOTH = (ROSPY, RCLPY)


def _images(
    what: str, size: str, subscribers: int, figure: str, limit: float, peer: str = ROSPY
) -> Goal:
    """Return a goal of large messages, against a peer."""
    ours, theirs = (Case(stack, size, subscribers).name for stack in (NODEKIT, peer))
    text = f"{what}, {size} to {subscribers}, against {peer}"
    return Goal("images", text, figure, limit, "", ours, (theirs,))


GOALS = [
    Goal("latency-1khz", "p50, against roscpp", "p50_us", 0.75, "us", peers=(ROSCPP,)),
    Goal("latency-1khz", "p99, against roscpp", "p99_us", 1.0, "us", peers=(ROSCPP,)),
    Goal("latency-1khz", "p50, against rclpy", "p50_us", 0.25, "us", peers=(RCLPY,)),
    Goal("latency-100hz", "p50, against roscpp", "p50_us", 1.0, "us", peers=(ROSCPP,)),
    Goal(
        "launch", "first answer, against the course's", "first_answer_s", 0.8, "s", OURS, (COURSE,)
    ),
    Goal("memory", "a node, against a bare one", "resident_mb", 1.02, "MB", peers=("bare_node",)),
    Goal("parameters", "set to effect, median", "median_ms", 100.0, "ms"),
    Goal("parameters", "set to effect, longest", "longest_ms", 1500.0, "ms"),
    Goal("parameters", "wrong value after 200 sets", "wrong_after_burst", 0.0, ""),
    Goal("loop", "CPU, against generator and process", "cpu_percent", 1.15, "%", LOOP, (OURS,)),
    Goal("loop", "p50, against generator and process", "p50_us", 1.1, "us", LOOP, (OURS,)),
    Goal("robot", "CPU in one process", "cpu_percent", 2.5, "%", HOSTED),
    Goal("robot", "CPU in two processes", "cpu_percent", 2.5, "%", PAIR),
    Goal("executor", "one thread, against rclpy", "single_us", 0.1, "us", peers=(RCLPY,)),
    Goal("executor", "two threads, against rclpy", "multi_us", 0.1, "us", peers=(RCLPY,)),
    Goal("executor", "to an idle thread", "delay_us", 100.0, "us"),
    Goal("overlap", "scenarios that differ", "differ", 0.0, ""),
    Goal("overlap", "scenarios that differ, rclpy", "differ", 0.0, "", RCLPY),
    Goal("lifecycle", "cases that differ from rclpy", "differ", 0.0, "", RCLPY),
    *(
        goal
        for way, to, cpu in ((TO_ROS2, "to ROS 2", 15.0), (TO_ROS1, "to ROS 1", 20.0))
        for goal in (
            Goal("bridge", f"p50 {to}, against a hop of each", "p50_us", 1.0, "us", way, BOTH),
            Goal("bridge", f"CPU at 1 kHz {to}", "cpu_percent", cpu, "%", way),
            Goal("bridge", f"memory {to}", "resident_mb", 110.0, "MB", way),
            Goal("bridge-load", f"lost of 4000/s {to}", "fast_lost", 0.0, "", way),
            Goal("bridge-load", f"lost of 100 topics {to}", "many_lost", 0.0, "", way),
            Goal("bridge-load", f"CPU of 100 topics {to}", "many_cpu_percent", 90.0, "%", way),
        )
    ),
    *(
        Goal("serial", what, figure, limit, unit, boards.OURS, peers)
        for what, figure, limit, unit, peers in (
            ("round trip", "p50_ms", 1.0, "ms", ()),
            ("round trip, against rosserial_python", "p50_ms", 0.15, "ms", (boards.ROSSERIAL,)),
            ("lost of 1 kHz by TCP", "tcp_lost", 0.0, "", ()),
            ("CPU while idle", "idle_cpu_percent", 1.0, "%", ()),
            ("CPU at 100 Hz both ways", "cpu_percent", 4.0, "%", ()),
        )
    ),
    *(
        Goal("bridge-actions", f"{what} {to}, against both ROSes", figure, 1.0, "us", way, BOTH)
        for way, to in ((TO_ROS2, "to ROS 2"), (TO_ROS1, "to ROS 1"))
        for what, figure in (("acceptance", "accept_p50_us"), ("feedback", "feedback_p50_us"))
    ),
    *(
        goal
        for size in ("6.2 MB", "300 000 points")
        for goal in (
            _images("p50", size, 1, "p50_ms", 0.35),
            _images("CPU", size, 1, "cpu_percent", 0.6),
            _images("CPU", size, 3, "cpu_percent", 0.35),
            _images("p50", size, 1, "p50_ms", 1.0, ROSCPP),
        )
    ),
]
