"""All measurements: what is measured, of whom, how often."""

from typing import Callable, ContextManager, List, NamedTuple, Optional

from . import (
    boards,
    bridging,
    callbacks,
    executors,
    floor,
    goals_bridged,
    groups,
    latency,
    lifecycles,
    live,
    loop,
    overlap,
    robots,
    stacks,
    startup,
    throughput,
    timing,
)
from .context import Bench, Figures


class Measurement(NamedTuple):
    """One kind of run."""

    name: str
    help: str
    #: of whom, in the order of the first repeat
    subjects: List[str]
    #: what measures one of them afresh
    measure: Optional[Callable[[Bench, str], Figures]] = None
    #: in place of that: what has one of them up, and yields what measures it in a short turn
    stand_ready: Optional[Callable[[Bench, str], ContextManager[Callable[[], Figures]]]] = None
    #: how often it is measured afresh at most; less often what scatters little or takes long
    repeats: int = 1000
    #: subjects that are left out of --quick, and otherwise measured until there is one turn
    slow: List[str] = []
    #: whether to run it once for nothing, so that files and caches are warm
    warm_up: bool = False
    #: whether few ask for it: only with --all
    is_extra: bool = False


#: The same pair, by whom one may write it.
PAIRS = [stacks.OURS, stacks.ROSPY, stacks.ROSCPP, stacks.RCLPY, stacks.RCLPY_EVENTS]

