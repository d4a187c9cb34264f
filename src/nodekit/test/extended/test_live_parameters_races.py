#!/usr/bin/env python3
"""Tests of changes at critical moments, with a real master."""

import itertools
import logging
import random
import threading
import time
import unittest
from functools import partial
from typing import Any, Callable, Collection, List, Mapping, Optional
from unittest import mock
from xmlrpc.client import ServerProxy

import rospy
from helpers.parameter_node import GaugeParameters

from nodekit.master import MasterClient, MasterUnreachable, Reading
from nodekit.parameter_server import followed_parameter, reconfigure, watcher
from nodekit.parameter_server.followed_parameter import FollowedParameter
from nodekit.parameter_server.live_parameters import LiveParameters, open_all
from nodekit.parameter_server.watched_key import WatchedKey
from nodekit.parameter_server.watcher import Watcher
from nodekit.parameters import reconciler
from nodekit.parameters.declaration import ParameterError, to_wire
from nodekit.parameters.reconciler import Observation
from nodekit.rospy_internals.parameter_cache import ROSOUT_PARAMETER
from nodekit.testing.processes import Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class MasterWithMoments(MasterClient):
    """A client of the master that lets something happen at certain moments, once."""

    before_write: Optional[Callable[[], None]] = None
    after_read: Optional[Callable[[], None]] = None
    restart: Optional[Callable[[], None]] = None

    def write(self, values: Mapping[str, Any]) -> None:
        moment, self.before_write = self.before_write, None
        if moment is not None:
            moment()
        super().write(values)

    def read(self, keys: Collection[str]) -> Reading:
        restart = self.restart
        if restart is not None:
            restart()
            self.restart = None  # last, because the test continues then
        reading = super().read(keys)
        if restart is not None:
            reading = reading._replace(knows_node=False)
        moment, self.after_read = self.after_read, None
        if moment is not None:
            moment()
        return reading


