#!/usr/bin/env python3
"""The page in a browser: plot, trigger, measurements, files, mask and parameters.

The pages of robots and bags, and the page's modules, are tested in the same browser.
"""

import csv
import math
import re
import subprocess
import threading
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, List, Tuple
from urllib.parse import unquote
from urllib.request import urlopen

import rosbag
import rospy
from browsing.page_test import PROCESSED, SIGNAL, PageTest
from browsing.panel_test import GENERATOR, PanelTest, row
from browsing.waiting import wait_until
from selenium.webdriver.common.keys import Keys
from test_page_bag import Bag  # noqa: F401
from test_page_modules import Modules  # noqa: F401
from test_page_robots import PageRobots  # noqa: F401

from basic_comms.msg import signal_msg
from nodekit.testing.running import extended, rosrun


class Page(PageTest):
    """Use of the plot."""

    def test_traces_move_until_paused(self) -> None:
        self.assertEqual(self.browser.driver.title, "topic_scope")
        self.wait_moving()
        self.browser.keys(Keys.SPACE)
        self.assertEqual(self.browser.text("#run"), "Run")
        self.wait_still()
        self.browser.find("#run").click()
        self.wait_moving()

    def test_measures_the_traces(self) -> None:
        wait_until(
            lambda: (
                abs(self.cell(SIGNAL, "frequency") - 1.0) < 1e-4
                and abs(self.cell(SIGNAL, "rate") - 100.0) < 10.0
                and abs(self.cell(SIGNAL, "max") - 2.0) < 0.05
                and abs(self.cell(PROCESSED, "min")) < 0.05
            ),
            lambda: self.browser.text("#legend"),
        )

    @extended
    def test_csv_equals_a_bag(self) -> None:
        self.browser.choose("#window", "2")
        with TemporaryDirectory() as folder:
            path = Path(folder, "recorded.bag")
            with rosbag.Bag(str(path), "w") as bag:
                lock = threading.Lock()
                count = [0]

                def record(message: Any) -> None:
                    with lock:
                        bag.write("/signal", message)
                        count[0] += 1

                subscriber = rospy.Subscriber("/signal", signal_msg, record)
                wait_until(lambda: count[0] > 300, lambda: f"{count[0]} messages")
                self.browser.keys(Keys.SPACE)
                shown = self.samples()
                more = count[0] + 50  # the samples of the page are in the bag by then
                wait_until(lambda: count[0] > more, lambda: f"{count[0]} messages")
                subscriber.unregister()
                with lock:
                    pass
            with rosbag.Bag(str(path)) as bag:
                recorded = [repr(message.signal_y) for _, message, _ in bag.read_messages()]
        values = [row[0] for _, row in shown if row[0]]
        self.assertGreater(len(values), 50)
        # Periods differ only by rounding: the first value may occur several times.
        starts = [index for index, value in enumerate(recorded) if value == values[0]]
        self.assertIn(values, [recorded[start : start + len(values)] for start in starts])

    @extended
    def test_single_trigger_holds_at_the_crossing(self) -> None:
        self.browser.choose("#window", "1")
        level = self.browser.find("#trigger-level")
        self.browser.choose("#trigger-mode", "single")
        level.clear()
        level.send_keys("0.7", Keys.ENTER)
        wait_until(lambda: self.browser.text("#run") == "Run", lambda: "it does not hold")
        self.assertEqual(self.browser.text("#trigger-state"), "triggered")
        self.wait_still()
        rows = [(time, float(row[0])) for time, row in self.samples() if row[0]]
        # The crossing is in the middle of the window of one second, where the axis has its zero.
        query = str(self.browser.find("#csv").get_property("href"))
        held = float(query.partition("start=")[2].partition("&")[0]) + 0.5
        (before, low), (after, high) = next(
            pair for pair in zip(rows, rows[1:]) if pair[0][1] < 0.7 <= pair[1][1]
        )
        crossing = before + (0.7 - low) / (high - low) * (after - before)
        if after - before > 0.03:  # at its second sample if this is a gap, as on a busy machine
            crossing = min(crossing, after, key=lambda one: abs(one - held))
        self.assertAlmostEqual(crossing, held, delta=1e-3)
        self.browser.find("#run").click()  # not by a key: the link to the file has the focus
        self.assertIn(self.browser.text("#trigger-state"), ("armed", "triggered"))
        wait_until(lambda: self.browser.text("#run") == "Run", lambda: "it does not hold again")

    @extended
    def test_a_formula_is_checked_as_it_is_typed_then_drawn_measured_and_saved(self) -> None:
        self.browser.keys("a", "=hypot(a, delay(a,.25)) + b*(0")
        problem = self.browser.find("#chooser-note")
        wait_until(lambda: problem.text == 'missing ")"', lambda: problem.text)
        listed = self.browser.text("#chooser-list")
        self.assertIn(f"a is {SIGNAL}\n\nb is {PROCESSED}", listed)
        self.assertIn("lowpass", listed)
        name = f"=hypot({SIGNAL}, delay({SIGNAL}, .25)) + {PROCESSED} * (0)"
        self.browser.keys(")")
        self.browser.wait_for(f"#chooser-list input[aria-label='{name}']")
        self.assertEqual(problem.text, "")
        self.browser.keys(Keys.ENTER, Keys.ESCAPE)
        # A sine of the amplitude 2, and the same a quarter of its period later: a circle.
        wait_until(
            lambda: all(abs(self.cell(name, part) - 2.0) < 0.01 for part in ("min", "max")),
            lambda: self.browser.text("#legend"),
        )
        self.browser.find("#csv").click()
        cells: List[Tuple[str, float]] = []

        def has_many_cells() -> bool:
            # The end of the address is the page's end of then: more rows need a newer address.
            address = str(self.browser.find("#csv").get_attribute("href"))
            with urlopen(address, timeout=10) as answer:
                rows = csv.DictReader(answer.read().decode().splitlines())
                cells[:] = [(row[SIGNAL], float(row[name])) for row in rows if row[name]]
            return len(cells) > 100

        wait_until(has_many_cells, lambda: str(len(cells)))
        self.assertTrue(all(beside for beside, _ in cells), "not in the row of its first operand")
        inside = [value for _, value in cells if math.isfinite(value)]
        self.assertLess(max(abs(value - 2.0) for value in inside), 0.01)
        driver = self.browser.driver
        wait_until(lambda: name in unquote(driver.current_url), lambda: driver.current_url)
        driver.refresh()
        self.browser.wait_for(f"#legend tr[data-field='{name}']")

    @extended
    def test_a_mask_counts_then_stops_and_saves_at_the_first_failure(self) -> None:
        self.browser.find(f"[aria-label='more of {PROCESSED}']").click()
        self.browser.choose("#mask-around", SIGNAL)
        self.browser.find("#mask-value").send_keys(Keys.CONTROL + "a")
        self.browser.find("#mask-value").send_keys("5")
        self.browser.find("#mask-begin").click()
        result = self.browser.find("#mask-result")
        pattern = r"mask: \d{2,} samples inside, 0 outside.*"
        wait_until(lambda: re.fullmatch(pattern, result.text) is not None, lambda: result.text)
        upper = f"=highest({SIGNAL}, 0.05) + 5.0"
        wait_until(
            lambda: abs(self.cell(upper, "max") - 7.0) < 0.01, lambda: self.browser.text("#legend")
        )
        self.assertEqual(self.browser.text("#run"), "Pause")
        # 2 sin and 1 + cos are up to 3.2 apart.
        self.browser.find(f"[aria-label='more of {PROCESSED}']").click()
        self.browser.choose("#mask-around", SIGNAL)
        self.browser.find("#mask-value").send_keys(Keys.CONTROL + "a")
        self.browser.find("#mask-value").send_keys("0.5")
        self.browser.find("#mask-begin").click()
        wait_until(lambda: self.browser.text("#run") == "Run", lambda: result.text)
        self.assertNotIn(" 0 outside", result.text)
        head = self.browser.downloaded("mask_failure.csv").read_text().splitlines()[0]
        self.assertIn(f'{PROCESSED},{SIGNAL},"=lowest({SIGNAL}, 0.05) - 0.5"', head)
        self.browser.find("#mask-end").click()
        self.assertFalse(result.is_displayed())


