"""Command ``rosrun topic_scope mask.py``: mask test of a trace, live or in a bag."""

import argparse
import math
import queue
import sys
import time
from typing import List, NoReturn, Optional

import rospy

from nodekit import MasterUnreachable, init_node
from nodekit.master import MasterClient
from topic_scope.bag.opening import learn_types, open_bag
from topic_scope.bag.recording import BagError
from topic_scope.bag.player import BagPlayer
from topic_scope.formulas.parser import SECONDS
from topic_scope.graph.master_watch import GraphState, MasterWatch
from topic_scope.masks.failure_file import BEFORE_S, save_failure
from topic_scope.masks.mask_check import Mask, MaskCheck, MaskResult
from topic_scope.messages.fields import FieldError
from topic_scope.messages.layout_cache import Layouts
from topic_scope.sampling.raw_subscriptions import RawSubscriptions, SteadyClock
from nodekit.package_version import ShowVersion
from topic_scope.sampling.recorder import Recorder

#: Exit status: a sample was outside; no sample could be checked, or the command is invalid.
OUTSIDE, NOT_CHECKED = 1, 2
#: Most unchecked samples of a pass [%]: the reference is unknown at either end.
_UNCHECKED = 10.0
#: How long samples are kept [s]: longer than any formula reaches back and ahead.
_HISTORY_S = 2.0 * SECONDS + 100.0
#: How long a live trace is checked by default [s].
_LENGTH_S = 10.0
#: Update period of a live graph, and length of bag to read per update [s].
_LIVE_S, _BAG_S = 0.05, 0.5


class TraceChecker:
    """Check of one trace against its mask, with the samples of a recorder.

    :param recorder: recorder of the trace and its reference
    :param arguments: the command line
    """

    def __init__(self, recorder: Recorder, arguments: argparse.Namespace) -> None:
        self._recorder, self._arguments = recorder, arguments
        self._check: Optional[MaskCheck] = None
        self._saved = 0

    def begin(self, now: float, start: float) -> None:
        """Start recording, once the topics are known.

        :param now: the time [s]
        :param start: only later samples are checked [s]
        :raises FieldError: if a name is invalid, or denotes several fields, or both with the
            limits form a formula that is too long, or reaches too far
        """
        field, reference = (
            self._one_of(name) for name in (self._arguments.field, self._arguments.around)
        )
        mask = Mask(field, reference, self._arguments.value, self._arguments.time)
        if mask.problem:
            raise FieldError(mask.problem)
        if self._check is None or self._check.mask != mask:
            self._check = MaskCheck(mask, start)
        self._recorder.want(mask.names, now)

    def start(self, now: float) -> bool:
        """Start checking new samples, once both traces have been received.

        :param now: the time [s]
        :returns: whether checking has started
        """
        if self._check is None:
            return False
        mask = self._check.mask
        self._recorder.update()
        for name in (mask.field, mask.reference):
            trace = self._recorder.trace(name)
            if trace is None or trace.silence(now) is None:
                return False
        self._check.start(now)
        return True

    def _one_of(self, name: str) -> str:
        names = self._recorder.expand(name)
        if len(names) != 1:
            raise FieldError(f"{name} denotes {len(names)} fields; name one of them")
        return names[0]

    def update(self) -> bool:
        """Check the new samples, and save the first failure before its samples are dropped.

        :returns: whether the check has ended: the first sample outside ends it
        :raises OSError: if it cannot be saved
        """
        self._recorder.update()
        if self._check is None:
            return False
        first = self._check.update(self._recorder).first
        if first is None:
            return False
        if not self._saved:
            self._save(self._check.mask, first)
        return not self._arguments.all

    def _save(self, mask: Mask, first: float) -> None:
        """Save a failure with all later samples, unless its samples have been dropped."""
        read = self._recorder.samples
        there = sum(len(read(name, first - BEFORE_S, first)[0]) for name in mask[:2])
        if self._arguments.save is not None and there >= self._saved:
            save_failure(self._arguments.save, self._recorder, mask, first)
        self._saved = max(self._saved, there)

    def finish(self) -> int:
        """Print the result, and save a failure again with the samples after it.

        :returns: the exit status
        :raises OSError: if it cannot be saved
        """
        ended: Optional[float] = None
        if self._check is not None and (self._arguments.all or self._check.result.first is None):
            ended = self._check.finish(self._recorder)
        result = self._check.result if self._check is not None else MaskResult()
        print(f"mask: {result.text}", flush=True)
        if result.first is not None and self._check is not None:
            print(
                f"mask: outside for the first time at {result.first:.6f} s since the epoch, at "
                f"worst by {result.worst:.6g}",
                flush=True,
            )
            self._save(self._check.mask, result.first)
            return OUTSIDE
        if result.inside == 0:
            said = [self._recorder.problem(one) for one in self._names()]
            why = next((text for text in said if text), "the reference is unknown at all samples")
            print(f"mask: no sample could be checked: {why}", file=sys.stderr)
            return NOT_CHECKED
        if ended is not None:
            name = self._names()[1]
            print(f"mask: {name} ended {ended:.2f} s before the trace did", file=sys.stderr)
            return NOT_CHECKED
        share = 100.0 * result.unchecked / (result.inside + result.unchecked)
        if share > self._arguments.unchecked:
            print(
                f"mask: too many samples were not checked ({share:.3g} %, at most "
                f"{self._arguments.unchecked:g} %); check for longer, or allow more by --unchecked",
                file=sys.stderr,
            )
            return NOT_CHECKED
        return 0

    def _names(self) -> List[str]:
        if self._check is None:
            return [self._arguments.field, self._arguments.around]
        return [self._check.mask.field, self._check.mask.reference]


