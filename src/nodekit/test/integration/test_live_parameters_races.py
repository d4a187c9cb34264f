#!/usr/bin/env python3
"""Changes that come at the worst moment: each is made to come just there, on a real master."""

import itertools
import logging
import random
import threading
import time
import unittest
from typing import Any, Callable, List, Mapping, Optional, Sequence
from unittest import mock
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
import rostest
from helpers.parameter_node import GaugeParameters

from nodekit.live import live_parameters, watcher
from nodekit.live.live_parameters import LiveParameters
from nodekit.live.parameter_server import ParameterServer, Reading
from nodekit.live.watcher import Observation, ParameterWatcher, Watch
from nodekit.parameters import contention
from nodekit.parameters.declaration import ParameterError, to_wire
from nodekit.rospy_internals.parameters import ROSOUT_PARAMETER
from nodekit.testing.processes import Server
from nodekit.testing.waiting import wait_until


class ServerWithMoments(ParameterServer):
    """A client of the parameter server that lets something happen at certain moments, once."""

    before_write: Optional[Callable[[], None]] = None
    after_read: Optional[Callable[[], None]] = None
    forgotten = False

    def write(self, values: Mapping[str, Any]) -> None:
        moment, self.before_write = self.before_write, None
        if moment is not None:
            moment()
        super().write(values)

    def read(self, keys: Sequence[str]) -> Reading:
        reading = super().read(keys)
        if self.forgotten:
            self.forgotten = False
            reading = reading._replace(knows_node=False)
        moment, self.after_read = self.after_read, None
        if moment is not None:
            moment()
        return reading


