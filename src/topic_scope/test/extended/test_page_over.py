"""Overlays on the page: persistence of sweeps, and a bag over another bag."""

import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
from typing import Any, Dict, List, Tuple
from unittest import mock
from urllib.parse import quote

import genpy
import rosbag
import roslib.packages
from browsing.browser import Browser
from browsing.page_test import FRESH, shared_browser
from browsing.scope_process import ScopeProcess
from browsing.waiting import wait_until
from geometry_msgs.msg import Point, PointStamped
from selenium.webdriver.common.keys import Keys
from std_msgs.msg import Float32, Float64
from wire.client import Client, fetch

BEGIN, LENGTH_S, RATE_HZ, PERIOD_S = 1700000000, 40.0, 500, 0.1
#: Sine of 1 Hz in a run, and in an older, shorter run with a delay [s].
SINE_HZ, OLD_BEGIN, OLD_S, LATE_S = 100, BEGIN - 604800, 30.0, 0.37
SINE, OLD = "/sine/data", "/old/sine/data"
APART = f"={SINE} - {OLD}"
OFFSET = "[aria-label='offset of old, s']"
#: Sine of 1 Hz, whose messages were recorded with these delays in turn [s].
LATE, LATENESS_S, LATE_LENGTH_S = "/late/point/x@stamp", (0.8, 0.4, 0.6), 12.0
FIELD = "/square/data"
#: Time from the rise of a square wave to its fall, and additional delays in turn [s].
FALLS_S, JITTER_S = 0.03, (0.0, 0.008, 0.012, 0.004)
WINDOW_S, LOW, HIGH = 0.1, -0.5, 1.5
#: Value without a grid line.
LEVEL = 0.37
#: Positions in a row of the plot with the colour of the trace, as fractions, and opacity 0 to 255.
_PAINTED = """
const up = arguments[0];
const canvas = document.querySelector("#plot canvas");
const area = document.querySelector("#overlay").getBoundingClientRect();
const box = canvas.getBoundingClientRect();
const row = Math.round(area.bottom - box.top - up * area.height);
const left = Math.round(area.left - box.left);
const width = Math.round(area.width);
const strip = Object.assign(document.createElement("canvas"), { width, height: 1 })
  .getContext("2d", { willReadFrequently: true });
strip.drawImage(canvas, left, row, width, 1, 0, 0, width, 1);
const { data } = strip.getImageData(0, 0, width, 1);
const found = [];
for (let place = 0; place < data.length; place += 4) {
  const [red, , blue, alpha] = data.slice(place, place + 4);
  if (alpha > 10 && blue - red > 60) found.push([place / data.length, alpha]);
}
return found;
"""
SETUP: Dict[str, Any] = {
    **FRESH,
    "fields": [FIELD],
    "window": WINDOW_S,
    "baseWindow": WINDOW_S,
    "trigger": {"mode": "normal", "field": FIELD, "level": 0.5, "edge": "rising"},
    "axes": {
        "x": {"title": "time, s", "clock": False},
        "y": {"title": "", "low": LOW, "high": HIGH},
        "y2": {"title": "", "low": None, "high": None},
    },
}


def record(path: str) -> None:
    """Record a square wave whose falling edges jitter, and a sine."""
    with rosbag.Bag(path, "w") as bag:
        for index in range(round(LENGTH_S * RATE_HZ)):
            cycle, place = divmod(index, round(PERIOD_S * RATE_HZ))
            falls = FALLS_S + JITTER_S[cycle % len(JITTER_S)]
            value = 1.0 if place < round(falls * RATE_HZ) else 0.0
            bag.write("square", Float32(value), time_at(BEGIN, index, RATE_HZ))

        write_sine(bag, BEGIN, LENGTH_S, 0.0)
        for index in range(round(LATE_LENGTH_S * SINE_HZ)):
            received = time_at(BEGIN, index, SINE_HZ)
            late = PointStamped(point=Point(x=math.sin(2.0 * math.pi * index / SINE_HZ)))
            late.header.stamp = received
            lateness = genpy.Duration.from_sec(LATENESS_S[index % len(LATENESS_S)])
            bag.write("late", late, received + lateness)


