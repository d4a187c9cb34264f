"""Measurements and charts of the page."""

import itertools
import math
import re
import threading
import time
from typing import Any, Dict, List, Tuple
from urllib.parse import parse_qs
from urllib.request import urlopen

import numpy
import rospy
from browsing.page_test import FRESH, PROCESSED, SIGNAL, PageTest
from browsing.waiting import wait_until
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from std_msgs.msg import Float64, Float64MultiArray, Header, Int32

from nodekit.testing.processes import hanging

from geometry_msgs.msg import Point, PointStamped  # isort: skip

SINE = "/sine/point/x"
#: Position of an element, in fractional pixels.
_BOX = "return document.querySelector(arguments[0]).getBoundingClientRect().toJSON()"
#: Watch for the least number that a cell shows: a count that restarts is soon high again.
_LEAST = """
const [cell] = arguments; window.least = 1e9;
new MutationObserver(() => {
    const shown = document.querySelector(cell)?.textContent || 1e9;
    window.least = Math.min(window.least, Number(shown));
}).observe(document.querySelector('#over-time'),
           {subtree: true, childList: true, characterData: true});
"""


class Plots(PageTest):
    """Measurements, charts and plots of traces."""

    def test_chosen_measurements_and_span_between_cursors(self) -> None:
        self.browser.keys("m")
        self.browser.wait_for("#measures")
        for name in ("vpp", "deviation", "rise", "duty", "phase"):
            self.browser.press(f"[data-figure='{name}']")
        self.browser.keys(Keys.ESCAPE)
        # A sine of amplitude 2 and 1 Hz, and one that leads by a quarter of a period.
        expected = {"vpp": 4.0, "deviation": math.sqrt(2.0), "rise": 0.295, "duty": 50.0}
        for name, value in expected.items():
            wait_until(
                lambda: abs(self.cell(SIGNAL, name) - value) < 0.05 * value,
                lambda: (name, self.browser.text("#legend")),
            )
        wait_until(
            lambda: (
                abs(self.cell(PROCESSED, "phase") - 90.0) < 20.0
                and abs(self.cell(SIGNAL, "phase")) < 1e-3
            ),
            lambda: self.browser.text("#legend"),
        )
        self.browser.choose("#window", "1")
        times = ".dygraph-axis-label-x"  # cursors are placed on the axis as it is drawn
        wait_until(
            lambda: "−4" not in self.browser.text(times).split(), lambda: self.browser.text(times)
        )
        self.browser.press("#cursors")
        self.browser.keys("m")
        self.browser.wait_for("#measures-between").click()
        self.browser.keys(Keys.ESCAPE)
        # Within 0.3 s of the period.
        wait_until(
            lambda: self.cell(SIGNAL, "vpp") < 3.3 and math.isnan(self.cell(SIGNAL, "frequency")),
            lambda: self.browser.text("#legend"),
        )
        self.wait_certainty("frequency", "not measurable: fewer than two periods in the span")
        self.wait_certainty("min", "")

    def test_statistics_over_time_until_a_restart(self) -> None:
        self.browser.keys("m")
        self.browser.wait_for("#measures-over-time").click()
        self.browser.press("[data-figure=cycle_rms]")
        self.browser.keys(Keys.ESCAPE)

        def varied(figure: str, column: str) -> float:
            row = f"#over-time [data-row='{SIGNAL} {figure}'] [data-cell={column}]"
            text = self.browser.text(row)
            return float(text.replace("−", "-")) if text else math.nan

        # Of a sine of the amplitude 2.
        wait_until(
            lambda: (
                varied("cycle_rms", "count") > 4
                and abs(varied("cycle_rms", "mean") - math.sqrt(2.0)) < 0.01
                and varied("cycle_rms", "sigma") < 0.01
                and varied("max", "min") <= varied("max", "mean") <= varied("max", "max") <= 2.0
            ),
            lambda: self.browser.text("#over-time"),
        )
        self.restore()  # it is in the address
        counts = [math.nan]

        def are_several() -> bool:
            counts.append(varied("rate", "count"))
            return counts[-1] > 4

        wait_until(are_several, lambda: self.browser.text("#over-time"))
        before = counts[-1]
        self.browser.run(_LEAST, f"#over-time [data-row='{SIGNAL} rate'] [data-cell=count]")
        self.browser.press("#over-time-restart")
        wait_until(
            lambda: self.browser.run("return window.least") < before,
            lambda: self.browser.text("#over-time"),
        )
        self.browser.keys("m")
        self.browser.wait_for("#measures-over-time").click()
        self.browser.keys(Keys.ESCAPE)
        self.assertFalse(self.browser.find("#over-time").is_displayed())

    def wait_certainty(self, figure: str, wanted: str) -> None:
        """Wait until the table shows a figure's uncertainty, or why it is missing."""
        cell = f"#legend tr[data-field='{SIGNAL}'] [data-cell={figure}]"
        wait_until(
            lambda: self.browser.find(cell).get_attribute("title") == wanted,
            lambda: self.browser.find(cell).get_attribute("title"),
        )

    def drawn(self) -> int:
        """Return a checksum of the painted chart."""
        return self.browser.picture("#chart canvas")

    def written(self) -> str:
        """Return the texts drawn since the last call, one per line."""
        take = "const all = window.written; window.written = []; return all.join('\\n')"
        return str(self.browser.run(take))

    def test_spectra_and_xy(self) -> None:
        self.watch_writing()
        self.browser.keys("k")
        seen = [""]

        def marked() -> bool:
            seen[0] = self.written()
            peaks = re.findall(r"^([\d.]+) ± [\d.]+ Hz, ([\d.]+) dB$", seen[0], re.MULTILINE)
            return any(
                abs(float(hertz) - 1.0) < 0.01 and abs(float(level) - 20 * math.log10(2.0)) < 0.2
                for hertz, level in peaks
            )

        wait_until(marked, lambda: seen)
        self.browser.keys(Keys.SPACE)
        # A paused chart needs no message of the server, so it is redrawn immediately.
        self.browser.choose("[aria-label='spectrum scale']", "linear")
        self.assertRegex(self.written(), r"(?m)^(0\.99|1\.0)\d* ± [\d.]+ Hz, (1\.9|2\.0)\d\d$")
        self.browser.press("#run")
        self.browser.choose("[aria-label='spectrum scale']", "dB")
        wait_until(marked, lambda: seen)
        # A picture for a report has its numbers, the measurements, and the date.
        self.browser.press("#png")
        self.browser.downloaded("scope.png")
        picture = self.written().split("\n")
        self.assertTrue(any(re.match(r"\d{4}-\d\d-\d\d, ", text) for text in picture), picture)
        self.assertIn("RMS", picture)
        self.assertTrue(any(text.endswith(" dB") for text in picture), picture)
        self.browser.keys("k")
        self.browser.wait_for("[aria-label='horizontal trace']")
        first = self.drawn()
        wait_until(
            lambda: PROCESSED in self.written().split("\n") and self.drawn() != first,
            self.written,
        )
        self.browser.press("#run")
        self.written()
        self.browser.press(".chart-controls input")
        self.assertIn(PROCESSED, self.written().split("\n"))
        # It is in the address.
        wait_until(
            lambda: "xy" in self.browser.driver.current_url,
            lambda: self.browser.driver.current_url,
        )
        self.restore()
        self.browser.wait_for("[aria-label='horizontal trace']")
        self.browser.keys("k")
        self.assertFalse(self.browser.find("#chart").is_displayed())

    def test_computed_traces_are_shown(self) -> None:
        name = f"{SIGNAL}.derivative"
        self.browser.keys("a", name)
        wait_until(
            lambda: self.browser.text("#chooser-list") == f"{name}\nas typed",
            lambda: self.browser.text("#chooser-list"),
        )
        self.browser.keys(Keys.ENTER)
        search = self.browser.find("#chooser-search")
        search.clear()
        search.send_keys(f"{name}@received-/later/x[1]")
        wait_until(
            lambda: self.browser.text("#chooser-list") == f"{name}@received-/later/x[1]\nas typed",
            lambda: self.browser.text("#chooser-list"),
        )
        search.clear()
        search.send_keys("signal_y")
        self.browser.wait_for(f"[aria-label='derive a trace from {SIGNAL}']")
        self.browser.choose(f"[aria-label='derive a trace from {SIGNAL}']", "difference")
        self.browser.keys(Keys.ESCAPE)
        self.browser.press(f"[aria-label='more of {SIGNAL}']")
        self.browser.choose("#trace-less", PROCESSED)
        self.browser.press("#trace-difference")
        self.assertFalse(self.browser.find("#trace").is_displayed())
        less = f"{SIGNAL}-{PROCESSED}"
        self.assertFalse(
            self.browser.find(f"[aria-label='timestamp source of {less}']").is_enabled()
        )
        # Of 2 sin and 1 + cos.
        wait_until(
            lambda: (
                abs(self.cell(less, "max") - (math.sqrt(5.0) - 1.0)) < 0.3
                and abs(self.cell(less, "mean") + 1.0) < 0.1
            ),
            lambda: self.browser.text("#legend"),
        )
        # Of a sine of the amplitude 2 and 1 Hz, 100 times a second.
        for field, peak in ((name, 4 * math.pi), (f"{SIGNAL}.difference", 0.04 * math.pi)):
            wait_until(
                lambda: (
                    abs(self.cell(field, "max") - peak) < 0.01 * peak
                    and abs(self.cell(field, "min") + peak) < 0.01 * peak
                ),
                lambda: self.browser.text("#legend"),
            )

    def test_hidden_trace_is_not_sent_and_returns_with_its_history(self) -> None:
        wait_until(
            lambda: abs(self.cell(SIGNAL, "max") - 2.0) < 0.01,
            lambda: self.browser.text("#legend"),
        )
        shown = self.browser.find(f"[aria-label='show {SIGNAL}']")
        shown.click()
        wait_until(
            lambda: math.isnan(self.cell(SIGNAL, "max")), lambda: self.browser.text("#legend")
        )
        self.assertFalse(math.isnan(self.cell(PROCESSED, "max")))
        # Paused, so that it returns unchanged. Not by a key: the checkbox has the focus.
        self.browser.press("#run")
        wait_until(lambda: self.browser.text("#run") == "Run", lambda: "it runs on")
        picture = self.browser.picture()
        self.browser.press(f"[aria-label='show {SIGNAL}']")
        wait_until(
            lambda: (
                abs(self.cell(SIGNAL, "max") - 2.0) < 0.01 and self.browser.picture() != picture
            ),
            lambda: self.browser.text("#legend"),
        )

    def test_arrow_points_to_a_level_out_of_view(self) -> None:
        tools = self.browser.find("#scope-view .tools").size
        self.browser.choose("#window", "1")
        self.browser.choose("#trigger-mode", "auto")
        level = self.browser.find("#trigger-level")
        level.clear()
        level.send_keys("50", Keys.ENTER)
        arrow = self.browser.wait_for(".beyond.above")
        self.assertIn("T 50.000", arrow.text)
        # No crossings: the mode auto runs freely.
        first = self.browser.picture()
        wait_until(lambda: self.browser.picture() != first, lambda: "the picture does not change")
        self.browser.press("#show-trigger")
        for name, value in (("hysteresis", "0.5"), ("holdoff", "0.1"), ("position", "20")):
            field = self.browser.wait_for(f"#trigger-{name}")
            field.send_keys(Keys.CONTROL + "a")
            field.send_keys(value, Keys.TAB)

        def is_halved() -> bool:  # a crest may not be in view yet
            self.browser.press("#trigger-half")
            return abs(float(self.browser.value("#trigger-level").replace("−", "-"))) < 0.1

        wait_until(is_halved, lambda: self.browser.value("#trigger-level"))
        self.browser.keys(Keys.ESCAPE)
        wait_until(
            lambda: (
                self.browser.text("#trigger-state") == "triggered"
                and not self.browser.find(".beyond").is_displayed()
            ),
            lambda: self.browser.text("#trigger-state"),
        )
        # A fifth of the second is left of the crossing, the zero of the axis.
        wait_until(
            lambda: (
                "0.6" in self.browser.text(".dygraph-axis-label-x").split()
                and "−0.4" not in self.browser.text(".dygraph-axis-label-x").split()
            ),
            lambda: self.browser.text(".dygraph-axis-label-x"),
        )
        # The trigger's state fits the row of the tools, which would lower the plot.
        self.assertEqual(self.browser.find("#scope-view .tools").size, tools)

    def test_columns_keep_the_width_of_their_longest_number(self) -> None:
        """Otherwise names wrap and unwrap, which moves the plot up and down."""
        publisher = rospy.Publisher("/lengths", Float64, queue_size=1, latch=True)
        self.addCleanup(publisher.unregister)
        field = "/lengths/data"
        self.show(fields=[field], measures={**FRESH["measures"], "figures": ["value"]})
        widths = []
        for value in (1.5, -1.25e-100, 2.5):
            publisher.publish(value)
            wait_until(
                lambda: self.cell(field, "value") == value, lambda: self.browser.text("#legend")
            )
            widths.append(self.browser.find("#legend-head .figure").size["width"])
        self.assertLess(widths[0] + 10, widths[1])
        self.assertEqual(widths[1], widths[2])

    def test_missing_field_keeps_its_row_with_a_reason(self) -> None:
        expected = {
            "/signal/nothing": "there is no nothing in basic_comms/signal_msg",
            "/later/data[7]": "the topic does not exist yet",
        }
        for name in expected:
            self.browser.keys("a", name)
            self.browser.wait_for("#chooser-list input")
            self.browser.keys(Keys.ENTER, Keys.ESCAPE)
        for name, text in expected.items():
            row = f"#legend tr.gone[data-field='{name}']"
            wait_until(
                lambda: self.browser.text(f"{row} .badge") == text,
                lambda: self.browser.text("#legend"),
            )
            # All of it can be read.
            cell, badge = self.browser.find(f"{row} .name"), self.browser.find(f"{row} .badge")
            right = cell.rect["x"] + cell.rect["width"]
            self.assertLessEqual(badge.rect["x"] + badge.rect["width"], right)
        publisher = rospy.Publisher("/later", Float64MultiArray, queue_size=1, latch=True)
        self.addCleanup(publisher.unregister)
        publisher.publish(Float64MultiArray(data=[1.0, 2.0]))
        badge = "#legend tr.gone[data-field='/later/data[7]'] .badge"
        wait_until(
            lambda: self.browser.text(badge) == "data has 2 elements now",
            lambda: self.browser.text("#legend"),
        )
        publisher.publish(Float64MultiArray(data=[3.0] * 8))
        wait_until(
            lambda: self.cell("/later/data[7]", "value") == 3.0 and not self.browser.count(badge),
            lambda: self.browser.text("#legend"),
        )

    def panes(self) -> int:
        """Return the number of plots, after checking that only the last has a time axis."""
        count = self.browser.count(".pane")
        below = self.browser.count(".pane:last-child .dygraph-axis-label-x")
        return count if below == self.browser.count(".dygraph-axis-label-x") > 2 else 0

    def drag(self, field: str, up: float, plots: int) -> None:
        """Drag the name of a trace until there is another number of plots.

        :param field: the trace
        :param up: where to, as a fraction of the height of all plots, from below
        :param plots: number of plots after it
        """
        stage = self.browser.find("#stage")

        def is_dragged() -> bool:
            name = self.browser.find(f"#legend tr[data-field='{field}'] .name")
            self.wait_in_place(name, stage)
            there, actions = stage.rect, ActionChains(self.browser.driver)
            actions.click_and_hold(name).move_by_offset(10, -10)
            # In one sequence: the table may still move the name just before it is pressed.
            actions.w3c_actions.pointer_action.move_to_location(
                round(there["x"] + 0.5 * there["width"]),
                round(there["y"] + (1.0 - up) * there["height"]),
            )
            actions.release().perform()
            tried = time.monotonic()
            wait_until(
                lambda: self.panes() == plots or time.monotonic() > tried + 3.0,
                lambda: self.browser.text("#plot"),
            )
            return self.panes() == plots

        wait_until(is_dragged, lambda: self.browser.text("#plot"))

    def test_has_several_plots_over_one_time(self) -> None:
        wait_until(lambda: self.panes() == 1, self.panes)
        self.browser.choose(f"[aria-label='plot of {PROCESSED}']", "2")
        wait_until(lambda: self.panes() == 2, lambda: self.browser.text("#plot"))
        # One plot has negative numbers, the other has none; the edges are the same.
        labels = ".pane:{}-child .dygraph-axis-label-y"
        wait_until(
            lambda: (
                "−2" in self.browser.text(labels.format("first"))
                and "−" not in self.browser.text(labels.format("last"))
            ),
            lambda: self.browser.text("#plot"),
        )
        self.browser.press(f"[aria-label='right axis for {PROCESSED}']")
        wait_until(
            lambda: (
                self.browser.count(".pane:last-child .dygraph-axis-label-y2") > 1
                and not self.browser.count(".dygraph-axis-label-y1")
            ),
            lambda: self.browser.text("#plot"),
        )
        overlay = self.browser.find("#overlay").rect
        for pane in self.browser.driver.find_elements("css selector", ".pane"):
            self.assertLess(overlay["y"], pane.rect["y"] + pane.rect["height"])
            self.assertLess(pane.rect["y"], overlay["y"] + overlay["height"])
        # The level is in the plot of its trace, and stays there.
        self.browser.choose("#trigger-mode", "auto")
        self.browser.choose("#trigger-field", PROCESSED)
        field = self.browser.find("#trigger-level")
        field.send_keys(Keys.CONTROL + "a")
        field.send_keys("1", Keys.ENTER)
        level = self.browser.wait_for(".handle.level")
        lower = self.browser.find(".pane:last-child")

        def beside_middle() -> float:  # of the numbers, not of the times below
            rect = lower.rect
            return abs(float(level.rect["y"] - rect["y"] - 0.45 * rect["height"]))

        wait_until(lambda: beside_middle() < 40.0, lambda: (level.rect, lower.rect))
        self.wait_in_place(level)
        ActionChains(self.browser.driver).drag_and_drop_by_offset(level, 0, -400).perform()
        wait_until(
            lambda: float(self.browser.value("#trigger-level")) > 2.0,
            lambda: self.browser.value("#trigger-level"),
        )
        self.browser.choose("#trigger-mode", "off")
        # All of it is in the address.
        self.browser.press("#show-axes")
        self.browser.wait_for("[aria-label='right axis of plot 2, to']").send_keys("7.5", Keys.TAB)
        self.browser.keys(Keys.ESCAPE)
        wait_until(
            lambda: "7.5" in self.browser.driver.current_url,
            lambda: self.browser.driver.current_url,
        )
        self.restore()
        wait_until(
            lambda: self.panes() == 2 and "6" in self.browser.text(labels.format("last")).split(),
            lambda: self.browser.text("#plot"),
        )
        wait_until(
            lambda: not math.isnan(self.cell(PROCESSED, "max")),
            lambda: self.browser.text("#legend"),
        )
        # By the pointer: an empty plot is removed with its axis; a new plot is added.
        self.drag(PROCESSED, 0.75, 1)
        self.drag(SIGNAL, 0.03, 2)  # onto the label "new plot"
        choice = self.browser.value(f"[aria-label='plot of {SIGNAL}']")
        self.assertEqual(choice, "2")
        # A paused picture is laid out immediately, too, without later changes.
        self.browser.press("#run")
        paused = time.monotonic()
        wait_until(lambda: time.monotonic() > paused + 1.5, lambda: "time does not move")
        self.browser.choose(f"[aria-label='plot of {SIGNAL}']", "1")
        wait_until(lambda: self.panes() == 1, lambda: self.browser.text("#plot"))
        heights = [self.browser.find(one).size["height"] for one in ("#overlay", ".pane")]
        self.assertGreater(heights[0], heights[1] - 60)
        self.browser.run("document.activeElement.blur()")
        self.browser.keys("k")  # another chart has all traces in one plot
        self.assertFalse(self.browser.find("#overlay").is_displayed())

    def strokes(self) -> Any:
        """Return the lines of the next drawing: colours, dashes, points and widths, pixels."""
        return self.browser.driver.execute_async_script(
            "const [done] = arguments; const kind = CanvasRenderingContext2D.prototype;"
            "const { beginPath, moveTo, lineTo, stroke } = kind; const lines = []; let points = [];"
            "kind.beginPath = function() { points = []; return beginPath.call(this); };"
            "kind.moveTo = function(x, y) { points.push([x, y, 0]); moveTo.call(this, x, y); };"
            "kind.lineTo = function(x, y) { points.push([x, y, 1]); lineTo.call(this, x, y); };"
            # All lines of one drawing, which nothing interrupts.
            "const end = () => {"
            "Object.assign(kind, { beginPath, moveTo, lineTo, stroke }); done(lines); };"
            "kind.stroke = function() { if (points.length > 4) {"
            "if (!lines.length) queueMicrotask(end);"
            "lines.push([this.strokeStyle, this.getLineDash(), points, this.lineWidth]); }"
            "return stroke.call(this); };"
            # Redraws, with or without new samples.
            "for (const _ of [0, 1]) document.getElementById('theme').click();"
        )

    def kept_line(self) -> numpy.ndarray:
        """Return the points of the drawn reference: the only thin line."""
        found = [
            points for _, _, points, width in self.strokes() if width == 1 and len(points) > 99
        ]
        self.assertLess(len(found), 2)
        return numpy.array([(x, y) for points in found for x, y, _ in points])

    def at_cursors(self, row: str) -> List[float]:
        """Return the values of a row of the table at both cursors."""
        cells = [self.browser.text(f"#legend tr[{row}] [data-cell='{key}']") for key in "ab"]
        return [math.nan if text == "–" else float(text.replace("−", "-")) for text in cells]

    def test_reference_is_constant_and_can_be_moved_and_removed(self) -> None:
        axis = {"title": "", "low": None, "high": None}
        setup = {
            **{"fields": [SIGNAL, PROCESSED], "window": 5, "baseWindow": 5},
            "axes": {"x": {"title": ""}, "y": {**axis, "low": -5, "high": 5}, "y2": axis},
            "cursors": {"a": -2.1, "b": -1.0},
        }
        self.show(**setup)
        wait_until(self.is_full, lambda: self.browser.text("#legend"))
        self.browser.press("#run")
        trace, reference = f"data-field='{SIGNAL}'", "data-reference='R1'"
        self.wait_figures_stand(trace)
        self.browser.press(f"[aria-label='more of {SIGNAL}']")
        self.browser.wait_for("#trace-keep").click()
        row = self.browser.wait_for(f"#legend tr[{reference}]").text
        self.assertRegex(row, rf"R1 {SIGNAL} kept \d\d:\d\d:\d\d")
        for name in ("rate", "rms", "frequency"):
            cell = f"[data-cell='{name}']"
            text = self.browser.text(f"#legend tr[{trace}] {cell}")
            self.assertEqual(self.browser.text(f"#legend tr[{reference}] {cell}"), text)
        values = self.at_cursors(trace)
        wait_until(lambda: self.at_cursors(reference) == values, lambda: self.at_cursors(reference))
        line = self.kept_line()
        apart = [
            abs(line[:, 1] - numpy.interp(line[:, 0], *numpy.array(points).T[:2])).max()
            for *_, points, width in self.strokes()
            if width > 1 and len(points) > 99
        ]
        self.assertLess(min(apart), 0.5)
        # The trace moves, its reference does not.
        self.browser.press("#run")
        wait_until(
            lambda: abs(self.at_cursors(trace)[0] - values[0]) > 0.1, lambda: self.at_cursors(trace)
        )
        self.assertEqual(self.at_cursors(reference), values)
        self.assertLess(abs(self.kept_line() - line).max(), 0.01)
        # By keys only, up and to the right.
        plot = self.browser.run(_BOX, "#overlay")
        self.browser.find("[aria-label='offset of R1']").send_keys(Keys.DELETE, "1", Keys.TAB)
        wait_until(
            lambda: abs(self.at_cursors(reference)[1] - values[1] - 1.0) < 1e-3,
            lambda: self.at_cursors(reference),
        )
        self.browser.find("[aria-label='delay, s, of R1']").send_keys(Keys.DELETE, "1.1", Keys.TAB)
        wait_until(
            lambda: abs(self.at_cursors(reference)[1] - values[0] - 1.0) < 1e-3,
            lambda: self.at_cursors(reference),
        )
        moved = self.kept_line()
        across, up = 1.1 / 5.0 * plot["width"], plot["height"] / 10.0
        self.assertLess(abs(moved - line - [across, -up]).max(), 0.5)
        self.browser.find("[aria-label='remove R1']").send_keys(Keys.ENTER)
        wait_until(lambda: not len(self.kept_line()), self.kept_line)
        # Another reference is removed with its trace.
        self.browser.press(f"[aria-label='more of {SIGNAL}']")
        self.browser.wait_for("#trace-keep").click()
        self.browser.wait_for(f"#legend tr[{reference}]")
        self.browser.press(f"[aria-label='remove {SIGNAL}']")
        wait_until(
            lambda: not self.browser.count("[data-reference]"), lambda: self.browser.text("#legend")
        )

    def wait_figures_stand(self, row: str) -> None:
        """Wait until a row of the table is unchanged for some measurements."""
        seen = [self.browser.text(f"#legend tr[{row}]")]

        def is_unchanged() -> bool:
            seen.append(self.browser.text(f"#legend tr[{row}]"))
            return len(seen) > 8 and len(set(seen[-8:])) == 1

        wait_until(is_unchanged, lambda: seen[-2:])

    def test_a_trace_has_a_colour_and_a_dash(self) -> None:
        wait_until(lambda: self.cell(SIGNAL, "max") > 1.9, lambda: self.browser.text("#legend"))
        self.browser.press(f"[aria-label='remove {SIGNAL}']")
        self.browser.press(f"[aria-label='more of {PROCESSED}']")
        self.browser.choose("#trace-dash", "dotted")
        self.browser.keys(Keys.ESCAPE)
        # It still has the colour of the second trace.
        expected = ["#c8553d", "#ff8f73"], [2, 3]
        wait_until(
            lambda: any(
                look in expected[0] and dash == expected[1] for look, dash, *_ in self.strokes()
            ),
            lambda: [line[:2] for line in self.strokes()],
        )
        wait_until(
            lambda: "dotted" in self.browser.driver.current_url,
            lambda: self.browser.driver.current_url,
        )
        self.browser.driver.refresh()
        wait_until(
            lambda: any(
                look in expected[0] and dash == expected[1] for look, dash, *_ in self.strokes()
            ),
            lambda: [line[:2] for line in self.strokes()],
        )

    def test_integers_are_drawn_in_steps_and_traces_are_scaled(self) -> None:
        publisher = rospy.Publisher("/steps", Int32, queue_size=10)
        self.addCleanup(publisher.unregister)
        self.browser.press(f"[aria-label='remove {SIGNAL}']")
        self.browser.press(f"[aria-label='show {PROCESSED}']")
        self.browser.keys("a", "/steps/data")
        self.browser.wait_for("#chooser-list input")
        self.browser.keys(Keys.ENTER, Keys.ESCAPE)
        done = threading.Event()

        def publish() -> None:
            for number in itertools.count():
                publisher.publish(number % 4 % 3)  # 0 1 2 0
                if done.wait(0.11):
                    return

        thread = threading.Thread(target=publish)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(done.set)
        field = "/steps/data"
        wait_until(lambda: self.cell(field, "max") == 2.0, lambda: self.browser.text("#legend"))

        def upright() -> List[bool]:
            """Return for each part of the line whether it is parallel to an axis."""
            lines = [points for _, _, points, _ in self.strokes() if len(points) > 9]
            if len(lines) != 1:  # a removed trace may still be drawn
                return []
            (points,) = lines
            return [
                abs(x - before[0]) < 1e-6 or abs(y - before[1]) < 1e-6
                for before, (x, y, is_drawn) in zip(points, points[1:])
                if is_drawn
            ]

        wait_until(lambda: len(upright()) > 20 and all(upright()), upright)
        self.browser.press(f"[aria-label='more of {field}']")
        self.browser.choose("#trace-drawn", "line")
        for name, value in (("gain", "-10"), ("offset", "5.5")):
            number = self.browser.find(f"#trace-{name}")
            number.send_keys(Keys.CONTROL + "a")
            number.send_keys(value, Keys.TAB)
        number.send_keys(Keys.CONTROL + "a")
        number.send_keys("many", Keys.TAB)  # not a number
        self.assertEqual(number.get_property("value"), "5.5")
        self.browser.keys(Keys.ESCAPE)
        wait_until(lambda: not all(upright()), upright)
        label = self.browser.text(f"#legend tr[data-field='{field}'] .scaled")
        self.assertEqual(label, "scaled × −10 + 5.5")
        wait_until(
            lambda: (
                (self.cell(field, "min"), self.cell(field, "max")) == (-14.5, 5.5)
                and "−10" in self.browser.text(".dygraph-axis-label-y")
            ),
            lambda: self.browser.text("#legend"),
        )
        # In words and in pictures, too.
        words = f"{field} {label}"
        wait_until(
            lambda: f"{words}: from −14.500 to 5.5000" in self.browser.text("#plot-text"),
            lambda: self.browser.text("#plot-text"),
        )
        written = self.browser.run(
            "const kind = CanvasRenderingContext2D.prototype; const { fillText } = kind;"
            "const written = []; kind.fillText = (text) => written.push(text);"
            "document.getElementById('png').click(); kind.fillText = fillText; return written;"
        )
        self.browser.downloaded("scope.png")
        self.assertIn(words, written)
        # The level is on the axis, hence scaled, too; a file has the original values.
        self.browser.choose("#trigger-mode", "normal")
        self.browser.choose("#trigger-field", field)
        level = self.browser.find("#trigger-level")
        level.send_keys(Keys.CONTROL + "a")
        level.send_keys("-12", Keys.ENTER)
        wait_until(
            lambda: self.browser.text("#trigger-state") == "triggered",
            lambda: self.browser.text("#trigger-state"),
        )
        with urlopen(self.csv()) as answer:
            rows = [line.split(",") for line in answer.read().decode().split()]
        column = rows[0].index(field)
        self.assertEqual({row[column] for row in rows[1:]} - {""}, {"0.0", "1.0", "2.0"})

    def is_full(self) -> bool:
        """Return whether each trace has samples from the start of the visible span."""
        address = self.csv()
        with urlopen(address) as answer:
            rows = [line.split(",") for line in answer.read().decode().splitlines()[1:]]
        latest = _span(address)[0] + 0.01  # the interval of the slowest
        first = [row for row in rows if float(row[0]) < latest]
        return bool(first) and all(any(cells) for cells in list(zip(*first))[2:])

    def test_sine_is_exact_on_a_busy_machine(self) -> None:
        """Each point of its line is less than a pixel from the true curve.

        The scope gets no processor twice.
        """
        omega, done = 4.0 * math.pi, threading.Event()
        publisher = rospy.Publisher("/sine", PointStamped, queue_size=1000)
        self.addCleanup(publisher.unregister)

        def publish() -> None:
            begin = time.time()
            for number in itertools.count():
                stamp = rospy.Time.from_sec(begin + number / 200.0)
                message = PointStamped(Header(stamp=stamp), Point())
                message.point.x = 2.0 * math.sin(omega * stamp.to_sec())
                publisher.publish(message)
                if done.wait(max(0.0, begin + (number + 1) / 200.0 - time.time())):
                    return

        thread = threading.Thread(target=publish)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(done.set)
        axis = {"title": "", "low": None, "high": None}
        setup = {
            **{"fields": [SINE], "window": 1, "baseWindow": 1},
            "axes": {"x": {"title": ""}, "y": {**axis, "low": -2.5, "high": 2.5}, "y2": axis},
        }
        self.show(**setup)
        for _ in range(2):
            wait_until(lambda: self.cell(SINE, "rate") > 0.0, lambda: self.browser.text("#legend"))
            with hanging(self.scope.pid):
                time.sleep(0.3)
        began = time.monotonic()
        wait_until(
            lambda: (
                self.is_full()
                and time.monotonic() > began + 1.2  # longer than the visible span
                and abs(self.cell(SINE, "frequency") - 2.0) < 2e-4
            ),
            lambda: self.browser.text("#legend"),
        )
        self.browser.press("#run")
        start, end = _span(self.csv())
        far: List[List[float]] = []

        def is_drawn() -> bool:  # samples that were delayed at the pause are added later
            far.append(self.beside_sine(omega, start, end, 2.0 / 5.0))
            return len(far[-1]) == 1 and far[-1][0] < 1.0

        wait_until(is_drawn, lambda: far[-1])

    def beside_sine(self, omega: float, start: float, end: float, height: float) -> List[float]:
        """Return the largest distance of each line from a sine [pixels]; infinite if too short.

        :param omega: of the sine, whose phase counts from the epoch, rad/s
        :param start: the time at the left edge, s
        :param end: the time at the right edge [s]
        :param height: its amplitude, as a fraction of the height of the plot
        """
        plot, canvas = (self.browser.run(_BOX, name) for name in ("#overlay", "#plot canvas"))
        left, top = plot["x"] - canvas["x"], plot["y"] - canvas["y"]
        lines = [line for _, _, line, _ in self.strokes() if len(line) > 50]
        apart = []
        for points in lines:
            line = numpy.array([(x, y) for x, y, _ in points if left <= x <= left + plot["width"]])
            # From edge to edge, except for the delay of the last samples.
            is_whole = line[0, 0] < left + 10.0 and line[-1, 0] > left + 0.5 * plot["width"]
            middles = (line[1:] + line[:-1]) / 2.0
            across = numpy.linspace(-4.0, 4.0, 401)
            far = 0.0 if is_whole else math.inf
            for x, y in numpy.concatenate([line, middles]):
                times = start + (x + across - left) / plot["width"] * (end - start)
                heights = top + (0.5 - height * numpy.sin(omega * times)) * plot["height"]
                far = max(far, float(numpy.hypot(across, heights - y).min()))
            apart.append(far)
        return apart

    def test_texts_of_cursors_pointer_and_table_are_true(self) -> None:
        """Each text has the truth within its ±; a paused page shows samples that arrive later."""
        publisher = rospy.Publisher("/known", PointStamped, queue_size=2000)
        self.addCleanup(publisher.unregister)
        field, at, omega = "/known/point/x@stamp", {"a": -0.73, "b": -0.31}, 6.0 * math.pi
        figures = ["mean", "rms", "frequency", "rise"]
        self.show(
            **{"fields": [field], "window": 1, "baseWindow": 1, "cursors": at},
            measures={**FRESH["measures"], "figures": figures},
        )
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "it is not subscribed to")
        self.browser.press("#run")
        self.wait_drawn()
        end = _span(self.csv())[1]

        def true_at(time_s: float) -> float:
            return 0.25 + 1.5 * math.sin(omega * time_s)

        for number in range(-800, 50):
            message = PointStamped(Header(stamp=rospy.Time.from_sec(end + 0.002 * number)), Point())
            message.point.x = true_at(0.002 * number)
            publisher.publish(message)
        expected = {key: true_at(time_s) for key, time_s in at.items()}
        expected.update(mean=0.25, rms=math.sqrt(0.0625 + 1.125), frequency=3.0)
        expected.update(
            difference=expected["b"] - expected["a"], rise=math.asin(0.8) / 3.0 / math.pi
        )
        cells: Dict[str, Tuple[str, str]] = {}

        def are_true() -> bool:
            for key in expected:
                cell = self.browser.find(f"#legend tr[data-field='{field}'] [data-cell={key}]")
                cells[key] = cell.text, cell.get_attribute("title")
            return all(_is_true(*cells[key], true) for key, true in expected.items())

        wait_until(are_true, lambda: (cells, expected))
        pointer, times = self.under_pointer(500).split("\n")[0], (-1.0, 0.0)
        box = self.browser.run(_BOX, "#overlay")
        time_s = times[0] + (500 - box["x"]) / box["width"]
        value, uncertainty = self.under_pointer(500).split()[-3::2]
        self.assertAlmostEqual(float(pointer.split()[0].replace("−", "-")), time_s, delta=1e-3)
        self.assertTrue(_is_true(value, f"± {uncertainty}", true_at(time_s)), (value, time_s))
        # Ten times as long: five or six samples in a pixel.
        self.browser.choose("#window", "10")
        cell = f"#legend tr[data-field='{field}'] [data-cell=a]"
        reading = re.compile(r"(\d) samples, (−?[0-9.]+) … (−?[0-9.]+)$")
        wait_until(lambda: reading.match(self.browser.text(cell)), lambda: self.browser.text(cell))
        count, *ends = reading.match(self.browser.text(cell)).groups()  # type: ignore[union-attr]
        low, high = (float(one.replace("−", "-")) for one in ends)
        self.assertTrue(int(count) > 2 and low < high, self.browser.text(cell))
        self.assertLess(high - low, 1.5 * omega * 10.0 / box["width"])
        self.assertTrue(low - 0.06 < expected["a"] < high + 0.06, (low, expected["a"], high))
        self.browser.press("#show-axes")
        self.browser.press("[aria-label='show the time of day']")
        self.browser.keys(Keys.ESCAPE)
        day = r"\d\d:\d\d:\d\d"
        wait_until(
            lambda: (
                re.match(day, self.browser.text(".dygraph-axis-label-x"))
                and self.browser.text(".dygraph-xlabel").startswith("time, UTC")
                and re.match(day + r"\.\d\d\s", self.under_pointer(500))
            ),
            lambda: (self.browser.text("#plot"), self.under_pointer(500)),
        )

    def under_pointer(self, across: int) -> str:
        """Return the text beside the pointer at some pixels from the left."""
        self.browser.run(
            "document.getElementById('stage').dispatchEvent(new PointerEvent('pointermove',"
            " {clientX: arguments[0], clientY: 250, bubbles: true}))",
            across,
        )
        return self.browser.text(".hover")


def _is_true(text: str, title: str, true: float) -> bool:
    """Return whether a text with an uncertainty in its tooltip is true, and rounded by it.

    Without an uncertainty, the text is exact for the samples, which end anywhere in a period.
    """
    if not text or text == "–":
        return False
    value = float(text.replace("−", "-"))
    if not title:
        return abs(value - true) < 0.005
    uncertainty = title.partition("± ")[2]
    digits = [len(one.partition(".")[2]) for one in (text, uncertainty)]
    return abs(value - true) <= 1.05 * float(uncertainty) and digits[0] == digits[1]


def _span(address: str) -> Tuple[float, float]:
    """Return start and end in the URL of a CSV file [s]."""
    query = parse_qs(address.partition("?")[2])
    return float(query["start"][0]), float(query["end"][0])