class Warnings(logging.Handler):
    """Keeps what this node warns of."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: List[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


class Onlooker(Watch):
    """Keeps all notifications of a key."""

    def __init__(self, key: str) -> None:
        super().__init__(key)
        self.pushed: List[Any] = []

    def observe(self, seen: Observation) -> bool:
        self.pushed += seen.pushed
        return True


class Races(unittest.TestCase):
    """The node is in this process; its user is another client of the master."""

    numbers = itertools.count()

    @classmethod
    def setUpClass(cls) -> None:
        cls.user = Server()
        cls.server = ServerWithMoments(
            rosgraph.get_master_uri(), rospy.get_name(), rospy.get_node_uri()
        )
        cls.watcher = ParameterWatcher(cls.server)

    def setUp(self) -> None:
        self.key = "/races/%d" % next(self.numbers)
        self.level = self.key + "/level"
        self.server.before_write = self.server.after_read = None
        self.warnings = Warnings()
        logging.getLogger("rosout").addHandler(self.warnings)
        self.addCleanup(logging.getLogger("rosout").removeHandler, self.warnings)

    def make(self) -> LiveParameters[GaugeParameters]:
        live = LiveParameters(GaugeParameters, self.key, watcher=self.watcher)
        self.addCleanup(self.watcher.remove, live)
        return live

    def look_on(self) -> Onlooker:
        onlooker = Onlooker(self.key)
        self.watcher.add(onlooker)
        self.addCleanup(self.watcher.remove, onlooker)
        return onlooker

    def start(self, **values: Any) -> LiveParameters[GaugeParameters]:
        self.user.set(self.key, {**to_wire_dict(GaugeParameters()), **values})
        live = self.make()
        live.start()
        return live

    def assert_ends_with(self, live: LiveParameters[GaugeParameters], **values: Any) -> None:
        """Wait until just these values are in force and on the server, and look once more."""
        expected = GaugeParameters(**values)
        for count in (expected.count + 1, expected.count):
            wait_until(
                lambda: live.values == expected and self.told() == to_wire_dict(expected),
                lambda: "%s, not %s; on the server %s" % (live.values, expected, self.told()),
            )
            # What is still under way now has come to its end when this change has.
            expected = expected.replace(count=count)
            self.user.set(self.key + "/count", count)
        wait_until(lambda: live.values == expected, lambda: str(live.values))

    def told(self) -> Any:
        held = self.user.get(self.key)
        return held and {k: v for k, v in held.items() if k in GaugeParameters.declared}

    def test_good_value_that_is_hit_by_a_put_back_wins(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = lambda: self.user.set(self.level, 5.0)
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=5.0)

    def test_good_value_that_is_hit_by_two_put_backs_wins(self) -> None:
        live = self.start(level=2.0)

        def meddle() -> None:
            self.user.set(self.level, 5.0)
            self.server.before_write = lambda: self.user.set(self.level, 6.0)

        self.server.before_write = meddle
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=6.0)

    def test_deletion_that_is_hit_by_a_put_back_wins(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = lambda: self.user.delete(self.level)
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=1.0)

    def test_deletion_of_the_namespace_that_is_hit_by_a_put_back_wins(self) -> None:
        live = self.start(level=2.0, title="old")
        self.server.before_write = lambda: self.user.delete(self.key)
        self.user.set(self.level, -1)
        self.assert_ends_with(live)

    def test_namespace_that_is_replaced_during_a_put_back_comes_into_force(self) -> None:
        live = self.start(level=2.0, title="old")
        self.server.before_write = lambda: self.user.set(self.key, {"count": 5})
        self.user.set(self.level, -1)
        # The master sends the namespace as it is before the put-back, or after it.
        wait_until(lambda: live.values.title == "gauge", lambda: str(live.values))
        self.assert_ends_with(live, level=live.values.level, count=5)
        self.assertIn(live.values.level, (1.0, 2.0))

    def test_scalar_over_the_namespace_during_a_put_back_ends_in_step(self) -> None:
        live = self.start(level=2.0, title="old")
        self.server.before_write = lambda: self.user.set(self.key, 7)
        self.user.set(self.level, -1)
        # The put-back makes a namespace of the scalar again, with nothing else in it.
        self.assert_ends_with(live, level=2.0)

    def test_bad_value_that_is_hit_by_a_put_back_changes_nothing(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = lambda: self.user.set(self.level, "x")
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=2.0)

    def test_value_that_comes_when_the_defaults_are_written_at_the_start(self) -> None:
        onlooker = self.look_on()
        self.server.before_write = lambda: self.user.set(self.level, 5.0)
        live = self.make()
        wait_until(lambda: onlooker.pushed, lambda: "no notification")
        live.start()
        self.assert_ends_with(live, level=5.0)

    def test_value_that_comes_between_the_first_read_and_the_start(self) -> None:
        live = self.make()
        self.user.set(self.level, 5.0)
        changes: List[float] = []
        live.start(lambda new, old: changes.append(new.level))
        self.assert_ends_with(live, level=5.0)
        self.assertEqual(changes[0], 5.0)

    def test_bad_value_between_the_first_read_and_the_start(self) -> None:
        live = self.make()
        self.user.set(self.level, -1)
        live.start()
        self.assert_ends_with(live)

    def test_good_value_that_comes_and_is_replaced_before_the_start(self) -> None:
        live = self.make()
        self.user.set(self.level, 5.0)
        self.user.set(self.level, -1)
        live.start()
        self.assert_ends_with(live, level=5.0)

    def test_set_that_is_refused_at_the_start_is_followed_no_longer(self) -> None:
        self.user.set(self.level, -1)
        with self.assertRaises(ParameterError):
            LiveParameters(GaugeParameters, self.key, watcher=self.watcher)
        code, _, _ = ServerProxy(rospy.get_node_uri()).paramUpdate("/master", self.level, 5.0)
        self.assertEqual(code, -1, "the node says that it follows the key")

    def test_update_during_a_read_is_not_taken_back(self) -> None:
        live = self.start()
        levels: List[float] = []
        live.add_listener(lambda new, old: levels.append(new.level))

        def update() -> None:
            live.update(level=live.values.level + 10.0)
            if live.values.level < 100.0:
                self.server.after_read = update

        self.server.after_read = update
        self.user.set(self.level, 2.0)
        wait_until(lambda: live.values.level > 100.0, lambda: str(live.values))
        self.assert_ends_with(live, level=live.values.level)
        self.assertEqual(levels, sorted(levels))

    @mock.patch.object(watcher, "SETTLE_LIMIT_S", 10.0)
    def test_change_that_is_half_done_is_waited_for(self) -> None:
        live = self.start()
        levels: List[float] = []
        live.add_listener(lambda new, old: levels.append(new.level))

        parts = iter(["second", "third", "last"])

        def go_on() -> None:
            if self.user.get(self.level) == 5.0:
                self.user.set(self.key + "/title", next(parts))
            if self.user.get(self.key + "/title") != "last":
                self.server.after_read = go_on

        self.server.after_read = go_on
        self.user.set(self.level, 5.0)
        self.assert_ends_with(live, level=5.0, title="last")
        # Of the other two, the end makes one go up and one go down.
        self.assertEqual(len(levels), 3)

    @mock.patch.object(live_parameters, "PATIENCE_S", 10.0)
    def test_values_that_do_not_go_together_yet_are_given_time(self) -> None:
        live = self.start()
        reads = itertools.count()

        def go_on_late() -> None:
            if next(reads) < 6:
                self.server.after_read = go_on_late
            else:
                self.user.set(self.key + "/high", 30.0)

        self.server.after_read = go_on_late
        self.user.set(self.key + "/low", 20.0)
        self.assert_ends_with(live, low=20.0, high=30.0)
        self.assertEqual(self.warnings.texts, [])

    def test_values_that_do_not_go_together_are_refused_in_the_end(self) -> None:
        live = self.start()
        self.user.set(self.key + "/low", 20.0)
        self.assert_ends_with(live)
        self.assertEqual(len(self.warnings.texts), 1)

    def test_update_that_cannot_be_written_changes_nothing(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = fail
        with self.assertRaises(OSError):
            live.update(level=5.0)
        self.assertEqual(live.values.level, 2.0)
        self.assert_ends_with(live, level=2.0)

    def test_put_back_that_fails_is_done_later(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = fail
        self.user.set(self.level, 5.0)
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=5.0)
        self.assertEqual(len([text for text in self.warnings.texts if "refused" in text]), 1)

    def test_values_are_kept_though_writing_them_to_a_new_master_fails_at_first(self) -> None:
        live = self.start(level=2.0, title="kept", marks=[])
        self.server.before_write = fail
        self.server.forgotten = True
        self.user.delete(self.key)
        self.assert_ends_with(live, level=2.0, title="kept", marks=[])

    def test_same_bad_value_once_more_is_refused_once_more(self) -> None:
        live = self.start(level=2.0)
        for number in range(1, 4):
            self.user.set(self.level, -1)
            self.user.wait_for(self.level, 2.0)
            self.assertEqual(len(self.warnings.texts), number, self.warnings.texts)
        self.assert_ends_with(live, level=2.0)

    def test_same_bad_value_once_more_without_a_notification(self) -> None:
        live = self.start(level=2.0)
        for _ in range(3):
            # The master does not notify the writer.
            self.user.master.setParam(rospy.get_name(), self.level, -1)
            self.user.wait_for(self.level, 2.0)
        self.assert_ends_with(live, level=2.0)
        self.assertEqual(len(self.warnings.texts), 3)

    def test_bad_bad_good_ends_good_at_any_pace(self) -> None:
        live, pace = self.start(), random.Random(1)
        for good in range(10, 35):
            for bad in (-1, "x")[: pace.randrange(3)]:
                self.user.set(self.level, bad)
                time.sleep(pace.choice([0.0, 0.02, 0.1]) * pace.random())
            self.user.set(self.level, good)
            wait_until(
                lambda: live.values.level == good and self.user.get(self.level) == good,
                lambda: "%s, on the server %s" % (live.values.level, self.user.get(self.level)),
            )
        self.assert_ends_with(live, level=34.0)

    def test_good_bad_ends_on_the_good_one_at_any_pace(self) -> None:
        live, pace = self.start(), random.Random(2)
        for good in range(10, 30):
            self.user.set(self.level, good)
            time.sleep(pace.choice([0.0, 0.02, 0.1]) * pace.random())
            self.user.set(self.level, -good)
            wait_until(
                lambda: live.values.level == good and self.user.get(self.level) == good,
                lambda: "%s, on the server %s" % (live.values.level, self.user.get(self.level)),
            )
        self.assert_ends_with(live, level=29.0)

    def test_changes_come_through_while_a_slider_is_moved(self) -> None:
        live = self.start()
        levels: List[float] = []
        live.add_listener(lambda new, old: levels.append(new.level))
        for position in itertools.count(1):
            self.user.set(self.level, float(position))
            time.sleep(0.02)
            if len(levels) >= 5:
                break
        self.assert_ends_with(live, level=float(position))
        self.assertEqual(levels, sorted(levels))

    def test_burst_ends_on_the_last_value(self) -> None:
        live = self.start()
        for position in range(200):
            self.user.set(self.level, float(position))
        self.assert_ends_with(live, level=199.0)

    @mock.patch.object(contention, "BURST", 3)
    def test_writer_that_insists_is_not_answered_in_a_quick_loop(self) -> None:
        live = self.start(level=2.0)
        begin, answers, end = time.monotonic(), [0], threading.Event()

        def insist() -> None:
            while not end.is_set():
                if self.user.get(self.level) != -1:
                    answers[0] += 1
                    self.user.set(self.level, -1)
                time.sleep(0.002)

        rival = threading.Thread(target=insist)
        rival.start()
        try:
            wait_until(lambda: answers[0] >= 6, lambda: "%d answers" % answers[0])
            self.user.set(self.key + "/title", "through")
            wait_until(lambda: live.values.title == "through", lambda: str(live.values))
        finally:
            end.set()
            rival.join()
        # The first one is the rival's own, and so is one after the last put-back.
        self.assertLessEqual(answers[0], contention.BURST + 1 + time.monotonic() - begin)
        self.assertLessEqual(len(self.warnings.texts), answers[0])
        self.assert_ends_with(live, level=2.0, title="through")

    def test_listeners_are_told_in_order_though_one_changes_values(self) -> None:
        live = self.start()
        told = [live.values]

        def follow(new: GaugeParameters, old: GaugeParameters) -> None:
            if new.level != old.level:
                live.update(count=int(new.level))

        def note(new: GaugeParameters, old: GaugeParameters) -> None:
            self.assertEqual(old, told[-1])
            told.append(new)

        live.add_listener(follow)
        live.add_listener(note)
        self.user.set(self.key + "/level", "5")
        wait_until(lambda: len(told) > 2, lambda: str(told))
        self.assert_ends_with(live, level=5.0, count=5)
        self.assertEqual([(values.level, values.count) for values in told[1:3]], [(5, 3), (5, 5)])

    def test_key_that_was_never_cached_is_notified_of(self) -> None:
        onlooker = self.look_on()
        self.user.set(self.key + "/new/leaf", 5)
        wait_until(lambda: onlooker.pushed, lambda: "rospy keeps the notification for itself")
        self.assertEqual(onlooker.pushed, [(self.key + "/new/leaf", 5)])

    def test_cached_reads_by_others_in_the_process_harm_nobody(self) -> None:
        live = self.start(level=2.0)
        self.assertEqual(rospy.get_param_cached(self.level), 2.0)
        self.user.set(self.level, 5.0)
        self.user.set(self.key + "/title", "new")
        self.assert_ends_with(live, level=5.0, title="new")
        self.assertEqual(rospy.get_param_cached(self.level), 5.0)

    def test_line_of_the_log_asks_the_master_for_nothing(self) -> None:
        cache = rospy.impl.paramserver.get_param_server_cache()
        for value in (False, True, False):
            self.user.set(ROSOUT_PARAMETER, value)
            wait_until(
                lambda: cache.get(ROSOUT_PARAMETER) is value,
                lambda: "%s is not in the cache" % value,
            )

    def test_defect_of_one_watch_harms_no_other(self) -> None:
        class Broken(Watch):
            def observe(self, seen: Observation) -> bool:
                raise ZeroDivisionError

        broken = Broken(self.key + "_broken")
        self.watcher.add(broken)
        live = self.start()
        self.user.set(broken.key, 1)
        self.user.set(self.level, 5.0)
        wait_until(lambda: live.values.level == 5.0, lambda: str(live.values))
        self.watcher.remove(broken)
        self.assertTrue([text for text in self.warnings.texts if "ZeroDivisionError" in text])


def fail() -> None:
    raise OSError("for once")


def to_wire_dict(values: GaugeParameters) -> Any:
    return {name: to_wire(value) for name, value in values.as_dict().items()}


if __name__ == "__main__":
    rospy.init_node("races")
    rostest.rosrun("nodekit", "live_parameters_races", Races)
