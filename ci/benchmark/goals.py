"""The goals, and whether the results reach them."""

import enum
import statistics
from typing import Callable, List, NamedTuple, Optional, Tuple

from . import boards, bridging, robots, startup, timing, transitions
from .analysis import Interval, interval
from .floor import FLOOR
from .loop import LOOP
from .measurements import MEASUREMENTS
from .results import Results
from .stacks import COURSE, HOST, MANAGED, OURS, RCLPY, RCLPY_EVENTS, RELAY, ROSCPP

#: Least turns that say something, of a measurement that takes as many.
LEAST_TURNS = 3
_LEAST_TURNS_OF = {one.name: min(LEAST_TURNS, one.repeats) for one in MEASUREMENTS}
#: An interval is narrow whose width is this share of its value, or less.
NARROW = 0.05


class Outcome(enum.Enum):
    """Whether a goal is reached; only where the whole interval lies on one side of it."""

    PASS = "pass"
    SHORT = "SHORT"
    UNCLEAR = "unclear"
    NOT_MEASURABLE = "not measurable here"


class Verdict(NamedTuple):
    """What came of a goal."""

    #: what was measured, in words
    figure: str
    #: the value that the goal is about: a ratio to a peer, or the figure itself
    value: float
    #: where the value's median lies
    interval: Interval
    #: how many turns it comes from
    turns: int
    is_ratio: bool
    outcome: Outcome

    @property
    def is_settled(self) -> bool:
        """Whether more turns would say little more."""
        if self.turns < LEAST_TURNS:
            return False
        narrow = self.interval.high - self.interval.low <= NARROW * abs(self.value)
        return narrow or self.outcome in (Outcome.PASS, Outcome.SHORT)


class Goal(NamedTuple):
    """A limit for a value."""

    measurement: str
    what: str
    limit: float
    #: whether the value is to be the limit or less; or else the limit or more
    at_most: bool
    unit: str
    #: returns the figure in words and the value of each turn; raises LookupError where not measured
    read: Callable[[Results], Tuple[str, List[float]]]
    #: whose figures it takes
    subjects: Tuple[str, ...]

    @property
    def text(self) -> str:
        """The goal in words."""
        return f"{'<=' if self.at_most else '>='} {number(self.limit)}{self.unit}"

    def judge(self, results: Results) -> Optional[Verdict]:
        """Compare the results with the goal.

        :returns: None where something was not measured
        """
        try:
            figure, values = self.read(results)
        except LookupError:
            return None
        where = interval(values)
        outcome = self._outcome(where)
        if len(values) < _LEAST_TURNS_OF[self.measurement]:
            is_disturbed = results.disturbed[self.measurement]
            outcome = Outcome.NOT_MEASURABLE if is_disturbed else Outcome.UNCLEAR
        is_ratio = self.unit == " x"
        return Verdict(figure, statistics.median(values), where, len(values), is_ratio, outcome)

    def _outcome(self, where: Interval) -> Outcome:
        best, worst = where if self.at_most else where[::-1]
        if self._is_reached_by(worst):
            return Outcome.PASS
        return Outcome.UNCLEAR if self._is_reached_by(best) else Outcome.SHORT

    def _is_reached_by(self, value: float) -> bool:
        return value <= self.limit if self.at_most else value >= self.limit


