"""Rows of the benchmark: measurement, subjects, and number of turns."""

import contextlib
from typing import Callable, ContextManager, Iterator, List, NamedTuple, Optional

from . import (
    boards,
    bridge,
    images,
    latency,
    loop,
    names,
    parameters,
    rclpy_comparison,
    robots,
    startup,
    stacks,
)
from .context import Bench, Figures

#: Measures one turn of a subject.
Turn = Callable[[], Figures]


class Measurement(NamedTuple):
    """One row of the benchmark."""

    name: str
    subjects: List[str]
    #: starts a subject, and yields the function that measures a turn of it
    prepare: Callable[[Bench, str], ContextManager[Turn]]
    #: turns of each subject
    rounds: int
    #: turns until the subjects are started again
    rounds_per_start: int


def _paused(
    name: str, subjects: List[str], prepare: Callable[[Bench, str], ContextManager[Turn]]
) -> Measurement:
    """Return a row with all subjects running together, and stopped except for their turns.

    They are started twice: per-process effects, such as the memory layout, make the turns of one
    start similar.
    """
    return Measurement(name, subjects, prepare, 6, 3)


def _restarted(
    name: str, subjects: List[str], measure: Callable[[Bench, str], Figures], rounds: int = 1
) -> Measurement:
    """Return a row with subjects that are started for each turn."""

    @contextlib.contextmanager
    def prepare(bench: Bench, subject: str) -> Iterator[Turn]:
        yield lambda: measure(bench, subject)

    return Measurement(name, subjects, prepare, rounds, rounds)


#: The same pair by four client libraries.
PAIRS = [stacks.OURS, stacks.ROSPY, stacks.ROSCPP, stacks.RCLPY]
BRIDGED = [stacks.ROSPY, stacks.RCLPY, bridge.TO_ROS2, bridge.TO_ROS1]

MEASUREMENTS = [
    _paused("latency-1khz", PAIRS, latency.at(1000.0)),
    _paused("latency-100hz", PAIRS, latency.at(100.0)),
    _paused("loop", [loop.LOOP, stacks.OURS], loop.prepare),
    _paused("robot", [robots.HOSTED, robots.PAIR], robots.prepare),
    Measurement("launch", [stacks.OURS, stacks.COURSE], startup.prepare_launch, 3, 3),
    _restarted("memory", list(startup.NODES), startup.measure_memory),
    _restarted("parameters", [stacks.OURS], parameters.measure),
    _restarted("bridge", BRIDGED, bridge.measure_hop, 3),
    _restarted("executor", [stacks.OURS, stacks.RCLPY], rclpy_comparison.measure_executor),
    _restarted("overlap", [stacks.OURS, stacks.RCLPY], rclpy_comparison.compare_overlap),
    _restarted("lifecycle", [stacks.RCLPY], rclpy_comparison.compare_lifecycle),
    _restarted("bridge-load", [bridge.TO_ROS2, bridge.TO_ROS1], bridge.measure_load, 2),
    _restarted("bridge-actions", BRIDGED, bridge.measure_actions, 3),
    _restarted("bridge-images", BRIDGED, bridge.measure_images, 2),
    _restarted("serial", [boards.OURS, boards.ROSSERIAL, boards.BARE], boards.measure, 2),
    _restarted("images", list(images.CASES), images.measure, 3),
]


def select(only: Optional[List[str]] = None, is_all: bool = False) -> List[Measurement]:
    """Return the rows to measure.

    :param only: their names, in place of the main rows
    :param is_all: whether the main rows are followed by all others
    """
    wanted = only or (list(names.MAIN) + list(names.EXTRA) if is_all else list(names.MAIN))
    return [one for one in MEASUREMENTS if one.name in wanted]