class Panels(PanelTest):
    """Use of the panels."""

    def test_a_slider_changes_the_parameter_and_the_topic(self) -> None:
        slider = self.browser.find(row("frequency") + " input[type=range]")
        before = self.slider("frequency")
        slider.send_keys(*[Keys.ARROW_RIGHT] * 5)
        after = self.slider("frequency")
        self.assertGreater(after, before)
        self.wait_parameter("frequency", after)
        wait_until(
            lambda: (
                abs(rospy.wait_for_message("/signal", signal_msg, timeout=10.0).frequency - after)
                < 1e-6
            ),
            lambda: f"the topic has another frequency than {after:g}",
        )

    def test_rosparam_set_moves_the_slider(self) -> None:
        subprocess.run(["rosparam", "set", GENERATOR + "/frequency", "11.5"], check=True)
        self.wait_value("frequency", 11.5)
        subprocess.run(["rosparam", "set", GENERATOR + "/waveform", "square"], check=True)
        select = row("waveform") + " select"
        wait_until(lambda: self.browser.value(select) == "square", lambda: "no square")

    def test_rejected_value_is_explained_and_stays_for_correction(self) -> None:
        for nonsense in ("-1", "large"):
            field = self.type_in("amplitude", nonsense)
            self.wait_refused("amplitude", nonsense, "must be", "In force: 2;")
            self.assertEqual(self.browser.value(field), nonsense)
            self.assertEqual(self.slider("amplitude"), 2.0)
            self.assertEqual(rospy.get_param(GENERATOR + "/amplitude"), 2.0)
        self.browser.find(field).send_keys(Keys.BACKSPACE)
        self.browser.find(field).send_keys(Keys.ESCAPE)
        self.wait_value("amplitude", 2.0)
        self.type_in("amplitude", "3")
        self.wait_parameter("amplitude", 3.0)
        self.assertEqual(self.browser.text(row("amplitude") + " .refusal"), "")

    def test_enable_and_reset(self) -> None:
        panel = f".panel[data-node='{GENERATOR}'] "
        status = panel + "summary .status"
        wait_until(
            lambda: self.browser.text(status) == "running", lambda: self.browser.text(status)
        )
        self.browser.find(panel + "[aria-label$='enable: Disable']").click()
        wait_until(lambda: self.browser.text(status) == "idle", lambda: self.browser.text(status))
        wait_until(
            lambda: "stopped" in self.browser.text(panel + ".services"),
            lambda: self.browser.text(panel + ".services"),
        )
        stopped = rospy.wait_for_message("/signal", signal_msg, timeout=10.0)
        self.assertEqual(stopped.amplitude, 0.0)
        self.browser.find(panel + "[aria-label$='enable: Enable']").click()
        self.browser.find(panel + "[aria-label$='reset: Reset']").click()
        wait_until(
            lambda: "start at 0 again" in self.browser.text(panel + ".services"),
            lambda: self.browser.text(panel + ".services"),
        )


if __name__ == "__main__":
    rospy.init_node("test_page")
    rosrun("topic_scope", "page", "test_page")
