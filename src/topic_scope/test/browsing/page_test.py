"""Base of the tests of the page: one browser, and one scope for each command line."""

import csv
import functools
import io
import json
import math
import time
import unittest
from typing import Any, ClassVar, Dict, List, Sequence, Tuple
from urllib.parse import unquote
from urllib.request import urlopen

from browsing.browser import Browser
from browsing.scope_process import ScopeProcess, SlowScopeProcess, shared_scope
from browsing.waiting import wait_until
from selenium.webdriver.remote.webelement import WebElement

SIGNAL, PROCESSED = "/signal/signal_y", "/proc_signal/data"
#: Frame interval of the page [ms]; few tests are about drawing.
FRAME_MS = 150
_AXIS = {"title": "", "low": None, "high": None}
#: Initial set-up of a page with the two signals.
FRESH: Dict[str, Any] = {
    "fields": [SIGNAL, PROCESSED],
    **{"hidden": [], "right": [], "colours": {}, "traces": {}},
    **{"window": 5, "baseWindow": 5, "persistence": 0, "cursors": None, "levels": None},
    "trigger": {"mode": "off", "field": "", "level": 0, "edge": "rising"},
    "axes": {"x": {"title": "time, s", "clock": False}, "y": _AXIS, "y2": _AXIS},
    "chart": {
        **{"kind": "time", "x": "", "window": "hann", "scale": "dB"},
        **{"averages": 1, "equal": False},
    },
    "measures": {
        "figures": ["rate", "value", "min", "max", "mean", "rms", "frequency"],
        **{"against": "", "between": False, "overTime": 0},
    },
    **{"panels": True, "images": {"shown": False, "topic": ""}, "view": "scope"},
}
FRESH["trigger"].update({"hysteresis": 0, "holdoff": 0, "position": 0.5})
#: Applies a set-up to an open page, and removes references and masks.
_SHOW = """
const [setup, done] = arguments;
for (const dialog of document.querySelectorAll("dialog[open]")) dialog.close();
document.activeElement.blur();
document.getElementById("mask-end").click();
document.getElementById("notice").textContent = "";
const filter = document.getElementById("filter");
filter.value = "";
filter.dispatchEvent(new Event("input", { bubbles: true }));
window.shownSetups = window.shownSetups ?? 0;
const show = (part) => new Promise((resolve) => {
  addEventListener("hashchange", resolve, { once: true });
  window.shownSetups += 1; // spaces, so that no address is like the one before
  location.hash = encodeURIComponent(JSON.stringify(part) + " ".repeat(window.shownSetups));
});
show({ view: "scope", fields: [] }).then(() => show(setup)).then(() => {
  const run = document.getElementById("run");
  if (run.textContent === "Run") run.click();
  requestAnimationFrame(done); // when it has been drawn
});
"""


@functools.lru_cache(maxsize=None)
def shared_browser() -> Browser:
    """Return the browser that all tests of a process share."""
    return Browser(frame_ms=FRAME_MS)


class BrowserTest(unittest.TestCase):
    """Test with a scope and a browser, which still shows the page of the previous test."""

    #: Arguments of the scope, except the port.
    ARGUMENTS: ClassVar[Sequence[str]] = ()
    browser: Browser
    scope: ScopeProcess

    @classmethod
    def setUpClass(cls) -> None:
        cls.scope = shared_scope(*cls.ARGUMENTS, kind=SlowScopeProcess)
        cls.browser = shared_browser()
        cls.scope.wait_until_served()
        cls.browser.errors()  # of previous tests

    @classmethod
    def leave_page(cls) -> None:
        """Leave the page after changes that a set-up does not undo; the next test reloads it."""
        cls.browser.driver.get("about:blank")

    @classmethod
    def is_open(cls) -> bool:
        """Return whether the browser shows a page of this scope."""
        return str(cls.browser.driver.current_url).startswith(cls.scope.url + "/")


