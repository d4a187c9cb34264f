#!/usr/bin/env python3
"""Take the pictures of the oscilloscope for the README and these pages.

    ./ci/exec src/topic_scope/test/make_pictures.py

It starts a master, the course's nodes, motors, a robot and the scope, opens the page in Chromium
without a screen, and writes docs/images/scope_*.png. ci/test installs what it needs:
chromium-driver, python3-selenium, and python3-pil, which comes with python3-matplotlib.
"""

import io
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator
from urllib.request import urlopen

from browsing.browser import Browser
from browsing.scope_process import ScopeProcess
from browsing.waiting import wait_until
from PIL import Image
from selenium.webdriver.common.keys import Keys

from nodekit.testing.processes import free_port

IMAGES = Path(__file__).resolve().parents[3] / "docs" / "images"
SIGNAL, PROCESSED = "/signal/signal_y", "/proc_signal/data"
RATE_HZ = 200.0
TRIES = 30
LARGEST = 150000  # bytes of a picture with all its colours
MOTOR = ("/group1/motor_input_u/data", "/group1/motor_speed_y/data")


@contextmanager
def running(*command: str) -> Iterator[None]:
    """Run a command during a ``with`` block."""
    process = subprocess.Popen(command, stdout=sys.stderr)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def start(browser: Browser, url: str, theme: str) -> None:
    """Open the page with its initial view."""
    browser.open(url)
    if browser.run("return document.documentElement.dataset.theme") != theme:
        browser.keys("d")
    wait_full(browser)


def wait_full(browser: Browser) -> None:
    """Wait until measurements are shown and the traces fill the window."""
    browser.wait_for("#legend tr")  # a page may open before the graph is known
    wait_until(
        lambda: "–" not in browser.text("#legend [data-cell=frequency]"),
        lambda: browser.text("#legend"),
    )
    window = float(browser.value("#window"))
    first = browser.run("return performance.now()")
    wait_until(
        lambda: browser.run("return performance.now()") - first > 1100 * window,
        lambda: "time does not move",
    )


def is_smooth(browser: Browser) -> bool:
    """Return whether samples arrived without a break, even on a busy computer."""
    browser.run("arguments[0].blur(); arguments[0].focus()", browser.find("#csv"))
    with urlopen(str(browser.find("#csv").get_property("href"))) as answer:
        rows = [line.decode().split(",") for line in answer][1:]
    # Of the second trace, whose messages have no stamps: it uses times of receipt.
    times = [float(row[1]) for row in rows if row[3]]
    return max(later - earlier for earlier, later in zip(times, times[1:])) < 3.0 / RATE_HZ


def trigger(browser: Browser) -> None:
    """Hold the traces by the trigger, with two cursors on them."""
    browser.choose("#window", "2")
    browser.choose("#trigger-mode", "single")
    level = browser.find("#trigger-level")
    level.send_keys(Keys.CONTROL, "a")
    level.send_keys("0.5", Keys.ENTER)
    browser.run("document.activeElement.blur()")
    browser.keys("c")
    for _ in range(TRIES):
        wait_until(lambda: browser.text("#run") == "Run", lambda: "it does not trigger")
        if is_smooth(browser):
            break
        browser.run("document.activeElement.blur()")
        browser.keys(Keys.SPACE)
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
    path = IMAGES / f"scope_{name}.png"
    picture = Image.open(io.BytesIO(browser.find(selector).screenshot_as_png))
    picture = picture.convert("RGB")
    picture.save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


def take_others(browser: Browser, url: str) -> None:
    """Take the pictures with motors."""
    start(browser, url, "dark")
    wait_until(
        lambda: subprocess.run(["rosparam", "get", "/group1/sp_gen_1/omega"]).returncode == 0,
        lambda: "no motors",
    )
    subprocess.run(["rosparam", "set", "/group1/sp_gen_1/omega", "2.5"], check=True)
    show(browser, *MOTOR)
    browser.find(f"[aria-label='right axis for {MOTOR[1]}']").click()
    browser.choose("#window", "5")
    for _ in range(TRIES):
        wait_full(browser)
        if is_smooth(browser):
            break
    take(browser, "dark")

    start(browser, url, "light")
    amplitude = ".panel[data-node='/signal_generator'] [data-name=amplitude] "
    browser.find(amplitude + ".value").send_keys(Keys.CONTROL, "a")
    browser.find(amplitude + ".value").send_keys("-1", Keys.ENTER)
    browser.wait_for(amplitude + ".refusal")
    browser.find("[aria-label$='signal_generator/reset: Reset']").click()
    wait_until(lambda: browser.text(".answer[data-service$=reset]"), lambda: "no answer")
    browser.run(
        "document.querySelector(\".panel[data-node='/signal_generator']\").scrollIntoView()"
    )
    take(browser, "panels", "#panels")

    browser.keys("g")
    browser.wait_for("#graph .node")
    wait_until(
        lambda: browser.text("#graph .edge text").count("Hz") >= 6,
        lambda: browser.text("#graph .edge text"),
    )
    take(browser, "graph", "#graph-view")


def take_robots(browser: Browser, url: str) -> None:
    """Send a robot to a goal, and wait until it is on its way."""
    start(browser, url, "light")
    browser.keys("r")
    browser.wait_for("#goal-topic option")
    for name, value in (("x", "-1.2"), ("y", "-1.6"), ("heading", "90")):
        browser.find(f"#goal-{name}").send_keys(value)
    wait_until(lambda: "odom" in browser.text("#robot-list"), lambda: "no robot")
    browser.find("#goal-send").click()
    wait_until(lambda: "−0.6" in browser.text("#robot-list"), lambda: browser.text("#robot-list"))
    take(browser, "robots")


def main() -> None:
    """Run everything on a master of its own."""
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{free_port()}"
    course = ("roslaunch", "basic_comms", "cw1.launch", f"signal_rate:={RATE_HZ:g}")
    motors = ("roslaunch", "motor_control", "motor_2.launch")
    robot = ("roslaunch", "diff_drive_sim", "diff_drive.launch", "world:=arena", "scan_rate:=10")
    controller = ("rosrun", "bot_controller_demo", "proportional_controller")
    with running(*course):
        scope = ScopeProcess(SIGNAL, PROCESSED, "--window", "5")
        browser = Browser()
        try:
            scope.wait_until_served()
            start(browser, scope.url, "light")
            browser.wait_for("[data-name=amplitude]")
            trigger(browser)
            take(browser, "light")
            with running(*motors):
                take_others(browser, scope.url)
            with running(*robot), running(*controller):
                take_robots(browser, scope.url)
        finally:
            browser.close()
            scope.stop()


if __name__ == "__main__":
    main()