def write_sine(bag: Any, begin: int, length: float, late: float) -> None:
    """Record a sine of 1 Hz with a delay [s]."""
    for index in range(round(length * SINE_HZ)):
        value = math.sin(2.0 * math.pi * (index / SINE_HZ - late))
        bag.write("sine", Float64(value), time_at(begin, index, SINE_HZ))


def time_at(begin: int, index: int, rate: int) -> genpy.Time:
    """Return the recording time of a message."""
    return genpy.Time(begin + index // rate, index % rate * 10**9 // rate)


def number(text: str) -> float:
    """Return the number in a cell of the table; NaN if empty."""
    return float(text) if text not in ("", "–") else math.nan


class Over(unittest.TestCase):
    """Bag with an older bag over it."""

    scope: ScopeProcess
    browser: Browser

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        run, old = (str(pathlib.Path(folder.name, name)) for name in ("run.bag", "2023.bag"))
        record(run)
        with rosbag.Bag(old, "w") as bag:
            write_sine(bag, OLD_BEGIN, OLD_S, LATE_S)
        patch = mock.patch.dict(os.environ, ROS_MASTER_URI="http://localhost:1")
        patch.start()
        cls.addClassCleanup(patch.stop)
        cls.scope = ScopeProcess("--bag", run, "--over", f"{old}:old", FIELD)
        cls.addClassCleanup(cls.scope.stop)
        cls.browser = shared_browser()
        cls.addClassCleanup(cls.browser.driver.get, "about:blank")
        cls.browser.errors()  # of previous tests
        cls.scope.wait_until_served()

    def go_to(self, seconds: float) -> None:
        """Pause the bag at a position."""
        page = Client(self.scope.url)
        self.addCleanup(page.close)
        page.wait_for("hello")
        page.send("playback", playing=False, time=BEGIN + seconds)
        wait_until(
            lambda: f", {seconds:.2f} of" in self.browser.text("#playback-time"),
            lambda: self.browser.text("#playback-time"),
        )

    def falling(self) -> List[Tuple[float, int]]:
        """Return the painted falling edges: time after the trigger [s], and opacity."""
        found = self.browser.run(_PAINTED, (LEVEL - LOW) / (HIGH - LOW))
        places = [((part - 0.5) * WINDOW_S, bold) for part, bold in found]
        return [one for one in places if one[0] > FALLS_S / 2.0]

    def band(self) -> float:
        """Return the distance of the first and the last edge [s]."""
        places = [place for place, _ in self.falling()]
        return max(places) - min(places) if places else 0.0

    def boldness(self) -> List[int]:
        """Return the opacity of the edge of each delay; 0 if not painted."""
        painted = self.falling()
        return [
            max((bold for place, bold in painted if abs(place - FALLS_S - late) < 0.001), default=0)
            for late in JITTER_S
        ]

    def test_jitter_shows_as_a_band_with_persistence_and_only_then(self) -> None:
        browser = self.browser
        browser.open(f"{self.scope.url}#{quote(json.dumps(SETUP))}")
        self.go_to(1.0)
        browser.wait_for("#trigger-state[data-state='armed']")
        browser.find("#playback-run").send_keys(Keys.ENTER)
        wait_until(lambda: self.falling(), lambda: browser.text("#trigger-state"))
        # One sweep has one edge.
        self.assertLess(self.band(), 0.001)
        # By keys only; the choice is announced to screen readers.
        browser.find("#show-trigger").send_keys(Keys.ENTER)
        browser.wait_for("#trigger-persistence").send_keys("8")
        self.assertIn("persistence", [name for _, name, _ in browser.accessible()])
        browser.keys(Keys.ESCAPE)
        most = max(JITTER_S)
        wait_until(lambda: abs(self.band() - most) < 0.001 and all(self.boldness()), self.falling)
        # The latest edge is bold, others are paler, depending on skipped sweeps.
        wait_until(lambda: 0 < min(self.boldness()) < 0.6 * max(self.boldness()), self.boldness)
        # It stays on a paused page, and in a set-up.
        page = Client(self.scope.url)
        self.addCleanup(page.close)
        page.send("playback", playing=False)
        browser.wait_for("#playback-run[aria-pressed='false']")
        self.assertAlmostEqual(self.band(), most, delta=0.001)
        address = "return decodeURIComponent(location.hash)"
        wait_until(lambda: '"persistence":8' in browser.run(address), lambda: browser.run(address))
        browser.find("#show-trigger").send_keys(Keys.ENTER)
        browser.wait_for("#trigger-persistence").send_keys("off")
        wait_until(lambda: self.band() < 0.001, self.falling)
        browser.keys(Keys.ESCAPE)  # or the dialog would cover the page of the next test
        self.assertEqual(browser.errors(), [])

    def test_late_messages_are_placed_at_their_stamps(self) -> None:
        """In the picture, under the cursors and in the file."""
        browser = self.browser
        setup = {**FRESH, "fields": [LATE], "window": 10, "cursors": {"a": -2.75, "b": -2.25}}
        browser.open(f"{self.scope.url}#{quote(json.dumps(setup))}")
        self.go_to(10.0)
        row = f"#legend tr[data-field='{LATE}'] "
        crest = r"(1\.000|0\.9999)\d*"
        wait_until(
            lambda: re.fullmatch(
                f"{crest} −{crest}",
                " ".join(browser.text(f"{row}[data-cell={one}]") for one in "ab"),
            ),
            lambda: browser.text("#legend"),
        )
        # The server measures half a second after the picture at the latest.
        wait_until(lambda: not browser.text(f"{row}.badge"), lambda: browser.text("#legend"))
        start, end = browser.run(
            "const link = document.querySelector('#csv'); link.dispatchEvent(new Event('focus'));"
            "const query = new URL(link.href).searchParams;"
            "return [query.get('start'), query.get('end')].map(Number)"
        )
        wait_until(
            lambda: (
                len(self.crests(browser, start, end)) >= 4
                and all(
                    abs(moment % 1.0 - 0.25) < 0.02 for moment in self.crests(browser, start, end)
                )
            ),
            lambda: self.crests(browser, start, end),
        )
        status, text = fetch(f"{self.scope.url}/data.csv?field={quote(LATE)}&start={BEGIN + 6}")
        self.assertEqual(status, 200, text)
        lines = text.split()
        rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
        self.assertGreater(len(rows), 300)
        for moment, received, value in rows:
            self.assertAlmostEqual(value, math.sin(2.0 * math.pi * moment), delta=1e-5)
            self.assertIn(round(received - moment, 3), LATENESS_S)

    def crests(self, browser: Browser, start: float, end: float) -> List[float]:
        """Return the times of the painted crests [s].

        :param start: the time at the left edge of the plot, s
        :param end: the time at the right edge [s]
        """
        code = """
          const colour = document.querySelector("#legend input[type=color]").value;
          const wanted = colour.match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));
          const canvas = document.querySelector("#plot canvas");
          const place = canvas.getBoundingClientRect();
          const plot = document.querySelector("#overlay").getBoundingClientRect();
          const { width, height } = canvas;
          const copy = new OffscreenCanvas(width, height);
          const context = copy.getContext("2d", { willReadFrequently: true });
          context.drawImage(canvas, 0, 0);
          const { data } = context.getImageData(0, 0, width, height);
          const tops = [];
          for (let x = 0; x < width; x += 1) {
            for (let y = 0; y < height; y += 1) {
              const at = 4 * (y * width + x);
              const other = wanted.some((part, one) => Math.abs(data[at + one] - part) > 24);
              if (other || data[at + 3] < 200) continue;
              tops.push([((x + 0.5) * place.width / width + place.x - plot.x) / plot.width, y]);
              break;
            }
          }
          return tops;
        """
        tops = browser.run(code) or [[0.0, 0.0]]  # before anything is drawn
        highest = min(y for _, y in tops)
        high = [x for x, y in tops if y <= highest + 1]
        groups: List[List[float]] = []
        for place in high:  # each crest is some columns wide
            if groups and place - groups[-1][-1] < 0.05:
                groups[-1].append(place)
            else:
                groups.append([place])
        return [start + sum(group) / len(group) * (end - start) for group in groups]

    def test_older_bag_is_overlaid_with_an_offset_and_at_the_trigger(self) -> None:
        browser = self.browser
        setup = {
            **FRESH,
            "fields": [SINE, OLD, APART],
            "window": 2.0,
            "trigger": {"mode": "off", "field": SINE, "level": 0.5, "edge": "rising"},
            "measures": {"figures": ["rms"], "against": "", "between": False},
        }
        browser.open(f"{self.scope.url}#{quote(json.dumps(setup))}")
        self.go_to(5.0)
        self.wait_apart(LATE_S)
        # Its offset is typed; invalid text is rejected with an explanation.
        self.type_offset("0.13")
        self.wait_apart(LATE_S + 0.13)
        self.type_offset("1,5")
        wait_until(lambda: "ambiguous" in browser.text("#notice"), lambda: browser.text("#notice"))
        self.assertEqual(browser.value(OFFSET), "0.13")
        self.type_offset("0")
        self.wait_apart(LATE_S)
        # Without a trigger it cannot be aligned.
        align = browser.find("[aria-label='Align at the trigger: old']")
        align.send_keys(Keys.ENTER)
        wait_until(
            lambda: "a trigger first" in browser.text("#notice"), lambda: browser.text("#notice")
        )
        browser.choose("#trigger-mode", "single")
        browser.press("#playback-run")
        browser.wait_for("#trigger-state[data-state='triggered']")
        browser.wait_for("#playback-run[aria-pressed='false']")
        align.send_keys(Keys.ENTER)
        self.wait_apart(0.0)
        self.assertEqual(browser.errors(), [])

    def type_offset(self, text: str) -> None:
        """Replace the offset."""
        self.browser.wait_for(OFFSET).send_keys(Keys.CONTROL, "a", Keys.CONTROL, text, Keys.ENTER)

    def wait_apart(self, seconds: float) -> None:
        """Wait until the sines have a time difference [s], to a tenth of a sample."""
        rms = math.sqrt(2.0) * abs(math.sin(math.pi * seconds))
        slope = math.sqrt(2.0) * math.pi
        cell = f"#legend tr[data-field='{APART}'] [data-cell='rms']"
        wait_until(
            lambda: abs(number(self.browser.text(cell)) - rms) < slope * 0.1 / SINE_HZ,
            lambda: self.browser.text("#legend") + f"; not {rms}",
        )


class BrokenBags(unittest.TestCase):
    """Files that are not bags."""

    def test_non_bag_file_is_reported(self) -> None:
        node = roslib.packages.find_node("topic_scope", "scope.py")[0]
        reasons = {__file__: "is not a bag", __file__ + "x": "No such file"}
        started = {
            path: subprocess.Popen(
                [node, "--next-port", "--bag", path],
                stderr=subprocess.PIPE,
                universal_newlines=True,
            )
            for path in reasons
        }
        for path, process in started.items():
            text = process.communicate(timeout=30.0)[1]
            self.assertEqual(process.returncode, 1, text)
            self.assertRegex(text, rf"\Ascope.py: {path}:? {reasons[path]}.*\n\Z")
