#!/usr/bin/env python3
"""Sweeps of the trigger over one another: jitter shows as a band, where no master is."""

import json
import os
import pathlib
import tempfile
import unittest
from typing import List, Tuple
from unittest import mock
from urllib.parse import quote

import genpy
import rosbag
import rosunit
from browsing.browser import Browser
from browsing.scope_process import ScopeProcess
from browsing.waiting import wait_until
from selenium.webdriver.common.keys import Keys
from std_msgs.msg import Float32

BEGIN, LENGTH_S, RATE_HZ, PERIOD_S = 1700000000, 40.0, 500, 0.1
FIELD = "/square/data"
#: When a square wave falls after it has risen, and by how much later than that in turn, s.
FALLS_S, JITTER_S = 0.03, (0.0, 0.008, 0.012, 0.004)
WINDOW_S, LOW, HIGH = 0.1, -0.5, 1.5
#: Where the trace passes this value, no line of the grid is.
LEVEL = 0.37
#: Where a row of the plot has the colour of the trace: parts of its width, and how bold, 0 to 255.
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
SETUP = {
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
    """Record a square wave whose falling edges jitter."""
    with rosbag.Bag(path, "w") as bag:
        for index in range(round(LENGTH_S * RATE_HZ)):
            cycle, place = divmod(index, round(PERIOD_S * RATE_HZ))
            falls = FALLS_S + JITTER_S[cycle % len(JITTER_S)]
            value = 1.0 if place < round(falls * RATE_HZ) else 0.0
            bag.write(
                "square",
                Float32(value),
                genpy.Time(BEGIN, 0) + genpy.Duration(0, index * 10**9 // RATE_HZ),
            )


class Sweeps(unittest.TestCase):
    """A square wave, held by the trigger."""

    scope: ScopeProcess
    browser: Browser

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        bag = str(pathlib.Path(folder.name, "square.bag"))
        record(bag)
        patch = mock.patch.dict(os.environ, ROS_MASTER_URI="http://localhost:1")
        patch.start()
        cls.addClassCleanup(patch.stop)
        cls.scope = ScopeProcess("--bag", bag, FIELD)
        cls.addClassCleanup(cls.scope.stop)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)
        cls.scope.wait_until_served()

    def falling(self) -> List[Tuple[float, int]]:
        """Return where falling edges are painted, s after the trigger, and how boldly."""
        found = self.browser.run(_PAINTED, (LEVEL - LOW) / (HIGH - LOW))
        places = [((part - 0.5) * WINDOW_S, bold) for part, bold in found]
        return [one for one in places if one[0] > FALLS_S / 2.0]

    def band(self) -> float:
        """Return how far apart the first and the last of them are, s."""
        places = [place for place, _ in self.falling()]
        return max(places) - min(places) if places else 0.0

    def test_jitter_shows_as_a_band_with_persistence_and_only_then(self) -> None:
        browser = self.browser
        browser.open(f"{self.scope.url}#{quote(json.dumps(SETUP))}")
        browser.wait_for("#trigger-state[data-state='armed']")
        browser.keys(" ")
        wait_until(lambda: self.falling(), lambda: browser.text("#trigger-state"))
        # One sweep has one edge.
        self.assertLess(self.band(), 0.001)
        # By keys alone; those who do not see the page learn what they choose.
        browser.find("#show-trigger").send_keys(Keys.ENTER)
        browser.wait_for("#trigger-persistence").send_keys("16")
        self.assertIn("persistence", [name for _, name, _ in browser.accessible()])
        browser.keys(Keys.ESCAPE)
        most = max(JITTER_S)
        wait_until(lambda: abs(self.band() - most) < 0.001, self.falling)
        # The latest one is bold, the others are paler.
        bold = [alpha for _, alpha in self.falling()]
        self.assertGreater(max(bold), 200)
        self.assertLess(min(bold), 180)
        # It stays while one looks at it, and in a set-up.
        browser.find("#playback-run").send_keys(Keys.ENTER)
        browser.wait_for("#playback-run[aria-pressed='false']")
        self.assertAlmostEqual(self.band(), most, delta=0.001)
        self.assertIn('"persistence":16', browser.run("return decodeURIComponent(location.hash)"))
        browser.find("#show-trigger").send_keys(Keys.ENTER)
        browser.wait_for("#trigger-persistence").send_keys("off")
        wait_until(lambda: self.band() < 0.001, self.falling)
        self.assertEqual(browser.errors(), [])


if __name__ == "__main__":
    rosunit.unitrun("topic_scope", "page_sweeps", Sweeps)