MEASUREMENTS = [
    Measurement(
        "latency-1khz",
        "generator -> process -> observer at 1 kHz",
        [
            stacks.OURS,
            stacks.MANAGED,
            floor.FLOOR,
            stacks.ROSPY,
            stacks.ROSCPP,
            stacks.RELAY,
            stacks.RCLPY,
            stacks.RCLPY_EVENTS,
        ],
        stand_ready=latency.in_turns(1000.0),
    ),
    Measurement(
        "host-1khz",
        "the same with both nodes in one process, against roscpp's in one and in two",
        [stacks.HOST, stacks.INTRAPROCESS, stacks.ROSCPP],
        stand_ready=latency.in_turns(1000.0),
    ),
    Measurement(
        "latency-500hz",
        "generator -> process -> observer at 500 Hz",
        PAIRS,
        stand_ready=latency.in_turns(500.0),
    ),
    Measurement(
        "latency-100hz",
        "the same at 100 Hz",
        [*PAIRS, stacks.RELAY],
        stand_ready=latency.in_turns(100.0),
    ),
    Measurement("latency-50hz", "the same at 50 Hz", PAIRS, stand_ready=latency.in_turns(50.0)),
    Measurement(
        "latency-10hz",
        "the same at 10 Hz, against the course's nodes",
        [stacks.OURS, stacks.COURSE],
        latency.at_10_hz,
    ),
    Measurement(
        "drift",
        "drift of the generator at 1 kHz",
        [stacks.OURS],
        timing.over_time,
        repeats=1,
    ),
    Measurement(
        "period",
        "periods of the generator at 1 kHz",
        [stacks.OURS, timing.LOOP],
        timing.from_call_to_call,
    ),
    Measurement(
        "launch",
        "roslaunch to the first answer",
        [stacks.OURS, stacks.COURSE],
        startup.launch,
        warm_up=True,
    ),
    Measurement(
        "loop",
        "motor -> controller -> motor at 1 kHz, against generator -> process",
        [loop.LOOP, stacks.OURS],
        stand_ready=loop.stand_ready,
    ),
    Measurement(
        "throughput",
        "the highest rate without loss",
        [stacks.OURS, stacks.ROSCPP],
        throughput.zero_loss_rate,
        repeats=2,
        is_extra=True,
    ),
    Measurement(
        "groups",
        "32 groups of generator and process",
        [stacks.OURS, stacks.COURSE],
        groups.thirty_two,
        repeats=3,
        slow=[stacks.COURSE],
        is_extra=True,
    ),
    Measurement(
        "thousand",
        "1000 groups of generator and process",
        [stacks.OURS],
        groups.thousand,
        repeats=1,
        slow=[stacks.OURS],
        is_extra=True,
    ),
    Measurement(
        "memory",
        "resident memory of a node",
        [startup.GENERATOR, startup.PROCESS, startup.BARE],
        startup.memory,
        repeats=1,
    ),
    Measurement(
        "callback",
        "a callback in its group",
        [stacks.OURS],
        callbacks.uncontended,
        repeats=1,
        is_extra=True,
    ),
    Measurement(
        "executor",
        "a call by an executor",
        [stacks.OURS, stacks.RCLPY, stacks.RCLPY_EVENTS],
        executors.call,
        repeats=1,
        is_extra=True,
    ),
    Measurement(
        "overlap",
        "which callbacks overlap in executors",
        [stacks.OURS, stacks.RCLPY],
        overlap.agreement,
        repeats=1,
        is_extra=True,
    ),
    Measurement(
        "lifecycle",
        "cases in which managed nodes do what rclpy's do",
        [stacks.RCLPY],
        lifecycles.agreement,
        repeats=1,
        is_extra=True,
    ),
    Measurement(
        "transition",
        "a transition of a managed node",
        [stacks.OURS],
        lifecycles.request,
        repeats=3,
    ),
    Measurement(
        "robots",
        "a robot and its controller, in one process and in two",
        [robots.HOSTED, robots.PAIR],
        stand_ready=robots.stand_ready,
    ),
    Measurement(
        "robot",
        "a robot that scans, and the start of one",
        [robots.SCAN, robots.START],
        robots.measure,
        repeats=3,
        warm_up=True,
    ),
    Measurement(
        "fleet",
        "a hundred simulated robots in one process",
        [robots.FLEET],
        robots.measure,
        repeats=3,
        is_extra=True,
    ),
    Measurement(
        "serial",
        "the link to a board at 115 200 baud: the host's part",
        boards.SUBJECTS,
        boards.measure,
        repeats=3,
        is_extra=True,
    ),
    Measurement(
        "bridge",
        "a message at 1 kHz from one ROS to the other, and within each",
        [
            bridging.ROSPY,
            stacks.RCLPY,
            stacks.RCLPY_EVENTS,
            bridging.TO_ROS2,
            bridging.TO_ROS1,
            bridging.BARE,
        ],
        bridging.at_1_khz,
        repeats=3,
        is_extra=True,
    ),
    Measurement(
        "bridge-load",
        "the bridge with 4000 messages a second, and with fifty topics at 20 Hz",
        [stacks.RCLPY, stacks.RCLPY_EVENTS, bridging.TO_ROS2, bridging.TO_ROS1],
        bridging.load,
        repeats=2,
        is_extra=True,
    ),
    Measurement(
        "bridge-many",
        "the bridge with a hundred topics at 50 Hz",
        [stacks.RCLPY, stacks.RCLPY_EVENTS, bridging.TO_ROS2, bridging.TO_ROS1],
        bridging.many,
        repeats=2,
        is_extra=True,
    ),
    Measurement(
        "bridge-actions",
        "goals of actions one after the other: until they are accepted, and their feedback",
        [bridging.ROSPY, stacks.RCLPY, bridging.TO_ROS2, bridging.TO_ROS1],
        goals_bridged.measure,
        repeats=3,
        is_extra=True,
    ),
    Measurement(
        "bridge-rest",
        "the bridge from its start to its first message, and with nothing to do",
        [bridging.TO_ROS1],
        bridging.rest,
        repeats=2,
        is_extra=True,
    ),
    Measurement("live", "effect of setting a parameter", [stacks.OURS], live.effect, repeats=1),
    Measurement("rest", "processor time of idle nodes", ["process"], live.rest, repeats=1),
    Measurement("exit", "time to end", ["signal_generator", "process"], live.leave, repeats=1),
]


def chosen(only: Optional[List[str]] = None, with_extra: bool = False) -> List[Measurement]:
    """Return the measurements that are to be made.

    :param only: their names, if not the usual ones
    :param with_extra: whether all belong to the usual ones
    """
    if only:
        return [one for one in MEASUREMENTS if one.name in only]
    return [one for one in MEASUREMENTS if with_extra or not one.is_extra]
