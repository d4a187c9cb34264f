"""View of the page: addresses, axes, cursors, pictures, and restoration."""

import json
import math
import re
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Dict, List, Optional, Tuple
from urllib.parse import parse_qs, quote, unquote, urlparse
from urllib.request import urlopen

import numpy
import rospy
from browsing.browser import HEIGHT, WIDTH
from browsing.page_test import PROCESSED, SIGNAL, PageTest
from browsing.picture import Picture
from browsing.scope_process import ScopeProcess
from browsing.waiting import wait_until
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from std_msgs.msg import Float64

from nodekit.testing.processes import free_port, hanging


#: Number of grid lines: strokes in a column of pixels at the right edge.
_ROWS = """
const { x, y, width, height } = document.querySelector("#overlay").getBoundingClientRect();
const canvas = document.querySelector(".pane canvas");
const { left, top } = canvas.getBoundingClientRect();
const copy = new OffscreenCanvas(1, Math.round(height)).getContext("2d");
copy.drawImage(canvas, left - x - width + 3, top - y);
const { data } = copy.getImageData(0, 0, 1, Math.round(height));
let count = 0;
for (let at = 7; at < data.length; at += 4) if (data[at] && !data[at - 4]) count += 1;
return count;
"""
#: Fraction of a colour in each pixel of the plot, 0 to 1, by rows.
_INK = """
const box = document.querySelector("#overlay").getBoundingClientRect();
const [red, green, blue] = arguments[0].match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));
const [width, height] = [Math.round(box.width), Math.round(box.height)];
const copy = new OffscreenCanvas(width, height).getContext("2d");
for (const canvas of document.querySelectorAll("#plot canvas")) {
  const { left, top } = canvas.getBoundingClientRect();
  copy.drawImage(canvas, left - box.left, top - box.top);
}
const { data } = copy.getImageData(0, 0, width, height);
return Array.from({ length: height }, (_, row) => Array.from({ length: width }, (_, column) => {
  const index = 4 * (row * width + column);
  const near = (part, wanted) => Math.abs(data[index + part] - wanted) < 48;
  return near(0, red) && near(1, green) && near(2, blue) ? data[index + 3] / 255 : 0;
}));
"""


