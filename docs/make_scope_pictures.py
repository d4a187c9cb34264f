#!/usr/bin/env python3
"""Take the pictures of the oscilloscope for the README and these pages.

    ./ci/exec docs/make_scope_pictures.py

It starts a master, the course's nodes, motors and the scope, opens the page in Chromium without a
screen, and writes docs/images/scope_*.png. Debian's chromium-driver and python3-selenium are
needed; ci/test installs them.
"""

import os
import socket
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "src" / "topic_scope" / "test"))

from browsing.browser import Browser  # noqa: E402
from browsing.scope_process import ScopeProcess  # noqa: E402
from browsing.waiting import wait_until  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402

IMAGES = DOCS / "images"
SIGNAL, PROCESSED = "/signal/signal_y", "/proc_signal/data"
MOTOR = ("/group1/motor_input_u/data", "/group1/motor_speed_y/data")


@contextmanager
def running(*command: str) -> Iterator[None]:
    """Run a command for a while."""
    process = subprocess.Popen(command, stdout=sys.stderr)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def start(browser: Browser, url: str, theme: str) -> None:
    """Open the page with what a first look shows."""
    browser.open(url)
    if browser.run("return document.documentElement.dataset.theme") != theme:
        browser.keys("d")
    wait_full(browser)


def wait_full(browser: Browser) -> None:
    """Wait until measurements are there and the traces go from edge to edge."""
    wait_until(
        lambda: "–" not in browser.text("#legend [data-cell=frequency]"),
        lambda: browser.text("#legend"),
    )
    window = float(browser.value("#window"))
    first = browser.run("return performance.now()")
    wait_until(
        lambda: browser.run("return performance.now()") - first > 1100 * window,
        lambda: "time stands still",
    )


def trigger(browser: Browser) -> None:
    """Let the traces stand still by the trigger, with two cursors on them."""
    browser.choose("#window", "2")
    browser.choose("#trigger-mode", "normal")
    level = browser.find("#trigger-level")
    level.send_keys(Keys.CONTROL, "a")
    level.send_keys("0.5", Keys.ENTER)
    wait_until(
        lambda: browser.text("#trigger-state") == "triggered",
        lambda: browser.text("#trigger-state"),
    )
    browser.run("document.activeElement.blur()")
    browser.keys("c")
    wait_full(browser)


def show(browser: Browser, *fields: str) -> None:
    """Choose more traces."""
    browser.keys("a")
    for field in fields:
        search = browser.wait_for("#chooser-search")
        search.clear()
        search.send_keys(field)
        browser.wait_for("#chooser-list label").click()
    browser.keys(Keys.ESCAPE)


def take(browser: Browser, name: str, selector: str = "body") -> None:
    """Write a picture of a part of the page."""
    browser.run("document.activeElement.blur()")
    path = IMAGES / ("scope_%s.png" % name)
    path.write_bytes(browser.find(selector).screenshot_as_png)
    print("%s: %d kB" % (path.name, path.stat().st_size // 1000))


def take_all(browser: Browser, url: str) -> None:
    """Go through the page."""
    start(browser, url, "light")
    trigger(browser)
    take(browser, "light")

    start(browser, url, "dark")
    subprocess.run(["rosparam", "set", "/group1/sp_gen_1/omega", "2.5"], check=True)
    show(browser, *MOTOR)
    browser.find("[aria-label='right axis for %s']" % MOTOR[1]).click()
    browser.choose("#window", "5")
    wait_full(browser)
    take(browser, "dark")

    start(browser, url, "light")
    amplitude = "[data-name=amplitude] .value"
    browser.find(amplitude).send_keys(Keys.CONTROL, "a")
    browser.find(amplitude).send_keys("-1", Keys.ENTER)
    browser.wait_for("[data-name=amplitude] .refusal")
    browser.find("[aria-label$='signal_generator/reset: Reset']").click()
    wait_until(lambda: browser.text(".answer[data-service$=reset]"), lambda: "no answer")
    take(browser, "panels", "#panels")

    browser.keys("g")
    browser.wait_for("#graph .node")
    wait_until(
        lambda: browser.text("#graph .edge text").count("Hz") >= 6,
        lambda: browser.text("#graph .edge text"),
    )
    take(browser, "graph", "#graph-view")


def main() -> None:
    """Run everything on a master of its own."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % probe.getsockname()[1]
    course = ("roslaunch", "basic_comms", "cw1.launch", "signal_rate:=200")
    motors = ("roslaunch", "--wait", "motor_control", "motor_2.launch")
    with running(*course), running(*motors):
        scope = ScopeProcess(SIGNAL, PROCESSED, "--window", "5")
        browser = Browser()
        try:
            scope.wait_until_served()
            take_all(browser, scope.url)
        finally:
            browser.close()
            scope.stop()


if __name__ == "__main__":
    main()