def number(value: float) -> str:
    """Write a number with the digits that say something."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def _against(
    measurement: str,
    what: str,
    limit: float,
    figure: str,
    unit: str,
    subject: str,
    peer: str,
) -> Goal:
    def read(results: Results) -> Tuple[str, List[float]]:
        ours = results.median(measurement, subject, figure)
        theirs = results.median(measurement, peer, figure)
        return (
            f"{number(ours)} against {number(theirs)}{unit}",
            results.ratios(measurement, subject, peer, figure),
        )

    return Goal(measurement, f"{what}, against {peer}", limit, True, " x", read, (subject, peer))


def _times_better(
    measurement: str, what: str, limit: float, figure: str, unit: str, better: str, worse: str
) -> Goal:
    """Of a figure of which ``better`` has many times as much as ``worse``."""

    def read(results: Results) -> Tuple[str, List[float]]:
        more = results.median(measurement, better, figure)
        less = results.median(measurement, worse, figure)
        ours, theirs = (more, less) if better == OURS else (less, more)
        return (
            f"{number(ours)} against {number(theirs)}{unit}",
            results.ratios(measurement, better, worse, figure),
        )

    peer = worse if better == OURS else better
    return Goal(measurement, f"{what}, against {peer}", limit, False, " x", read, (better, worse))


def _itself(
    measurement: str,
    what: str,
    limit: float,
    figure: str,
    unit: str,
    subject: str = OURS,
    at_most: bool = True,
) -> Goal:
    def read(results: Results) -> Tuple[str, List[float]]:
        median = results.median(measurement, subject, figure)
        return number(median) + unit, results.values(measurement, subject, figure)

    return Goal(measurement, what, limit, at_most, unit, read, (subject,))


def _worst_memory(results: Results) -> Tuple[str, List[float]]:
    nodes = [startup.GENERATOR, startup.PROCESS]
    ours = max(results.median("memory", node, "resident_mb") for node in nodes)
    bare = results.median("memory", startup.BARE, "resident_mb")
    return f"{ours:.1f} against {bare:.1f} MB", [ours / bare]


def _drift(results: Results) -> Tuple[str, List[float]]:
    drifts = results.values("drift", OURS, "drift_ms")
    if not drifts:
        raise LookupError("drift was not measured")
    worst = max(abs(drift) for drift in drifts)
    return f"{worst:.3f} ms at worst", [worst]


def _bridged(
    way: str, measurement: str = "bridge", name: str = "p50_us"
) -> Callable[[Results], Tuple[str, List[float]]]:
    """Compare what goes through the bridge with one hop of each ROS."""

    def read(results: Results) -> Tuple[str, List[float]]:
        ours = results.median(measurement, way, name)
        hops = sum(results.median(measurement, ros, name) for ros in (bridging.ROSPY, RCLPY))
        return (
            f"{number(ours)} against {number(hops)} us",
            results.ratios_to_sum(measurement, way, (bridging.ROSPY, RCLPY), name),
        )

    return read


def _bridge(way: str, to: str, cpu: float) -> List[Goal]:
    """The goals of the bridge one way."""
    peers = f"p50 to {to}, against a hop of each"
    return [
        Goal("bridge", peers, 1.0, True, " x", _bridged(way), (way, bridging.ROSPY, RCLPY)),
        _itself("bridge", f"CPU at 1 kHz to {to}", cpu, "cpu_percent", " %", subject=way),
        _itself("bridge", f"memory, to {to}", 110.0, "resident_mb", " MB", subject=way),
        _itself("bridge-load", f"lost of 4000/s to {to}", 0.0, "lost", "", subject=way),
        _itself("bridge-load", f"CPU, 50 topics to {to}", 25.0, "fifty_cpu", " %", subject=way),
        _itself("bridge-many", f"lost of 100 topics to {to}", 0.0, "lost", "", subject=way),
        _itself("bridge-many", f"CPU, 100 topics to {to}", 90.0, "cpu_percent", " %", subject=way),
    ]


def _bridged_goals(way: str, to: str) -> List[Goal]:
    """The goals of the bridge with actions whose server is in one ROS, and client in the other."""
    name = "bridge-actions"
    return [
        Goal(
            name,
            f"p50 of {what} {to}, against both ROSes",
            1.0,
            True,
            " x",
            _bridged(way, name, f"{figure}_p50_us"),
            (way, bridging.ROSPY, RCLPY),
        )
        for what, figure in (("goal to accept", "accept"), ("feedback", "feedback"))
    ]


GOALS: List[Goal] = [
    _against("latency-1khz", "p50 at 1 kHz", 0.75, "p50_us", " us", OURS, ROSCPP),
    _against("latency-1khz", "p50 at 1 kHz", 0.85, "p50_us", " us", OURS, RELAY),
    _against("latency-100hz", "p50 at 100 Hz", 1.0, "p50_us", " us", OURS, ROSCPP),
    _against("latency-100hz", "p50 at 100 Hz", 1.0, "p50_us", " us", OURS, RELAY),
    _against("latency-1khz", "p99 at 1 kHz", 1.0, "p99_us", " us", OURS, ROSCPP),
    _against("latency-1khz", "p50 at 1 kHz", 0.25, "p50_us", " us", OURS, RCLPY),
    _against("latency-1khz", "p50 at 1 kHz", 0.5, "p50_us", " us", OURS, RCLPY_EVENTS),
    _times_better("latency-10hz", "faster at 10 Hz", 150.0, "p50_us", " us", COURSE, OURS),
    _itself("throughput", "rate without loss", 50000.0, "rate", " msg/s", at_most=False),
    _times_better("throughput", "rate without loss", 3.0, "rate", " msg/s", OURS, ROSCPP),
    Goal("drift", "drift in 20 s at 1 kHz", 0.1, True, " ms", _drift, (OURS,)),
    _against("period", "period p99 at 1 kHz", 1.0, "period_p99_us", " us", OURS, timing.LOOP),
    _against("latency-10hz", "CPU at 10 Hz", 0.1, "cpu_percent", " %", OURS, COURSE),
    _against("latency-1khz", "CPU at 1 kHz", 0.85, "cpu_percent", " %", OURS, ROSCPP),
    _against("latency-100hz", "CPU at 100 Hz", 1.0, "cpu_percent", " %", OURS, ROSCPP),
    _against("host-1khz", "CPU of one process at 1 kHz", 0.45, "cpu_percent", " %", HOST, ROSCPP),
    _against("latency-1khz", "CPU at 1 kHz", 1.35, "cpu_percent", " %", OURS, FLOOR),
    _against("launch", "roslaunch to answer", 0.8, "first_answer_s", " s", OURS, COURSE),
    Goal(
        "memory",
        "memory, against a bare node",
        1.02,
        True,
        " x",
        _worst_memory,
        (startup.GENERATOR, startup.PROCESS, startup.BARE),
    ),
    _itself("groups", "32 groups: all up", 3.0, "up_s", " s"),
    _itself("groups", "32 groups: CPU", 5.0, "cpu_percent", " %"),
    _itself("groups", "32 groups: memory", 200.0, "resident_mb", " MB"),
    _itself("thousand", "1000 groups: at 10 Hz", 1000.0, "holding", " groups", at_most=False),
    _itself("thousand", "1000 groups: CPU", 60.0, "cpu_percent", " %"),
    _itself("callback", "callback in a group that is free", 2.0, "group_us", " us"),
    _against("executor", "CPU of a call, one thread", 0.1, "single_us", " us", OURS, RCLPY),
    _against("executor", "CPU of a call, one thread", 0.5, "single_us", " us", OURS, RCLPY_EVENTS),
    _against("executor", "CPU of a call, two threads", 0.1, "multi_us", " us", OURS, RCLPY),
    _itself("executor", "to an idle thread of an executor", 100.0, "hop_us", " us"),
    _itself("overlap", "scenarios as they should be", 6.0, "agree", "", at_most=False),
    _itself("overlap", "the same, rclpy", 6.0, "agree", "", subject=RCLPY, at_most=False),
    _against("latency-1khz", "p50 at 1 kHz, managed", 1.05, "p50_us", " us", MANAGED, OURS),
    _itself("transition", "request to reply, median", 5.0, "p50_ms", " ms"),
    _itself(
        "lifecycle",
        "managed nodes as rclpy's",
        float(len(transitions.cases())),
        "agree",
        " cases",
        subject=RCLPY,
        at_most=False,
    ),
    _itself("fleet", "100 robots: CPU, observed", 30.0, "cpu_observed_percent", " %", robots.FLEET),
    _itself("fleet", "100 robots: rate", 29.0, "lowest_hz", " Hz", robots.FLEET, at_most=False),
    _itself("robot", "a robot that scans: CPU", 3.0, "cpu_percent", " %", robots.SCAN),
    _itself("robots", "a robot and its controller: CPU", 2.5, "cpu_percent", " %", robots.HOSTED),
    _itself("robots", "the same in two processes", 2.5, "cpu_percent", " %", robots.PAIR),
    _itself("robot", "start to first odom", 0.3, "first_odom_s", " s", robots.START),
    _itself("serial", "board's round trip, host's part", 500.0, "p50_us", " us", boards.ROUND_TRIP),
    _itself("serial", "lost to it at 90 %", 0.0, "lost_to_board", "", boards.CAPACITY),
    _itself("serial", "lost of it at 90 %", 0.0, "lost_from_board", "", boards.CAPACITY),
    _itself("serial", "CPU at 100 Hz both ways", 5.0, "cpu_percent", " %", boards.BUSY),
    _itself("serial", "CPU of an idle link", 0.5, "cpu_percent", " %", boards.IDLE),
    *_bridge(bridging.TO_ROS2, "ROS 2", 15.0),
    *_bridge(bridging.TO_ROS1, "ROS 1", 20.0),
    *_bridged_goals(bridging.TO_ROS2, "from ROS 2"),
    *_bridged_goals(bridging.TO_ROS1, "from ROS 1"),
    _against("bridge", "p50 to ROS 2", 1.35, "p50_us", " us", bridging.TO_ROS2, bridging.BARE),
    _itself("bridge-rest", "bridge, to its first message", 2.5, "first_s", " s", bridging.TO_ROS1),
    _itself("bridge-rest", "CPU of an idle bridge", 1.0, "cpu_percent", " %", bridging.TO_ROS1),
    _against("loop", "CPU of motor and controller", 1.15, "cpu_percent", " %", LOOP, OURS),
    _against("loop", "p50 from output to input", 1.1, "p50_us", " us", LOOP, OURS),
    _itself("live", "set to effect, median", 100.0, "median_ms", " ms"),
    _itself("live", "set to effect, longest", 1500.0, "longest_ms", " ms"),
    _itself("live", "200 sets end on the last", 1.0, "burst_ends_on_last", "", at_most=False),
    _itself("rest", "CPU of an idle process node", 0.2, "cpu_percent", " %", subject="process"),
    _itself("exit", "exit, signal_generator", 2.0, "exit_s", " s", subject="signal_generator"),
    _itself("exit", "exit, process", 2.0, "exit_s", " s", subject="process"),
]