class Warnings(logging.Handler):
    """Collects the warnings of this node."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: List[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


class Onlooker:
    """Keeps all notifications of a key."""

    def __init__(self, key: str) -> None:
        self.watched = WatchedKey(key, lambda raw: False, self.on_reading)
        self.pushed: List[Any] = []

    def on_reading(self, seen: Observation) -> bool:
        self.pushed += seen.pushed
        return True


class Races(unittest.TestCase):
    """The node is in this process; its user is another client of the master."""

    numbers = itertools.count()

    @classmethod
    def setUpClass(cls) -> None:
        cls.user = Server()
        cls.server = MasterWithMoments(rospy.get_name(), rospy.get_node_uri())
        cls.watcher = Watcher(cls.server)

    def setUp(self) -> None:
        self.key = f"/races/{next(self.numbers)}"
        self.level = self.key + "/level"
        self.server.before_write = self.server.after_read = None
        self.warnings = Warnings()
        logging.getLogger("rosout").addHandler(self.warnings)
        self.addCleanup(logging.getLogger("rosout").removeHandler, self.warnings)

    def make(self) -> LiveParameters[GaugeParameters]:
        live = LiveParameters(GaugeParameters, self.key, self.watcher)
        self.addCleanup(live.close)
        return live

    def look_on(self) -> Onlooker:
        onlooker = Onlooker(self.key)
        self.watcher.open([onlooker.watched])
        self.addCleanup(self.watcher.close, onlooker.watched)
        return onlooker

    def start(self, **values: Any) -> LiveParameters[GaugeParameters]:
        self.user.set(self.key, {**to_wire_dict(GaugeParameters()), **values})
        live = self.make()
        open_all([live])
        return live

    def levels_of(self, live: LiveParameters[GaugeParameters]) -> List[float]:
        """Return a list of the levels that its listeners will see."""
        levels: List[float] = []
        live.add_listener(lambda: levels.append(live.values.level))
        return levels

    def assert_ends_with(self, live: LiveParameters[GaugeParameters], **values: Any) -> None:
        """Wait until just these values are in force and on the server, and look once more."""
        expected = GaugeParameters(**values)
        for count in (expected.count + 1, expected.count):
            wait_until(
                lambda: live.values == expected and self.told() == to_wire_dict(expected),
                lambda: f"{live.values}, not {expected}; on the server {self.told()}",
            )
            # After this change, all earlier ones are complete.
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

    def test_namespace_replaced_during_a_restore_takes_effect(self) -> None:
        live = self.start(level=2.0, title="old")
        self.server.before_write = lambda: self.user.set(self.key, {"count": 5})
        self.user.set(self.level, -1)
        # The master sends the namespace before the reset, or after it.
        wait_until(lambda: live.values.title == "gauge", lambda: str(live.values))
        self.assert_ends_with(live, level=live.values.level, count=5)
        self.assertIn(live.values.level, (1.0, 2.0))

    def test_scalar_over_the_namespace_during_a_restore_ends_in_step(self) -> None:
        live = self.start(level=2.0, title="old")
        self.server.before_write = lambda: self.user.set(self.key, 7)
        self.user.set(self.level, -1)
        # The put-back makes a namespace of the scalar again, with nothing else in it.
        self.assert_ends_with(live, level=2.0)

    def test_invalid_value_overwritten_by_a_restore_has_no_effect(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = lambda: self.user.set(self.level, "x")
        self.user.set(self.level, -1)
        self.assert_ends_with(live, level=2.0)

    def test_value_set_while_the_defaults_are_written(self) -> None:
        live = self.make()
        self.server.before_write = lambda: self.user.set(self.level, 5.0)
        open_all([live])
        self.assert_ends_with(live, level=5.0)

    def test_value_set_between_the_first_read_and_the_opening(self) -> None:
        live = self.make()
        self.user.set(self.level, 5.0)
        levels = self.levels_of(live)
        open_all([live])
        self.assertEqual((live.values.level, levels), (5.0, [5.0]))
        self.assert_ends_with(live, level=5.0)

    def test_bad_value_between_the_first_read_and_the_opening(self) -> None:
        live = self.make()
        self.user.set(self.level, -1)
        open_all([live])
        self.assert_ends_with(live)
        self.assertEqual(len(self.warnings.texts), 1)

    def test_values_that_do_not_go_together_yet_at_the_opening(self) -> None:
        for key, value, expected in (("high", 30.0, {"low": 20.0, "high": 30.0}), ("count", 5, {})):
            self.setUp()
            live = self.make()
            self.user.set(self.key + "/low", 20.0)
            longest = TIMEOUT_S if expected else reconciler.HALF_DONE_S
            with mock.patch.object(reconciler, "HALF_DONE_S", longest):
                open_all([live])
                self.user.set(f"{self.key}/{key}", value)
                self.assert_ends_with(live, **{key: value, **expected})
            self.assertEqual(len(self.warnings.texts), 0 if expected else 1)

    def test_valid_value_set_and_replaced_during_the_opening(self) -> None:
        live, opening = self.make(), threading.current_thread()

        def meddle() -> None:
            if threading.current_thread() is not opening:  # the watcher reads once a second
                self.server.after_read = meddle
                return
            self.user.set(self.level, 5.0)
            self.user.set(self.level, -1)

        self.server.after_read = meddle
        open_all([live])
        self.assert_ends_with(live, level=5.0)

    def test_update_before_the_opening_is_written_then(self) -> None:
        self.user.set(self.level, 2.0)
        live = self.make()
        live.update(level=7.0, title="early")
        self.assertEqual(self.user.get(self.key), {"level": 2.0})
        self.user.set(self.key + "/count", 5)
        open_all([live])
        self.assert_ends_with(live, level=7.0, title="early", count=5)

    def test_value_deleted_before_opening_stays_in_force(self) -> None:
        self.user.set(self.level, 2.0)
        live = self.make()
        self.user.delete(self.key)
        open_all([live])
        self.assert_ends_with(live, level=2.0)

    def test_opening_that_fails_follows_nothing(self) -> None:
        live = self.make()
        self.server.before_write = fail
        with self.assertRaises(MasterUnreachable):
            open_all([live])
        self.assert_not_followed()

    def test_closed_parameters_are_no_longer_followed(self) -> None:
        live = self.start(level=2.0)
        self.assertIn(self.key, self.watcher._keys())
        live.close()
        self.assert_not_followed()
        live.update(level=3.0)
        self.assertEqual((live.values.level, self.user.get(self.level)), (3.0, 2.0))

    @mock.patch.object(watcher, "CLOSE_LIMIT_S", 2.0 * TIMEOUT_S)
    def test_closing_waits_for_running_callbacks(self) -> None:
        live, begun, end = self.start(), threading.Event(), threading.Event()
        self.addCleanup(end.set)

        def hold() -> None:
            begun.set()
            end.wait(TIMEOUT_S)

        live.add_listener(hold)
        self.user.set(self.level, 5.0)
        self.assertTrue(begun.wait(TIMEOUT_S))
        threading.Timer(0.3, end.set).start()
        before = time.monotonic()
        live.close()
        self.assertTrue(end.is_set())
        self.assertLess(time.monotonic() - before, TIMEOUT_S)

    def assert_not_followed(self) -> None:
        """Check that the master and the node have removed the subscription."""
        code, _, _ = ServerProxy(rospy.get_node_uri()).paramUpdate("/master", self.level, 5.0)
        self.assertEqual(code, -1, "the node says that it follows the key")
        marker = Onlooker(self.key + "_marker")
        self.watcher.open([marker.watched])
        self.addCleanup(self.watcher.close, marker.watched)
        cache = rospy.impl.paramserver.get_param_server_cache()
        with mock.patch.object(cache, "update", wraps=cache.update) as update:
            held = self.user.get(self.level)
            self.user.set(self.level, 9.0)
            self.user.set(marker.watched.key, 1)
            wait_until(lambda: marker.pushed, lambda: "no notification")
        noted = [call[0][0].rstrip("/") for call in update.call_args_list]
        # Not the last value of an earlier test.
        noted = [key for key in noted if (key + "_").startswith((self.key + "/", self.key + "_"))]
        self.assertEqual(noted, [marker.watched.key])
        self.user.set(self.level, held if held is not None else 1.0)

    def test_set_that_is_refused_at_the_start_is_followed_no_longer(self) -> None:
        self.user.set(self.level, -1)
        with self.assertRaises(ParameterError):
            self.make()
        self.assert_not_followed()

    def test_update_during_a_read_is_kept(self) -> None:
        live = self.start()
        levels = self.levels_of(live)

        def update() -> None:
            live.update(level=live.values.level + 10.0)
            if live.values.level < 100.0:
                self.server.after_read = update

        self.server.after_read = update
        self.user.set(self.level, 2.0)
        wait_until(lambda: live.values.level > 100.0, lambda: str(live.values))
        self.assert_ends_with(live, level=live.values.level)
        self.assertEqual(levels, sorted(levels))

    def test_update_to_the_value_in_force_replaces_a_value_set_just_before(self) -> None:
        live = self.start()
        before = live.values.level

        def update() -> None:
            if self.user.get(self.level) == 5.0:
                live.update(level=before)
            else:
                self.server.after_read = update

        self.server.after_read = update
        self.user.set(self.level, 5.0)
        self.assert_ends_with(live, level=before)

    @unittest.skipUnless(reconfigure.AVAILABLE, "dynamic_reconfigure is not installed")
    def test_whole_configuration_keeps_values_set_just_before(self) -> None:
        live = self.start()
        interface = reconfigure.ReconfigureInterface(
            live, partial(rospy.Publisher, queue_size=1), rospy.Service
        )
        self.addCleanup(interface.close)
        set_all = rospy.ServiceProxy(self.key + "/set_parameters", reconfigure.Reconfigure)

        def change_title() -> None:
            if self.user.get(self.level) == 5.0:
                set_all(reconfigure.config_of({"level": live.values.level, "title": "new"}))
            else:
                self.server.after_read = change_title

        self.server.after_read = change_title
        self.user.set(self.level, 5.0)
        self.assert_ends_with(live, level=5.0, title="new")

    # It ends with the last part, not with the limit.
    @mock.patch.object(watcher, "SETTLE_LIMIT_S", 2.0 * TIMEOUT_S)
    def test_change_that_is_half_done_is_waited_for(self) -> None:
        live = self.start()
        levels = self.levels_of(live)

        parts = iter(["second", "third", "last"])

        def go_on() -> None:
            if self.user.get(self.level) == 5.0:
                self.user.set(self.key + "/title", next(parts))
            if self.user.get(self.key + "/title") != "last":
                self.server.after_read = go_on

        self.server.after_read = go_on
        self.user.set(self.level, 5.0)
        self.assert_ends_with(live, level=5.0, title="last")
        # Of the other two, one goes up and one down at the end. It is reported once in force.
        wait_until(lambda: len(levels) >= 3, lambda: str(levels))
        self.assertEqual(len(levels), 3)

    @mock.patch.object(reconciler, "HALF_DONE_S", TIMEOUT_S)
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

    def test_update_that_cannot_be_written_has_no_effect(self) -> None:
        live = self.start(level=2.0)
        self.server.before_write = fail
        with self.assertRaises(MasterUnreachable):
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
        self.restart_master(self.key)
        self.assert_ends_with(live, level=2.0, title="kept", marks=[])

    def test_repeated_invalid_value_is_refused_again(self) -> None:
        live = self.start(level=2.0)
        for number in range(1, 4):
            self.user.set(self.level, -1)
            self.user.wait_for(self.level, 2.0)
            # It is warned of when the value is back already.
            wait_until(lambda: len(self.warnings.texts) >= number, lambda: self.warnings.texts)
        self.assert_ends_with(live, level=2.0)
        self.assertEqual(len(self.warnings.texts), 3, self.warnings.texts)

    def test_repeated_invalid_value_without_a_notification(self) -> None:
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
                lambda: f"{live.values.level}, on the server {self.user.get(self.level)}",
            )
        self.assert_ends_with(live, level=34.0)

    def test_valid_then_invalid_value_ends_on_the_valid_one_at_any_pace(self) -> None:
        live, pace = self.start(), random.Random(2)
        for good in range(10, 30):
            self.user.set(self.level, good)
            time.sleep(pace.choice([0.0, 0.02, 0.1]) * pace.random())
            self.user.set(self.level, -good)
            wait_until(
                lambda: live.values.level == good and self.user.get(self.level) == good,
                lambda: f"{live.values.level}, on the server {self.user.get(self.level)}",
            )
        self.assert_ends_with(live, level=29.0)

    def test_valid_and_invalid_changes_are_reported_in_order(self) -> None:
        live, onlooker = self.start(), self.look_on()
        self.warnings.setLevel(logging.INFO)

        def set_both() -> None:
            self.user.set(self.level, 5.0)
            self.user.set(self.level, -1.0)
            # The next read could come before the notifications, and see the last value alone.
            told = [("level", 5.0), ("level", -1.0)]
            wait_until(
                lambda: onlooker.watched.pushed == told, lambda: str(onlooker.watched.pushed)
            )

        self.server.after_read = set_both
        self.watcher.wake()
        self.assert_ends_with(live, level=5.0)
        changed, refused = [text for text in self.warnings.texts if self.level in text]
        self.assertEqual(changed, f"{self.level}: 1 -> 5")
        self.assertIn("refused -1: must be", refused)
        self.assertIn("; in force is level=5", refused)

    def test_changes_arrive_while_a_slider_is_moved(self) -> None:
        live = self.start()
        levels = self.levels_of(live)
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

    @mock.patch.object(reconciler, "BURST", 3)
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
            wait_until(lambda: answers[0] >= 6, lambda: f"{answers[0]} answers")
            self.user.set(self.key + "/title", "through")
            wait_until(lambda: live.values.title == "through", lambda: str(live.values))
        finally:
            end.set()
            rival.join()
        # The first one is the rival's own, and so is one after the last put-back.
        self.assertLessEqual(answers[0], reconciler.BURST + 1 + time.monotonic() - begin)
        self.assertLessEqual(len(self.warnings.texts), answers[0])
        self.assert_ends_with(live, level=2.0, title="through")

    def test_listener_may_change_values(self) -> None:
        live = self.start()
        told: List[GaugeParameters] = []
        live.add_listener(lambda: live.update(count=int(live.values.level)))
        live.add_listener(lambda: told.append(live.values))
        self.user.set(self.level, "5")
        wait_until(lambda: told, lambda: "no callback is called")
        wait_until(lambda: self.told()["count"] == 5, lambda: str(self.told()))
        self.assertEqual({(values.level, values.count) for values in told}, {(5.0, 5)})

    def test_listener_that_raises_does_not_stop_the_others(self) -> None:
        live = self.start()
        levels: List[float] = []

        def exit_with_status() -> None:
            raise SystemExit(1)

        live.add_listener(lambda: [][0])
        live.add_listener(exit_with_status)
        remove = live.add_listener(lambda: levels.append(live.values.level))
        for level in (5.0, 6.0):
            self.user.set(self.level, level)
            wait_until(lambda: levels[-1:] == [level], lambda: str(levels))
        live.update(level=7.0)
        self.assertEqual(levels, [5.0, 6.0, 7.0])
        remove()
        live.update(level=8.0)
        self.assertEqual(levels, [5.0, 6.0, 7.0])
        self.assertEqual(
            len([text for text in self.warnings.texts if "listener failed" in text]), 8
        )

    def test_update_under_a_lock_that_a_listener_wants(self) -> None:
        live, lock, listening = self.start(), threading.RLock(), threading.Event()
        seen: List[float] = []

        def listen() -> None:
            listening.set()
            with lock:
                seen.append(live.values.level)

        live.add_listener(listen)

        def update() -> None:
            with lock:
                self.user.set(self.level, 5.0)
                # The watcher's thread waits for the lock, which is held here.
                listening.wait(TIMEOUT_S)
                live.update(level=6.0)

        updater = threading.Thread(target=update, daemon=True)
        updater.start()
        updater.join(2.0 * TIMEOUT_S)
        self.assertFalse(updater.is_alive(), "update() hangs")
        wait_until(lambda: len(seen) == 2, lambda: str(seen))
        self.assertEqual(seen, [6.0, 6.0])
        self.assert_ends_with(live, level=6.0)

    def test_undeclared_key_is_followed(self) -> None:
        heard: List[Any] = []
        key = self.key + "/Message"
        self.user.set(key, "first")
        followed = FollowedParameter(key, self.watcher, heard.append)
        self.addCleanup(followed.close)
        self.assertEqual(followed.first(), "first")
        followed_parameter.open_all([followed])
        for value in ("second", 3, ["4"]):
            self.user.set(key, value)
            wait_until(lambda: heard[-1:] == [value], lambda: str(heard))
        self.restart_master(key)
        self.assert_stays(lambda: heard == ["second", 3, ["4"]])
        self.user.set(key, "fifth")
        wait_until(lambda: heard[-1] == "fifth", lambda: str(heard))
        followed.report_again()
        wait_until(lambda: heard[-2:] == ["fifth", "fifth"], lambda: str(heard))
        self.user.delete(key)
        wait_until(lambda: heard[-1] is None, lambda: str(heard))

    def restart_master(self, key: str) -> None:
        """Make a read the first of a new master, without values and subscriptions."""

        def lose() -> None:
            self.server.unsubscribe({key})
            self.user.delete(key)

        self.server.restart = lose
        self.watcher.wake()
        wait_until(lambda: self.server.restart is None, lambda: "the server is not read")

    def assert_stays(self, condition: Callable[[], bool]) -> None:
        """Check that a condition holds for as long as two reads of the server take."""
        end = time.monotonic() + 2.2
        while time.monotonic() < end:
            self.assertTrue(condition())
            time.sleep(0.05)

    def test_many_are_opened_in_a_few_requests(self) -> None:
        keys = [f"{self.key}/{number}" for number in range(40)]
        self.user.set(keys[3] + "/level", 3.0)
        requests: List[str] = []
        request = self.server._request_part

        def count(calls: Any) -> Any:
            requests.append(threading.current_thread().name)
            return request(calls)

        with mock.patch.object(self.server, "_request_part", count):
            with self.watcher.reading_ahead(keys):
                many = [LiveParameters(GaugeParameters, key, self.watcher) for key in keys]
            open_all(many)
        for live in many:
            self.addCleanup(live.close)
        # One read ahead, then: subscribe, read, write. The watcher itself reads once a second.
        ours = [name for name in requests if name != "parameter_watcher"]
        self.assertLessEqual(len(ours), 12)
        self.assertEqual([live.values.level for live in many[2:5]], [1.0, 3.0, 1.0])
        self.assertEqual(self.user.get(keys[-1] + "/marks"), [1.0, 2.0])
        self.user.set(keys[-1] + "/level", 4.0)
        wait_until(lambda: many[-1].values.level == 4.0, lambda: str(many[-1].values))

    def test_key_that_was_never_cached_is_notified_of(self) -> None:
        onlooker = self.look_on()
        self.user.set(self.key + "/new/leaf", 5)
        wait_until(lambda: onlooker.pushed, lambda: "rospy keeps the notification for itself")
        self.assertEqual(onlooker.pushed, [("new/leaf", 5)])

    def test_cached_reads_in_the_same_process_have_no_effect(self) -> None:
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
                lambda: f"{value} is not in the cache",
            )

    def test_exception_in_one_follower_does_not_stop_the_others(self) -> None:
        def break_down(_seen: object) -> bool:
            raise ZeroDivisionError

        def leave(_raw: object) -> bool:
            raise SystemExit(1)

        broken = [
            WatchedKey(self.key + "_broken", lambda raw: False, break_down),
            WatchedKey(self.key + "_leaving", leave, lambda seen: True),
        ]
        self.watcher.open(broken)
        self.addCleanup(self.watcher.close, *broken)
        live = self.start()
        self.user.set(broken[0].key, 1)
        self.user.set(self.level, 5.0)
        wait_until(lambda: live.values.level == 5.0, lambda: str(live.values))
        # Keys without notifications are read once a second, in one request.
        self.user.master.setParam(rospy.get_name(), self.level, 6.0)
        wait_until(lambda: live.values.level == 6.0, lambda: str(live.values))
        for name in ("ZeroDivisionError", "SystemExit"):
            wait_until(
                lambda: [text for text in self.warnings.texts if name in text],
                lambda: str(self.warnings.texts),
            )


def fail() -> None:
    raise MasterUnreachable("for once")


def to_wire_dict(values: GaugeParameters) -> Any:
    return {name: to_wire(value) for name, value in values.as_dict().items()}


if __name__ == "__main__":
    rospy.init_node("races")
    rosrun("nodekit", "live_parameters_races", Races)