class View(PageTest):
    """Use of the plot."""

    def test_set_up_is_in_the_address_and_in_files(self) -> None:
        self.browser.choose("#window", "2")
        self.browser.press(f"[aria-label='remove {PROCESSED}']")
        self.browser.press(f"[aria-label='right axis for {SIGNAL}']")
        colour = self.browser.find(f"[aria-label='colour of {SIGNAL}']")
        self.browser.run(
            "arguments[0].value = '#123456'; arguments[0].dispatchEvent(new Event('change'));",
            colour,
        )
        times = ".dygraph-axis-label-x"
        wait_until(
            lambda: "−4" not in self.browser.text(times).split(), lambda: self.browser.text(times)
        )
        self.browser.keys("c")
        self.browser.choose("#trigger-mode", "normal")
        self.shows_the_setup()
        address = str(
            wait_until(
                lambda: (
                    re.search('normal.*"cursors":{"a":-0.(3|29)', self.address())
                    and self.browser.driver.current_url
                ),
                self.address,
            )
        )
        setup = self.browser.call(
            "page/setup.js", "JSON.parse(decodeURIComponent(location.hash.slice(1)))"
        )
        self.browser.driver.get("about:blank")
        self.browser.open(address)
        self.shows_the_setup()
        self.browser.keys("s")
        self.browser.wait_for("#setup-save").click()
        self.browser.keys(Keys.ESCAPE)
        path = self.browser.downloaded("scope_setup.json")
        self.assertEqual(json.loads(path.read_text()), setup)
        # An invalid part is reported, and nothing changes.
        self.load({**setup, "window": -1})
        wait_until(
            lambda: self.browser.text("#notice") == "the set-up has an invalid window",
            lambda: self.browser.text("#notice"),
        )
        self.shows_the_setup()
        self.show()
        self.assertTrue(self.browser.wait_for(f"#legend tr[data-field='{PROCESSED}']"))
        self.load(setup)
        self.shows_the_setup()
        # An address pasted into an open page does not reload it. A truncated one is reported.
        self.show()
        self.browser.wait_for(f"#legend tr[data-field='{PROCESSED}']")
        self.browser.driver.get(address)
        self.shows_the_setup()
        for cut in (address[:-1], address[:-5]):
            self.browser.run("document.querySelector('#notice').textContent = ''")
            self.browser.driver.get(cut)
            wait_until(
                lambda: self.browser.text("#notice") == "the set-up is not valid JSON",
                lambda: self.browser.text("#notice"),
            )
            self.shows_the_setup()
        self.browser.driver.get("about:blank")
        self.browser.open(cut)
        self.assertTrue(self.browser.wait_for(f"#legend tr[data-field='{PROCESSED}']"))

    def test_pasted_address_is_applied_despite_an_update(self) -> None:
        setup = quote(json.dumps({"window": 2}))
        self.browser.run(
            "location.hash = arguments[0]; history.replaceState(null, '', location.pathname)", setup
        )
        wait_until(
            lambda: self.browser.value("#window") == "2", lambda: self.browser.value("#window")
        )

    def address(self) -> str:
        """Return the decoded address of the page."""
        return unquote(self.browser.driver.current_url)

    def load(self, setup: Any) -> None:
        with TemporaryDirectory() as folder:
            path = Path(folder, "setup.json")
            path.write_text(json.dumps(setup))
            self.browser.keys("s")
            self.browser.find("#setup-load").send_keys(str(path))
            wait_until(lambda: self.browser.value("#setup-load") == "", lambda: "it is not read")
            self.browser.keys(Keys.ESCAPE)

    def shows_the_setup(self) -> None:
        wait_until(
            lambda: (
                self.browser.count("#legend tr") == 1
                and self.browser.value("#window") == "2"
                and self.browser.value("#trigger-mode") == "normal"
                and self.browser.text("#trigger-state") == "triggered"
                and self.browser.text(f"[aria-label='right axis for {SIGNAL}']") == "right"
                and self.browser.value(f"[aria-label='colour of {SIGNAL}']") == "#123456"
            ),
            self.address,
        )
        # By the axis of the trigger, whose zero is in the middle.
        wait_until(
            lambda: (
                re.match(r"A −0\.3000 s\s+B 0\.3000 s", self.browser.text(".readout"))
                and "1.0" in self.browser.text(".dygraph-axis-label-x").split()
            ),
            lambda: self.browser.text(".readout"),
        )

    def test_missing_data_is_explained(self) -> None:
        field = "/silent/data"
        publisher = rospy.Publisher("/silent", Float64, queue_size=10, latch=True)
        self.addCleanup(publisher.unregister)
        publisher.publish(math.nan)
        self.browser.keys("a", field)
        wait_until(
            lambda: self.browser.count("#chooser-list input") == 1,
            lambda: self.browser.text("#chooser-list"),
        )
        self.browser.keys(Keys.ENTER, Keys.ESCAPE)
        badge = f"#legend tr[data-field='{field}'] .badge"
        wait_until(
            lambda: re.fullmatch(r"no data for \d+ s(, NaN 100 %)?", self.browser.text(badge)),
            lambda: self.browser.text("#legend"),
        )

    def test_malformed_name_in_the_address_has_a_row_with_a_reason(self) -> None:
        names = [SIGNAL, "../x", "=/a/b + (", PROCESSED]
        self.show(fields=names)
        for name, reason in zip(names[1:3], ("not the name of a field", "unexpected end")):
            badge = f"#legend tr.gone[data-field='{name}'] .badge"
            wait_until(
                lambda: reason in self.browser.text(badge), lambda: self.browser.text("#legend")
            )
        for field, most in ((SIGNAL, 2.0), (PROCESSED, 2.0)):
            wait_until(
                lambda: abs(self.cell(field, "max") - most) < 0.05,
                lambda: self.browser.text("#legend"),
            )
        wait_until(self.samples, lambda: "the file has no samples yet")
        self.assertEqual(len(self.samples()[0][1]), 4)

    def test_the_link_to_the_samples_can_be_copied(self) -> None:
        link = "return document.querySelector('#csv').href"  # without hovering over it
        wait_until(lambda: "field=" in self.browser.run(link), lambda: self.browser.run(link))
        wait_until(lambda: self.cell(SIGNAL, "rate") > 0.0, lambda: self.browser.text("#legend"))

        def copied() -> List[str]:
            with urlopen(str(self.browser.run(link))) as answer:
                return list(answer.read().decode().splitlines())

        wait_until(lambda: len(copied()) > 100, copied)
        self.assertEqual(copied()[0].split(",")[2:], [SIGNAL, PROCESSED])

    def test_the_table_follows_the_cursors_with_each_frame(self) -> None:
        self.browser.keys("c")
        at = f"#legend tr[data-field='{SIGNAL}'] [data-cell='a']"
        wait_until(lambda: self.browser.text(at) not in ("", "–"), lambda: self.browser.text(at))
        # Each frame starts with clearRect; at 100 Hz all frames have different values.
        drawn, reply = self.browser.driver.execute_async_script(
            """
            const [selector, done] = arguments;
            const { clearRect } = CanvasRenderingContext2D.prototype;
            const cell = document.querySelector(selector);
            let [isDrawn, drawn, updated, before] = [false, 0, 0, cell.textContent];
            CanvasRenderingContext2D.prototype.clearRect = function (...box) {
              isDrawn = true;
              return clearRect.call(this, ...box);
            };
            const look = () => {
              if (isDrawn) {
                drawn += 1;
                if (cell.textContent !== before) updated += 1;
                before = cell.textContent;
              }
              isDrawn = false;
              if (drawn < 15) setTimeout(look, 0);
              else {
                CanvasRenderingContext2D.prototype.clearRect = clearRect;
                done([drawn, updated]);
              }
            };
            look();
            """,
            at,
        )
        self.assertGreater(reply, 0.7 * drawn)

    def test_a_setup_of_the_command_line_is_shown_and_kept_while_paused(self) -> None:
        setup = {"fields": [SIGNAL], "right": [SIGNAL], "window": 1, "baseWindow": 1}
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = Path(folder.name, "setup.json")
        file.write_text(json.dumps(setup))
        scope = ScopeProcess("--history", "2", "--setup", str(file))
        self.addCleanup(scope.stop)
        self.addCleanup(self.leave_page)
        scope.wait_until_served()
        self.browser.open(scope.url)
        side = f"[aria-label='right axis for {SIGNAL}']"
        wait_until(lambda: self.browser.text(side) == "right", lambda: self.browser.text("#legend"))
        self.browser.press("#reset")  # gives the page the focus
        wait_until(
            lambda: len(self.samples()) > 90 and self.cell(SIGNAL, "max") > 1.99,
            lambda: self.browser.text("#legend"),
        )
        self.browser.press("#run")
        self.assertEqual(self.browser.text("#run"), "Run")
        before = self.samples()
        # A new estimate of the clock's offset moves a trace by a sample or two.
        kept = " ".join(row[0] for _, row in before[10:-10])
        later = f"{scope.url}/data.csv?field={SIGNAL}&start={before[-1][0] + 2.5}"
        wait_until(lambda: len(urlopen(later).read().splitlines()) > 1, lambda: "nothing later")
        self.assertIn(kept, " ".join(row[0] for _, row in self.samples()))
        self.browser.choose("#window", "0.5")  # it can be zoomed and measured, too
        wait_until(
            lambda: 40 < len(self.samples()) < 60 and self.cell(SIGNAL, "rate") > 90.0,
            lambda: self.browser.text("#legend"),
        )
        # And moved, within the span that was visible.
        zoomed = [row[0] for _, row in self.samples()]

        def is_moved(kept: int) -> bool:
            moved = [row[0] for _, row in self.samples()]
            return 40 < len(moved) < 60 and " ".join(zoomed[:kept]) in " ".join(moved)

        self.browser.run("document.activeElement.blur()")  # takes the focus from the field
        for count, kept_samples in ((2, 30), (20, 0)):
            self.browser.keys(*[Keys.ARROW_LEFT] * count)
            wait_until(lambda: is_moved(kept_samples), self.samples)
        wait_until(lambda: abs(self.samples()[0][0] - before[0][0]) < 0.05, self.samples)

    def test_timestamp_source_is_shown_and_changed(self) -> None:
        choice = f"#legend tr[data-field='{SIGNAL}'] select"
        wait_until(
            lambda: self.browser.text(f"{choice} option[value='']") == "auto (time_x)",
            lambda: self.browser.text("#legend"),
        )
        self.browser.choose("#trigger-mode", "auto")
        self.browser.press("#level-cursors")
        self.browser.choose(choice, "received")
        renamed = f"{SIGNAL}@received"
        self.browser.wait_for(f"#legend tr[data-field='{renamed}']")
        wait_until(lambda: self.cell(renamed, "max") > 1.9, lambda: self.browser.text("#legend"))
        # All settings of the trace follow its new name.
        trigger = [self.browser.value(f"#trigger-{part}") for part in ("mode", "field")]
        self.assertEqual(trigger, ["auto", renamed])
        self.assertTrue(self.browser.find(".level-cursor").is_displayed())

    def test_drawn_line_is_the_curve_through_the_samples(self) -> None:
        """At about one sample per pixel; drawn at bin centres it would be 3 pixels off."""
        self.browser.press(f"[aria-label='show {PROCESSED}']")
        self.browser.keys("x")
        for end, bound in (("from", "-3"), ("to", "3")):
            self.browser.find(f"[aria-label='left axis, {end}']").send_keys(bound, Keys.TAB)
        self.browser.keys(Keys.ESCAPE)
        self.browser.choose("#window", "10")
        wait_until(lambda: len(self.samples()) > 600, lambda: len(self.samples()))
        self.browser.press("#run")
        self.wait_still()
        seen: List[Any] = []

        def is_drawn() -> bool:  # late samples are drawn within a second
            seen.append(self.beside_the_curve())
            return float(seen[-1].max()) < 1.5

        wait_until(is_drawn, lambda: seen[-1].tolist())

    def beside_the_curve(self) -> Any:
        """Return the distance of the drawn line from the curve through the samples [pixels]."""
        rows = numpy.array([(time, float(row[0])) for time, row in self.samples()])
        query = parse_qs(urlparse(str(self.browser.find("#csv").get_property("href"))).query)
        start, end = (float(query[name][0]) for name in ("start", "end"))
        ink = numpy.array(
            self.browser.run(_INK, self.browser.value(f"[aria-label='colour of {SIGNAL}']"))
        )
        width, height = ink.shape[1], ink.shape[0]
        columns = numpy.arange(width)
        drawn = (ink * (numpy.arange(height) + 0.5)[:, None]).sum(axis=0) / (ink.sum(axis=0) + 1e-9)
        # Mean height of the exact curve in each column of pixels.
        at = start + (columns[:, None] + (numpy.arange(20) + 0.5) / 20) / width * (end - start)
        exact = (0.5 - numpy.interp(at, *rows.T).mean(axis=1) / 6.0) * height
        # Not at the ends of the curve, which cover only part of a column.
        there = (at[:, 0] > rows[1, 0]) & (at[:, -1] < rows[-2, 0])
        # Nor at gaps of samples that a busy machine skipped.
        (gaps,) = numpy.nonzero(numpy.diff(rows[:, 0]) > 0.05)
        for gap in gaps:
            there &= (at[:, -1] < rows[gap, 0]) | (at[:, 0] > rows[gap + 1, 0])
        self.assertGreater(there.sum(), 500)
        return abs(drawn - exact)[there]

    def wait_armed(self) -> None:
        """Wait until the server reports the state armed."""
        wait_until(
            lambda: self.browser.text("#trigger-state") == "armed",
            lambda: self.browser.text("#trigger-state"),
        )

    def test_trigger_ignores_messages_from_before_its_latest_change(self) -> None:
        # A delayed message, which the page receives after it has sent the change.
        self.browser.run(
            "const { send } = WebSocket.prototype; window.sendToScope = send;"
            "WebSocket.prototype.send = function(text) { window.socket = this;"
            " window.sent = JSON.parse(text); return send.call(this, text); };"
        )
        self.addCleanup(self.browser.run, "WebSocket.prototype.send = window.sendToScope")
        self.browser.choose("#window", "0.5")
        self.browser.choose("#trigger-mode", "normal")
        level = "document.querySelector('#trigger-level')"
        self.browser.run(f"{level}.value = '1000'; {level}.dispatchEvent(new Event('change'));")
        self.browser.choose("#trigger-mode", "single")
        self.wait_armed()
        reply = self.browser.run(
            f"{level}.value = '1001'; {level}.dispatchEvent(new Event('change'));"
            "const { number } = window.sent;"
            "for (const old of [number - 1, undefined]) window.socket.dispatchEvent("
            "new MessageEvent('message', { data: JSON.stringify("
            "{type: 'trigger', number: old, state: 'triggered', time: 0}) }));"
            "return document.querySelector('#trigger-state').value;"
        )
        self.assertEqual(reply, "armed")
        self.wait_armed()
        self.wait_moving()
        self.assertEqual(self.browser.text("#run"), "Pause")

    def test_wheel_drag_and_double_click(self) -> None:
        stage = self.browser.find("#stage")
        self.browser.run(
            "arguments[0].dispatchEvent(new WheelEvent('wheel',"
            " {deltaY: -300, clientX: 500, clientY: 250, bubbles: true, cancelable: true}))",
            stage,
        )
        wait_until(
            lambda: float(self.browser.value("#window")) < 4.0,
            lambda: self.browser.value("#window"),
        )
        ActionChains(self.browser.driver).drag_and_drop_by_offset(stage, 100, 0).perform()
        self.assertEqual(self.browser.text("#run"), "Run")

        def is_as_it_was() -> bool:  # two clicks may be too far apart for a double click
            ActionChains(self.browser.driver).double_click(stage).perform()
            return float(self.browser.value("#window")) == 5.0

        wait_until(is_as_it_was, lambda: self.browser.value("#window"))

    def touch(self, kind: str, *points: Tuple[float, float]) -> None:
        """Touch the page at some points."""
        self.browser.driver.execute_cdp_cmd(
            "Input.dispatchTouchEvent",
            {
                "type": kind,
                "touchPoints": [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(points)],
            },
        )

    def test_two_fingers_zoom_and_a_phone_on_its_side_has_room_for_the_plot(self) -> None:
        self.addCleanup(self.browser.resize, WIDTH, HEIGHT)
        self.browser.resize(844, 390)
        wait_until(
            lambda: self.browser.find("#plot").size["height"] > 300,
            lambda: self.browser.find("#plot").size,
        )
        shown = self.browser.run(
            "const { left, right, top, bottom } = document.querySelector('#stage')"
            ".getBoundingClientRect(); return [left, right, top, bottom,"
            " document.scrollingElement.scrollWidth];"
        )
        self.assertEqual([shown[0], shown[1], shown[4]], [0, 844, 844])
        self.assertTrue(0 < shown[2] < 60 and shown[3] <= 391, shown)
        self.browser.resize(390, 844)
        # All figures fit the width of the page, each beside its head.
        wait_until(
            lambda: self.browser.run(
                "const table = document.querySelector('.traces');"
                "const right = (cell) => cell.getBoundingClientRect().right;"
                "return table.scrollWidth <= 390 && [...table.querySelectorAll('[data-cell]')]"
                ".every((cell) => cell.dataset.head && right(cell) > 0 && right(cell) < 390);"
            ),
            lambda: self.browser.run("return document.querySelector('.traces').scrollWidth"),
        )
        self.browser.resize(844, 390)
        wait_until(
            lambda: self.browser.find("#plot").size["width"] > 600,
            lambda: self.browser.find("#plot").size,
        )
        self.touch("touchStart", (400, 200))
        self.touch("touchStart", (400, 200), (500, 200))
        for apart in range(110, 210, 20):
            self.touch("touchMove", (450 - apart / 2, 200), (450 + apart / 2, 200))
        self.touch("touchEnd")
        # Almost twice as far apart, while it keeps running.
        wait_until(
            lambda: 2.4 < float(self.browser.value("#window")) < 3.0,
            lambda: self.browser.value("#window"),
        )
        self.assertEqual(self.browser.text("#run"), "Pause")

    def test_cursors_by_keyboard(self) -> None:
        self.browser.keys("c")
        handle = self.browser.wait_for(".cursor[aria-label='time cursor A']")
        first = float(handle.get_attribute("aria-valuenow"))
        handle.send_keys(Keys.ARROW_RIGHT)
        self.assertAlmostEqual(
            float(handle.get_attribute("aria-valuenow")), first + 0.025, delta=1e-6
        )
        readout = self.browser.text(".readout").replace("\xa0", " ")
        self.assertIn("Δt 1.4750 s", readout)
        self.assertIn("1/Δt 0.6780 Hz", readout)
        # They keep their screen positions when the axis is relative to the trigger.
        self.browser.choose("#window", "1")

        def shown() -> List[str]:
            return self.browser.text(".dygraph-axis-label-x").replace("−", "-").split()

        # A busy server sends the second later; cursors are placed on the drawn axis.
        wait_until(lambda: -1.0 <= float(shown()[0]) < 0.0, lambda: str(shown()))
        for _ in range(2):
            self.browser.press("#cursors")
        handle = self.browser.wait_for(".cursor[aria-label='time cursor A']")
        style = handle.get_attribute("style")
        for _ in range(3):
            self.browser.choose("#trigger-mode", "single")
            wait_until(lambda: self.browser.text("#run") == "Run", lambda: "it does not hold")
            self.assertTrue(handle.is_displayed())
            self.assertEqual(handle.get_attribute("style"), style)
            self.browser.choose("#trigger-mode", "off")
            wait_until(lambda: self.browser.text("#run") == "Pause", lambda: "it holds")
        wait_until(
            lambda: abs(self.cell(SIGNAL, "difference")) < 5.0,
            lambda: self.browser.text("#legend"),
        )
        self.browser.press("#cursors")
        self.assertNotIn("at A", self.browser.text("#legend-head"))

    def wait_ranges(self) -> None:
        """Wait until both axes are drawn with their full ranges: 2 sin, and 1 + cos."""

        def ends(axis: int) -> Tuple[float, float]:
            labels = self.browser.text(f".dygraph-axis-label-y{axis}").replace("−", "-").split()
            return (float(labels[0]), float(labels[-1])) if labels else (0.0, 0.0)

        wait_until(
            lambda: ends(1)[0] <= -2.0 and ends(2)[0] == 0.0 and min(ends(1)[1], ends(2)[1]) >= 2.0,
            lambda: (ends(1), ends(2)),
        )

    def test_level_cursors_are_on_each_axis_in_turn(self) -> None:
        self.browser.press(f"[aria-label='right axis for {PROCESSED}']")
        self.wait_ranges()  # cursors are placed on the latest drawn axis
        button = self.browser.find("#level-cursors")
        places = []
        for field in (SIGNAL, PROCESSED):
            button.click()
            handle = self.browser.wait_for(".level-cursor[aria-label='level cursor C']")
            readout = self.browser.text(".readout.of-levels").replace("\xa0", " ")
            self.assertTrue(readout.endswith(field), readout)
            places.append(self.level(handle))
        # The same height, 65 %, has different values on both axes: -2 to 2, and 0 to 2.
        self.assertTrue(0.3 < places[0] < 1.0 < places[1] < 1.7, places)
        self.wait_in_place(handle)
        ActionChains(self.browser.driver).drag_and_drop_by_offset(handle, 0, -100).perform()
        wait_until(lambda: self.level(handle) > places[1], lambda: (self.level(handle), places))
        above = self.level(handle)
        handle.send_keys(Keys.ARROW_UP)
        wait_until(lambda: self.level(handle) > above, lambda: (self.level(handle), above))
        c, d, apart = re.findall(r"(?:C|D|C − D) (−?[\d.]+)", self.browser.text(".of-levels"))
        self.assertAlmostEqual(float(c) - float(d), float(apart), delta=2e-4)
        wait_until(
            lambda: f'"c":{float(c):g},' in unquote(self.browser.driver.current_url),
            lambda: self.browser.driver.current_url,
        )
        self.restore()
        self.browser.wait_for(".level-cursor[aria-label='level cursor D']")
        wait_until(
            lambda: f"C {c}" in self.browser.text(".of-levels").replace("\xa0", " "),
            lambda: self.browser.text(".of-levels"),
        )
        self.browser.press(f"[aria-label='remove {PROCESSED}']")
        wait_until(
            lambda: not self.browser.count(".level-cursor:not([hidden])"),
            lambda: self.browser.text(".of-levels"),
        )

    def level(self, handle: WebElement) -> float:
        """Return the value of a level cursor."""
        return float(handle.get_attribute("aria-valuenow"))

    def test_axis_without_a_trace_has_no_labels(self) -> None:
        grid = self.browser.run(_ROWS)
        for field in (SIGNAL, PROCESSED):
            self.browser.press(f"[aria-label='right axis for {field}']")
        wait_until(
            lambda: (
                self.browser.count(".dygraph-axis-label-y2") > 3
                and not self.browser.count(".dygraph-axis-label-y1")
            ),
            lambda: f"{self.browser.text('#plot')}, {self.browser.errors()}",
        )
        wait_until(  # more strokes than the traces alone
            lambda: min(self.browser.run(_ROWS) for _ in range(5)) > 6,
            lambda: f"{grid} lines before, none now",
        )
        self.browser.press(f"[aria-label='right axis for {SIGNAL}']")
        wait_until(
            lambda: self.browser.count(".dygraph-axis-label-y1") > 3,
            lambda: f"{self.browser.text('#plot')}, {self.browser.errors()}",
        )

    def test_axes_keep_typed_ranges(self) -> None:
        self.browser.keys("x")
        self.browser.wait_for("[aria-label='left axis, to']").send_keys("7.5", Keys.TAB)
        self.browser.find("[aria-label='title of the left axis']").send_keys("level, V")
        self.browser.keys(Keys.ESCAPE)
        wait_until(
            lambda: self.browser.text(".dygraph-ylabel") == "level, V",
            lambda: self.browser.text(".dygraph-ylabel"),
        )
        # Round values up to the typed end, which the default range does not have.
        wait_until(
            lambda: self.browser.text(".dygraph-axis-label-y").split()[-1] in ("6", "7"),
            lambda: self.browser.text(".dygraph-axis-label-y"),
        )

    def test_nothing_is_left_beside_the_plot_when_titles_change(self) -> None:
        self.addCleanup(self.browser.resize, WIDTH, HEIGHT)
        self.addCleanup(self.fold)
        for width, ratio in ((WIDTH, 1.0), (412, 2.625)):  # the second is a phone
            self.browser.resize(width, HEIGHT, ratio)
            if width == WIDTH:
                tools = self.browser.find("#scope-view .tools").size["height"]
                self.assertLess(tools, 50, "the tools take more than one row")
            else:
                self.browser.press("#show-controls")
            self.browser.keys("x")
            title = self.browser.wait_for("[aria-label='title of the time axis']")
            bound = self.browser.find("[aria-label='left axis, to']")
            for text, end in (("", "2"), ("time", "1234567")):
                title.send_keys(Keys.CONTROL + "a")
                title.send_keys(Keys.BACKSPACE, text)
                bound.send_keys(Keys.CONTROL + "a")
                bound.send_keys(end, Keys.TAB)
                wait_until(
                    lambda: self.browser.text(".dygraph-xlabel") == text,
                    lambda: self.browser.text("#plot"),
                )
                self.assertEqual(self.painted_outside(ratio), 0, (ratio, text))
            self.browser.keys(Keys.ESCAPE)
            # The labels of an axis change their width with the values, which moves the plot.
            self.browser.press("#run")
            self.wait_still()
            height, box = self.browser.find("#plot").size["height"], self.box()
            picture = self.saved(max(2.0, ratio))
            self.assertEqual(self.box(), box)
            self.assertEqual(picture.strokes(box, height), [], ratio)
            self.browser.press("#run")

    def fold(self) -> None:
        """Hide the optional parts of a narrow page."""
        self.browser.run(
            "if (document.body.matches('.unfolded'))"
            " document.querySelector('#show-controls').click()"
        )

    def painted_outside(self, ratio: float) -> int:
        """Return the number of painted canvas pixels outside of the plot."""
        code = """
          const [ratio, done] = arguments;
          const count = () => {
            const box = document.querySelector("#overlay").getBoundingClientRect();
            let found = 0;
            for (const canvas of document.querySelectorAll("#plot canvas")) {
              const { left, top } = canvas.getBoundingClientRect();
              const { width, height } = canvas;
              const copy = new OffscreenCanvas(width, height);
              const context = copy.getContext("2d", { willReadFrequently: true });
              context.drawImage(canvas, 0, 0);
              const { data } = context.getImageData(0, 0, width, height);
              for (let index = 3; index < data.length; index += 4) {
                const place = (index - 3) / 4;
                const x = left - box.left + (place % width) / ratio;
                const y = top - box.top + Math.floor(place / width) / ratio;
                const isIn = x > -2 && x < box.width + 1 && y > -2 && y < box.height + 1;
                if (data[index] && !isIn) found += 1;
              }
            }
            done(found);
          };
          requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(count)));
        """
        return int(self.browser.driver.execute_async_script(code, ratio))

    def test_saves_a_picture_for_a_report(self) -> None:
        self.watch_writing()
        self.browser.run(
            "const kind = CanvasRenderingContext2D.prototype; const { drawImage } = kind;"
            "kind.drawImage = function(image, x, y, width, height) {"
            " window.ratio = image.width / width; kind.drawImage = drawImage;"
            " return drawImage.call(this, image, x, y, width, height); };"
        )
        self.browser.keys("c", "v")
        wait_until(
            lambda: self.cell(SIGNAL, "max") > 1.9 and self.cell(SIGNAL, "min") < -1.9,
            lambda: self.browser.text("#legend"),
        )
        self.wait_moving()  # so both traces are drawn
        size, picture = wait_until(self.saved_with_size, lambda: self.browser.text("#legend"))
        self.assertEqual(picture.painted.shape[1], 2 * size["width"])
        self.assertEqual(self.browser.run("return window.ratio"), 2, "not drawn so, but stretched")
        # Heads, two traces, readouts of both pairs of cursors, the date.
        self.assertEqual(picture.lines(size["height"]), [True] * 6)
        self.assertFalse(
            picture.part(picture.painted, (-11, size["height"], 0, 0)).any(), "cut off"
        )
        box = self.box()
        for field in (SIGNAL, PROCESSED):
            colour = picture.of_colour(self.browser.value(f"[aria-label='colour of {field}']"))
            curve = picture.part(colour, box)
            self.assertGreater(curve.any(axis=0).mean(), 0.08, "from left to right")
            self.assertGreater(curve.any(axis=1).mean(), 0.15, "from its least value upwards")
            sample = picture.part(colour, (13, size["height"], 35, 0))
            self.assertTrue(sample.any(axis=0).all(), "as long as the sample in the legend")
        dark = picture.of_colour(self.style("cursor"))
        for x, y in self.browser.run(
            "const plot = document.querySelector('#plot').getBoundingClientRect();"
            "return [...document.querySelectorAll('.handle:not([hidden])')].map((handle) => {"
            " const box = handle.getBoundingClientRect();"
            " const middle = [box.left + box.width / 2, box.top + box.height / 2];"
            " return handle.matches('.cursor') ? [middle[0] - plot.left, null]"
            " : [null, middle[1] - plot.top]; })"
        ):
            left, top, right, bottom = box
            place = (
                (left, y - 1.5, right, y + 1.5) if x is None else (x - 1.5, top, x + 1.5, bottom)
            )
            dashes = picture.part(dark, place).any(axis=0 if x is None else 1).mean()
            self.assertTrue(0.35 < dashes < 0.75, (x, y, dashes))
        written = self.browser.run("return window.written")
        for text in (SIGNAL, PROCESSED, "A", "B", "C", "D", "RMS", "time, s"):
            self.assertIn(text, written)
        self.assertTrue(any("Δt 1.5000 s" in text for text in written), written)
        self.assertTrue(any("C − D " in text for text in written), written)
        self.assertTrue(any(re.match(r"2\.000\d\Z|1\.99\d\d\Z", text) for text in written), written)
        date = r"\d{4}-\d\d-\d\d, \d\d:\d\d:\d\d\.\d, UTC"
        self.assertTrue(any(re.match(date, text) for text in written), written)
        self.assertEqual(picture.strokes(box, size["height"]), [])
        # The page is restored: at screen resolution, and running.
        self.assertEqual(
            self.browser.run("return [document.querySelector('#plot canvas').width]"),
            [size["width"]],
        )
        self.wait_moving()

    def style(self, name: str) -> str:
        """Return a colour of the page."""
        code = "return getComputedStyle(document.documentElement).getPropertyValue(arguments[0])"
        return str(self.browser.run(code, "--" + name)).strip()

    def saved(self, ratio: float = 2.0) -> Picture:
        """Save a picture, and return it."""
        self.browser.press("#png")
        path = self.browser.downloaded("scope.png")
        try:
            return Picture(path, ratio)
        finally:
            path.unlink()

    def saved_with_size(self) -> Optional[Tuple[Dict[str, int], Picture]]:
        """Save a picture; return the size of the plot and the picture, None if the size changed."""
        plot = self.browser.find("#plot")
        size, picture = plot.size, self.saved()
        return (size, picture) if plot.size == size else None

    def box(self) -> Any:
        """Return the box of the traces and axes in a picture."""
        return self.browser.run(
            "const [plot, inner] = ['#plot', '#overlay'].map((name) =>"
            " document.querySelector(name).getBoundingClientRect());"
            "return [inner.left - plot.left - 2, Math.max(0, inner.top - plot.top - 2),"
            " inner.right - plot.left + 2, inner.bottom - plot.top + 2];"
        )

    def test_picture_has_all_measurements_on_a_narrow_page(self) -> None:
        self.addCleanup(self.browser.resize, WIDTH, HEIGHT)
        self.addCleanup(self.fold)
        name = "/robot1/left_arm/joint_states/position[shoulder]"
        self.browser.keys("a", name)
        self.browser.wait_for("#chooser-list input")
        self.browser.keys(Keys.ENTER, Keys.ESCAPE)
        self.browser.wait_for(f"#legend tr.gone[data-field='{name}']")
        wait_until(
            lambda: (
                self.cell(SIGNAL, "frequency") > 0.9 and self.cell(PROCESSED, "frequency") > 0.9
            ),
            lambda: self.browser.text("#legend"),
        )
        self.browser.press("#cursors")
        self.browser.press("#level-cursors")
        self.browser.resize(412, HEIGHT, 2.625)
        wait_until(lambda: self.box()[2] < 412, self.box)
        self.browser.press("#show-controls")
        self.watch_writing()
        picture = self.saved(2.625)
        written = self.browser.run("return window.written")
        heads = self.browser.run(
            "return [...document.querySelectorAll('#legend-head .figure')]"
            ".map((one) => one.innerText)"
        )
        self.assertIn("B − A", heads)
        self.assertEqual([text for text in written if text in heads], heads)
        self.assertNotIn(name, written)
        self.assertIn(name, "".join(written), "in two lines")
        height = self.browser.find("#plot").size["height"]
        lines = picture.lines(height)
        self.assertTrue(len(lines) > 20 and all(lines), lines)
        self.assertFalse(picture.part(picture.painted, (-11, height, 0, 0)).any(), "cut off")

    def test_theme_is_remembered(self) -> None:
        theme = "return document.documentElement.dataset.theme"
        first = self.browser.run(theme)
        self.browser.keys("d")
        second = self.browser.run(theme)
        self.assertEqual({first, second}, {"light", "dark"})
        self.addCleanup(self.browser.keys, "d")
        self.browser.open(self.scope.url)
        self.assertEqual(self.browser.run(theme), second)

    def test_missing_master_is_reported(self) -> None:
        port = str(free_port())
        uri = f"http://localhost:{port}"
        scope = ScopeProcess("/a/data", ROS_MASTER_URI=uri)
        self.addCleanup(scope.stop)
        scope.wait_until_served()
        self.browser.open(scope.url)
        self.wait_banner(f"There is no ROS master at {uri} yet: the scope waits for it.")
        self.assertEqual(self.samples(), [], "a file all the same")
        master = subprocess.Popen(["rosmaster", "--core", "-p", port])
        self.addCleanup(master.kill)
        self.wait_banner("")
        self.browser.wait_for("#legend tr[data-field='/a/data']")
        master.terminate()
        master.wait(30.0)
        self.wait_banner(
            f"The ROS master at {uri} does not answer: traces continue, but nothing new is found."
        )

    def test_incomplete_page_is_reloaded(self) -> None:
        self.expected_errors = ["base/numbers.js"]
        cdp = self.browser.driver.execute_cdp_cmd
        cdp("Network.enable", {})
        self.addCleanup(cdp, "Network.disable", {})
        # As after a change of the computer's network, when the browser aborts downloads.
        cdp("Network.setBlockedURLs", {"urls": ["*/static/js/base/numbers.js"]})
        self.browser.driver.get(self.scope.url)
        # It reloads itself repeatedly, so the page may be missing at times.
        wait_until(lambda: self.browser.text("#link") == "loading", lambda: "the text is not shown")
        cdp("Network.setBlockedURLs", {"urls": []})
        self.browser.wait_connected()
        tries = "return sessionStorage.getItem('tries')"
        wait_until(lambda: self.browser.run(tries) is None, lambda: self.browser.run(tries))

    def test_page_is_restored_after_a_restart(self) -> None:
        self.browser.keys("a")
        self.browser.wait_for("#chooser-search").send_keys("signal frequency", Keys.ENTER)
        self.browser.keys(Keys.ESCAPE)
        self.browser.choose("#window", "2")
        self.browser.choose("#trigger-mode", "normal")
        self.browser.press(f"[aria-label='show {PROCESSED}']")
        self.expected_errors = ["WebSocket connection"]
        self.scope.stop()
        self.browser.wait_for("#banner")
        self.scope.start()
        self.browser.wait_connected()
        self.wait_banner("")
        # The server restores the page's earlier state, not its own defaults.
        wait_until(
            lambda: self.cell("/signal/frequency", "mean") > 6.0,
            lambda: self.browser.text("#legend"),
        )
        wait_until(
            lambda: self.browser.text("#trigger-state") == "triggered",
            lambda: self.browser.text("#trigger-state"),
        )
        self.assertEqual(self.browser.value("#window"), "2")
        self.assertFalse(self.browser.find(f"[aria-label='show {PROCESSED}']").is_selected())
        self.wait_moving()

    def test_silent_scope_is_noticed_and_reconnected(self) -> None:
        self.expected_errors = ["WebSocket connection"]
        with hanging(self.scope.pid):  # as with a cut link, the connection stays open
            self.wait_banner("The scope does not answer. Trying again in 1 s.")
            self.assertNotEqual(self.browser.text("#link"), "connected")
        self.browser.wait_connected()
        self.wait_banner("")
        self.wait_moving()