class PageTest(BrowserTest):
    """Test with the two signals of the course, which checks for browser errors at its end.

    The page stays open from test to test, and only its set-up is reset. A test that changes more
    than a set-up contains calls :meth:`leave_page` at its end.
    """

    ARGUMENTS = (SIGNAL, PROCESSED, "--window", "5")
    #: Browser errors that a test provokes.
    expected_errors: List[str]

    def setUp(self) -> None:
        self.expected_errors = []
        self.browser.remove_downloads()
        if self.is_open():
            self.show()
        else:
            self.leave_page()
            self.browser.errors()  # of a page whose scope the previous test has stopped
            self.browser.open(self.scope.url)
            # A scope that has just started does not know the topics yet.
            wait_until(
                lambda: all(self.cell(field, "rate") > 0.0 for field in (SIGNAL, PROCESSED)),
                lambda: self.browser.text("#legend"),
            )
        self.browser.wait_for(f"#legend tr[data-field='{PROCESSED}'] [aria-label^='right axis']")

    def tearDown(self) -> None:
        errors = [
            error
            for error in self.browser.errors()
            if not any(expected in error for expected in self.expected_errors)
        ]
        self.assertEqual(errors, [])

    def show(self, **parts: Any) -> None:
        """Apply a set-up to the open page.

        :param parts: parts of the set-up that differ from a new page
        """
        self.browser.driver.execute_async_script(_SHOW, {**FRESH, **parts})

    def restore(self) -> None:
        """Apply the set-up of the page's address after another one, as a reload does."""
        address = unquote(self.browser.driver.current_url).partition("#")[2]
        self.show()
        self.browser.driver.execute_async_script(_SHOW, json.loads(address))

    def wait_drawn(self) -> None:
        """Wait until the latest changes are drawn: cursors are placed on the drawn axes."""
        self.browser.driver.execute_async_script("requestAnimationFrame(arguments[0])")

    def watch_writing(self) -> None:
        """Record the text drawn on canvases until the end of the test."""
        self.browser.run(
            "const kind = CanvasRenderingContext2D.prototype; window.written = [];"
            "window.writeOnCanvas = kind.fillText; kind.fillText = function(text, ...place) {"
            " window.written.push(text); return window.writeOnCanvas.call(this, text, ...place); };"
        )
        self.addCleanup(
            self.browser.run,
            "if (window.writeOnCanvas)"
            " CanvasRenderingContext2D.prototype.fillText = window.writeOnCanvas;",
        )

    def cell(self, field: str, name: str) -> float:
        """Return a number of the table; NaN for a dash."""
        text = self.browser.text(f"#legend tr[data-field='{field}'] [data-cell='{name}']")
        return math.nan if text in ("", "–") else float(text.replace("−", "-"))

    def csv(self) -> str:
        """Return the URL of the CSV file of the visible samples."""
        link = self.browser.find("#csv")
        self.browser.run("arguments[0].dispatchEvent(new Event('focus'))", link)
        return str(link.get_property("href"))

    def samples(self) -> List[Tuple[float, List[str]]]:
        """Return the rows of the CSV that the page links to."""
        with urlopen(self.csv()) as answer:
            head, *rows = csv.reader(io.TextIOWrapper(answer, "utf-8"))
        self.assertEqual(head[:2], ["time", "received"])
        return [(float(row[0]), row[2:]) for row in rows]

    def wait_moving(self) -> None:
        """Wait until the picture changes."""
        first = self.browser.picture()
        wait_until(lambda: self.browser.picture() != first, lambda: "the picture does not change")

    def wait_still(self) -> None:
        """Wait until the picture is unchanged for some frames."""
        seen = [self.browser.picture()]

        def still() -> bool:
            seen.append(self.browser.picture())
            return len(seen) > 6 and len(set(seen[-6:])) == 1

        wait_until(still, lambda: "the picture changes")

    def wait_in_place(self, *elements: WebElement) -> None:
        """Wait until elements do not move: new figures may move the table and the plots."""
        places: List[Tuple[float, Any]] = []  # since the last movement

        def stand_still() -> bool:
            rects, now = [element.rect for element in elements], time.monotonic()
            if places and places[-1][1] != rects:
                places.clear()
            places.append((now, rects))
            return now - places[0][0] > 0.5  # longer than between two figures of the server

        wait_until(stand_still, lambda: str(places[-1:]))

    def wait_banner(self, text: str) -> None:
        """Wait until the banner has a text; empty to wait until it disappears."""
        banner = "#banner:not([hidden]) #banner-text"
        wait_until(
            lambda: self.browser.text(banner) == text, lambda: self.browser.text("#banner-text")
        )