class _Steps:
    """Clock that is advanced manually, so that a bag is read as fast as possible."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def check_bag(arguments: argparse.Namespace) -> int:
    """Check a trace of a bag.

    :returns: the exit status
    :raises BagError: if it cannot be read
    """
    bag = open_bag(arguments.bag)
    clock, layouts = _Steps(), Layouts()
    player = BagPlayer(bag, _HISTORY_S, clock)
    recorder = Recorder(player, layouts, _HISTORY_S)
    recorder.set_topics(learn_types(bag, layouts))
    checker = TraceChecker(recorder, arguments)
    checker.begin(player.start, -math.inf)
    player.seek(player.start)
    player.play()
    while player.is_playing and not checker.update():
        clock.seconds += _BAG_S
    status = checker.finish()
    for problem in player.problems:
        print(f"mask: {problem}", file=sys.stderr)
    return status or (NOT_CHECKED if player.problems else 0)


def check_live(arguments: argparse.Namespace) -> int:
    """Check a live trace for a limited time.

    :returns: the exit status
    :raises MasterUnreachable: if there is no master
    """
    with MasterClient("/mask", timeout=5.0) as master:
        master.read([])
    init_node("mask")
    source, layouts = RawSubscriptions(SteadyClock()), Layouts()
    recorder = Recorder(source, layouts, _HISTORY_S)
    checker = TraceChecker(recorder, arguments)
    states: "queue.Queue[GraphState]" = queue.Queue()
    MasterWatch(source, layouts).start(states.put, lambda _uri: None)
    # Samples before both traces are subscribed to are not checked.
    length = arguments.seconds or _LENGTH_S
    start, until = math.inf, time.monotonic() + length
    while time.monotonic() < until and not (start < math.inf and checker.update()):
        try:
            recorder.set_topics(states.get(timeout=_LIVE_S).published_types)
            checker.begin(source.clock.now(), start)
        except queue.Empty:
            pass
        now = source.clock.now()
        if start == math.inf and checker.start(now):
            start, until = now, time.monotonic() + length
    status = checker.finish()
    rospy.signal_shutdown("the check has ended")
    return status


def main() -> None:
    """Check a trace; exit with 0, 1 or 2."""
    arguments = _parser().parse_args(rospy.myargv()[1:])
    if arguments.bag is not None and arguments.seconds is not None:
        _fail("--seconds is for a live trace; a bag is checked to its end")
    try:
        sys.exit(check_live(arguments) if arguments.bag is None else check_bag(arguments))
    except (BagError, FieldError) as error:
        _fail(str(error))
    except MasterUnreachable as error:
        _fail(f"no master at {error}")
    except OSError as error:
        _fail(f"{arguments.save}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C


def _fail(text: str) -> NoReturn:
    print(f"mask: {text}", file=sys.stderr)
    sys.exit(NOT_CHECKED)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="mask",
        description="Check whether a trace stays within limits around another trace.",
        epilog="Exit status: 0 if all samples are inside, 1 if one is outside, 2 if none could be "
        "checked or too few were, the reference ended early, or the command is invalid.",
    )
    parser.add_argument("--version", action=ShowVersion, package="topic_scope")
    parser.add_argument("field", metavar="FIELD", help="trace to check: a field or a formula")
    parser.add_argument(
        "--around", metavar="REFERENCE", required=True, help="trace at the centre of the limits"
    )
    parser.add_argument(
        "--value",
        metavar="V",
        type=_value,
        default=0.0,
        help="distance of the limits above and below it",
    )
    parser.add_argument(
        "--time", metavar="S", type=_time, default=0.0, help="distance before and after it, s"
    )
    parser.add_argument(
        "--seconds",
        metavar="S",
        type=_seconds,
        help=f"how long to check a live trace [s] ({_LENGTH_S:g})",
    )
    parser.add_argument("--bag", metavar="FILE.bag", help="check a recording; needs no master")
    parser.add_argument(
        "--all", action="store_true", help="continue after the first sample outside"
    )
    parser.add_argument(
        "--unchecked",
        metavar="PERCENT",
        type=_percent,
        default=_UNCHECKED,
        help="most unchecked samples of a pass, %% (%(default)g)",
    )
    parser.add_argument(
        "--save",
        metavar="FILE.csv",
        help="file for trace, reference and limits, from 2 s before the first sample outside",
    )
    return parser


def _number(text: str, least: float, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from {least:g} to {most:g}")
    return number


def _value(text: str) -> float:
    return _number(text, 0.0, 1e300)


def _time(text: str) -> float:
    return _number(text, 0.0, SECONDS)


def _percent(text: str) -> float:
    return _number(text, 0.0, 100.0)


def _seconds(text: str) -> float:
    return _number(text, 0.1, 1e6)
