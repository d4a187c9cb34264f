"""Bags on the wire and on the page, without a master."""

import math
import os
import pathlib
import re
import signal
import tempfile
import unittest
from typing import Any, Dict, List
from unittest import mock

import genpy
import rosbag
from browsing.browser import Browser
from browsing.page_test import shared_browser
from browsing.scope_process import ScopeProcess, SlowScopeProcess
from browsing.waiting import wait_until
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Odometry, Path
from selenium.webdriver.common.keys import Keys
from sensor_msgs.msg import CompressedImage, Image, JointState, LaserScan
from std_msgs.msg import Header, String
from visualization_msgs.msg import Marker, MarkerArray
from wire.client import Client, Message, fetch, fetch_image

from basic_comms.msg import signal_msg
from nodekit.testing.running import extended

#: 2023-11-14, 22:13:20 UTC.
BEGIN, LENGTH_S, RATE_HZ = 1700000000, 20.0, 100.0
FIELD = "/signal/signal_y"


def write_robot(bag: Any, time: float, received: genpy.Time) -> None:
    """Record a robot that drives at 0.1 m/s in its world, and sees a wall 2 m ahead.

    It is silent after 18 s. Its world and its path were published only once.
    """
    if time == 0.0:
        walls = Marker(type=Marker.LINE_LIST, points=[Point(4, -1, 0), Point(4, 1, 0)])
        walls.header.frame_id = "odom"
        bag.write("world", MarkerArray([walls]), received)
    if time in (2.0, 12.0):
        goal = PoseStamped()
        goal.header.frame_id, goal.pose.position.x = "odom", time
        bag.write("goal", goal, received)
        path = Path(poses=[PoseStamped(), goal])
        path.header.frame_id = "odom"
        bag.write("plan", path, received)
    if time <= 18.0 and round(time * RATE_HZ) % 10 == 0:
        odometry = Odometry(child_frame_id="base")
        odometry.header.frame_id = "odom"
        odometry.pose.pose.position.x, odometry.twist.twist.linear.x = 0.1 * time, 0.1
        bag.write("odom", odometry, received)
        scan = LaserScan(range_max=9.0, angle_increment=0.1, ranges=[2.0])
        scan.header.frame_id = "base"
        bag.write("scan", scan, received)


def write_camera(bag: Any, time: float, received: genpy.Time) -> None:
    """Record images ten times a second, 50 ms after their stamps; the red is 10 times the time.

    Beside them, a file that is not an image.
    """
    stamp = received - genpy.Duration(0, 50 * 10**6)
    colour = bytes([round(10.0 * time), 100, 200])
    image = Image(Header(stamp=stamp), 30, 40, "rgb8", 0, 120, colour * 1200)
    bag.write("camera", image, received)
    if time == 0.0:
        broken = CompressedImage(Header(stamp=stamp), "jpeg", b"\xff\xd8\xff and no more")
        bag.write("broken", broken, received)
        bag.write("yuv", Image(Header(stamp=stamp), 2, 2, "yuv422", 0, 4, bytes(8)), received)


def record(path: str) -> None:
    """Record a sine of 1 Hz with another zero of its clock, and a growing amplitude.

    The bag also contains a robot, its mode as a text, and a camera.
    """
    with rosbag.Bag(path, "w", chunk_threshold=10000) as bag:
        for index in range(int(LENGTH_S * RATE_HZ) + 1):
            time = index / RATE_HZ
            value = time * math.sin(2.0 * math.pi * time)
            message = signal_msg(2.0, 6.2832, 5.0 + time, value)
            received = genpy.Time(BEGIN, index * round(1e9 / RATE_HZ))
            bag.write("signal", message, received)
            if index % RATE_HZ == 0:
                bag.write("mode", String("driving" if 3.0 <= time < 12.0 else "idle"), received)
            if index % RATE_HZ == 50:
                bag.write("joints", JointState(name=["wheel"], position=[time]), received)
            write_robot(bag, time, received)
            if index % 10 == 0:
                write_camera(bag, time, received)


class Bag(unittest.TestCase):
    """Bag of 20 s, whose first 5 s are shown at start."""

    scope: ScopeProcess
    path: str

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = str(pathlib.Path(folder.name, "sine.bag"))
        record(cls.path)
        # Without a master.
        patch = mock.patch.dict(os.environ, ROS_MASTER_URI="http://localhost:1")
        patch.start()
        cls.addClassCleanup(patch.stop)
        cls.scope = SlowScopeProcess("--bag", cls.path, "--window", "5", "--history", "6", FIELD)
        cls.addClassCleanup(cls.scope.stop)
        cls.scope.wait_until_served()

    @classmethod
    def tearDownClass(cls) -> None:
        os.kill(cls.scope.pid, signal.SIGINT)
        status = cls.scope.stop()
        assert status == 0, f"after Ctrl-C it ended with {status}"

    def page(self) -> Client:
        client = Client(self.scope.url)
        self.addCleanup(client.close)
        client.wait_for("hello")
        return client

    def play(self, page: Client, **wanted: Any) -> Dict[str, Any]:
        """Change the playback; return the message that confirms it."""
        page.wait_for("playback")
        jumps = page.messages("playback")[-1]["jumps"] + ("time" in wanted)
        page.forget()
        page.send("playback", **wanted)
        # Earlier messages may arrive in between.
        return page.wait_for(
            "playback", lambda reply: reply["jumps"] >= jumps and not reply["loading"]
        )

    def wait_text(self, browser: Browser, selector: str, text: str) -> None:
        """Wait until an element has a text."""
        wait_until(lambda: text in browser.text(selector), lambda: browser.text(selector))

    def painted(self, browser: Browser, name: str) -> int:
        """Return the number of pixels of a theme colour in the robot view."""
        code = """
          const canvas = document.querySelector("#robot-canvas");
          const colour = getComputedStyle(document.documentElement).getPropertyValue(arguments[0]);
          const wanted = colour.match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));
          const { width, height } = canvas;
          const copy = new OffscreenCanvas(width, height);
          const context = copy.getContext("2d", { willReadFrequently: true });
          context.drawImage(canvas, 0, 0);
          const { data } = context.getImageData(0, 0, width, height);
          let count = 0;
          for (let at = 0; at < data.length; at += 4) {
            if (wanted.every((part, place) => Math.abs(data[at + place] - part) < 40)) count += 1;
          }
          return count;
        """
        return int(browser.run(code, "--" + name))

    def shown(self, page: Client) -> float:
        """Return the shown time since the start [s]."""
        page.wait_for("frame")
        return float(page.messages("frame")[-1]["now"]) - BEGIN

    def test_pages_play_pause_and_seek(self) -> None:
        page = self.page()
        hello = page.messages("hello")[0]
        self.assertEqual(hello["bag"]["name"], "sine.bag")
        self.assertAlmostEqual(hello["bag"]["start"], BEGIN, 5)
        self.assertAlmostEqual(hello["bag"]["end"], BEGIN + LENGTH_S, 5)
        self.play(page, time=BEGIN + 15.0)
        reply = self.play(page, time=BEGIN + 5.001, playing=False, speed=1.0)
        self.assertEqual((reply["playing"], reply["speed"]), (False, 1.0))
        # All earlier samples are shown, and no later ones: the sine has grown up to 4.75.
        wait_until(lambda: page.values(FIELD), lambda: page.messages("frame"))
        wait_until(lambda: abs(self.shown(page) - 5.001) < 1e-4, lambda: self.shown(page))
        self.assertAlmostEqual(min(page.values(FIELD)), -4.75, 2)
        # The stamps are by the signal's clock; the receipt times are the bag's.
        rows = [
            row.split(",") for row in fetch(f"{self.scope.url}/data.csv?field={FIELD}")[1].split()
        ]
        self.assertEqual(rows[0], ["time", "received", FIELD])
        self.assertEqual(len(rows), 502)
        self.assertAlmostEqual(float(rows[101][0]), BEGIN + 1.0, 4)
        self.assertAlmostEqual(float(rows[101][1]), BEGIN + 1.0, 4)
        self.assertEqual(float(rows[26][2]), 0.25)
        # To the end, and not further.
        page.forget()
        page.send("playback", speed=50.0, playing=True)
        page.wait_for("playback", lambda reply: reply["playing"])
        page.wait_for("playback", lambda reply: not reply["playing"])
        wait_until(
            lambda: page.messages("frame")[-1]["now"] > BEGIN + LENGTH_S - 1e-3,
            lambda: page.messages("frame")[-1:],
        )
        self.assertAlmostEqual(max(page.values(FIELD)), 19.25, 2)
        # From the start again; a page that opens meanwhile sees it, too.
        reply = self.play(page, speed=0.01, playing=True)
        self.assertTrue(reply["playing"])
        other = self.page()
        self.assertLess(self.shown(other), 5.0)
        self.assertTrue(other.wait_for("playback")["playing"])

    def test_trace_chosen_later_has_its_history(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False)
        page.send("select", fields=["/signal/time_x"])
        wait_until(lambda: page.values("/signal/time_x"), lambda: page.messages("frame"))
        self.assertAlmostEqual(min(page.values("/signal/time_x")), 5.0, 1)
        self.assertAlmostEqual(max(page.values("/signal/time_x")), 10.0)
        # Names of elements are known from its messages.
        name = "/joints/position[wheel]"
        self.page().wait_for(
            "fields", lambda reply: name in [one["field"] for one in reply["fields"]]
        )
        page.send("select", fields=[name])
        wait_until(lambda: page.values(name), lambda: page.messages("frame"))
        self.assertEqual(sorted(set(page.values(name))), [0.5, 1.5, 2.5, 3.5, 4.5])

    def test_image_of_any_time_comes_from_the_bag(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False)
        url = self.scope.url
        self.assertIn(
            "images of /camera are not received", fetch_image(url, "/camera")[0]["problem"]
        )
        page.send("images", topic="/camera")

        def newest(place: float) -> Any:
            found, kind, file = fetch_image(url, "/camera")
            return abs(found.get("time", 0.0) - BEGIN - place) < 1e-6 and (found, kind, file)

        found, kind, file = wait_until(lambda: newest(4.95), lambda: fetch_image(url, "/camera"))
        self.assertEqual(
            (kind, file[:4], found["text"]), ("image/png", b"\x89PNG", "40 × 30, rgb8")
        )
        # By its stamp, not by its time of recording.
        for asked, place in ((3.04, 2.95), (3.06, 3.05), (0.01, -0.05)):
            found, *_ = fetch_image(url, "/camera", time=str(BEGIN + asked))
            self.assertAlmostEqual(found["time"] - BEGIN, place, 5)
        found, kind, file = fetch_image(url, "/camera", known=found["known"], time=str(BEGIN))
        self.assertEqual((kind, file), ("", b""))
        self.assertNotIn("problem", found)
        status, _ = fetch(f"{url}/image?topic=/camera&time=soon")
        self.assertEqual(status, 400)
        # After a jump the images are of its history.
        self.play(page, time=BEGIN + 15.001)
        wait_until(lambda: newest(14.95), lambda: fetch_image(url, "/camera"))
        problem = fetch_image(url, "/camera", time=str(BEGIN + 3.0))[0]["problem"]
        self.assertEqual(problem, "no image at this time: the first is 6.05 s after it")

    @extended
    def test_the_page_shows_the_image_of_the_cursor(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False, speed=1.0)
        browser = shared_browser()
        self.addCleanup(browser.driver.get, "about:blank")
        zone = "Emulation.setTimezoneOverride"
        self.addCleanup(browser.driver.execute_cdp_cmd, zone, {"timezoneId": ""})
        browser.driver.execute_cdp_cmd(zone, {"timezoneId": "UTC"})
        browser.errors()  # of previous tests
        browser.open(self.scope.url)
        browser.wait_for(f"#legend tr[data-field='{FIELD}']")
        browser.keys("i")
        # The first by its name cannot be decoded.
        self.wait_text(browser, "#image-text", "the browser cannot decode the image: jpeg, ")
        self.assertFalse(browser.find("#image").is_displayed())
        browser.choose("#image-topic", "/camera")
        self.wait_text(browser, "#image-text", "22:13:24.950 UTC, 40 × 30, rgb8")
        self.wait_pixel(browser, [50, 100, 200])
        # Cursor A, at 35 % of the 5 s.
        browser.press("#cursors")
        self.wait_text(browser, "#image-text", "22:13:21.7")
        self.wait_text(browser, "#image-text", " s before cursor A, 40 × 30, rgb8")
        self.wait_pixel(browser, [18, 100, 200])
        browser.press("#cursors")
        # The newest while it plays.
        browser.press("#playback-run")
        wait_until(lambda: self.pixel(browser)[0] > 55, lambda: browser.text("#image-text"))
        self.play(page, time=BEGIN + 5.001, playing=False)
        browser.choose("#image-topic", "/yuv")
        self.wait_text(browser, "#image-text", "unsupported encoding 'yuv422'")
        self.assertFalse(browser.find("#image").is_displayed())
        # It is in the address.
        wait_until(lambda: "yuv" in browser.driver.current_url, lambda: browser.driver.current_url)
        browser.driver.refresh()
        self.wait_text(browser, "#image-text", "unsupported encoding 'yuv422'")
        self.assertEqual(browser.value("#image-topic"), "/yuv")
        browser.press("#show-images")
        self.assertFalse(browser.find("#images").is_displayed())
        self.assertEqual(browser.errors(), [])

    @extended
    def test_the_clock_of_a_topic_is_chosen_in_its_row(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False)
        name = "/camera/width"
        page.send("select", fields=[FIELD, name])
        page.wait_for("stats", lambda reply: reply["clocks"] == ["/signal"])
        browser = shared_browser()
        self.addCleanup(browser.driver.get, "about:blank")
        browser.errors()  # of previous tests
        browser.open(self.scope.url)
        browser.wait_for(f"#legend tr[data-field='{FIELD}']")
        browser.keys("a")
        browser.wait_for("#chooser-search").send_keys(name, Keys.ENTER, Keys.ESCAPE)
        row, source = f"#legend tr[data-field='{name}']", f"[data-control='timestamp {name}']"
        browser.wait_for(f"{source} option[value='clock of /signal']")
        own = browser.find(f"[data-control='timestamp {FIELD}']").text
        self.assertNotIn("clock of", own)  # no other clock is estimated
        browser.choose(source, "clock of /signal")
        text = "by the clock of /signal, shifted by 1.7e+09 s"
        page.wait_for(
            "stats", lambda reply: reply["traces"].get(name, {}).get("correction") == text
        )
        # A wrong choice can be undone: the list stays.
        self.wait_text(browser, row, "no sample in this span: the first is 1.7e+09 s after it")
        browser.wait_for(source)
        # Another page has it, too, and one that is loaded again.
        browser.driver.refresh()
        browser.wait_for(source)
        wait_until(
            lambda: browser.value(source) == "clock of /signal", lambda: browser.text("#legend")
        )
        browser.choose(source, "")
        page.forget()
        page.wait_for("stats", lambda reply: reply["traces"][name]["clock"] is None)
        wait_until(lambda: browser.value(source) == "", lambda: browser.text("#legend"))
        self.assertNotIn("clock of", browser.text(f"{row} .badge"))
        page.send("clock", topic="/camera", leader="/odom")
        error = page.wait_for("error")["text"]
        self.assertIn("/odom has no separate clock; topics with one: /signal", error)
        self.assertEqual(browser.errors(), [])

    def wait_pixel(self, browser: Browser, colour: List[int]) -> None:
        """Wait until the image has a colour: it is decoded after its text is shown."""
        wait_until(lambda: self.pixel(browser) == colour, lambda: self.pixel(browser))

    def pixel(self, browser: Browser) -> Any:
        """Return red, green and blue of a pixel in the middle of the image."""
        code = """
          const image = document.querySelector("#image");
          const context = new OffscreenCanvas(40, 30).getContext("2d");
          if (image.complete && image.naturalWidth) context.drawImage(image, 0, 0);
          return [...context.getImageData(20, 15, 1, 1).data.slice(0, 3)];
        """
        return browser.run(code)

    def at(self, page: Client, x: float) -> Message:
        """Return the robot message at a position [m]."""
        reply = page.wait_for(
            "robots", lambda reply: [one for one in reply["robots"] if abs(one["x"] - x) < 1e-6]
        )
        self.assertEqual([one["topic"] for one in reply["robots"]], ["/odom"])
        return reply

    @extended
    def test_robots_follow_the_clock_of_the_bag(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 15.05, playing=False, speed=1.0)
        page.send("robots", on=True)
        reply = self.at(page, 1.5)
        self.assertEqual(reply["robots"][0]["speed"], 0.1)
        self.assertFalse(reply["robots"][0]["silent"])
        self.assertEqual(reply["scans"][0]["ranges"], [2000])
        self.assertAlmostEqual(reply["scans"][0]["at"][4], 1.5)
        # The world was published 15 s ago, longer than the history of traces.
        scenery = page.wait_for("scenery", lambda reply: reply["goals"])
        self.assertEqual([one["kind"] for one in scenery["markers"]], ["lines"])
        self.assertEqual([one["x"] for one in scenery["goals"]], [12.0])
        self.assertEqual([one["points"] for one in scenery["paths"]], [[0.0, 0.0, 12.0, 0.0]])
        # Earlier: later messages are unknown.
        self.play(page, time=BEGIN + 5.05)
        self.at(page, 0.5)
        scenery = page.wait_for("scenery", lambda reply: reply["goals"])
        self.assertEqual([one["x"] for one in scenery["goals"]], [2.0])
        self.play(page, time=BEGIN + 1.05)
        self.at(page, 0.1)
        scenery = page.wait_for("scenery", lambda reply: not reply["goals"])
        self.assertEqual((len(scenery["markers"]), scenery["paths"]), (1, []))
        # It runs and pauses with the clock; a pause is not silence.
        page.forget()
        page.send("playback", playing=True, speed=5.0)
        page.wait_for("robots", lambda reply: reply["robots"][0]["x"] > 0.4)
        self.play(page, playing=False, speed=1.0)
        # A second page sees the same. Without messages for 2 s, the robot is silent.
        other = self.page()
        other.send("robots", on=True)
        reply = other.wait_for("robots", lambda reply: reply["robots"][0]["x"] > 0.4)
        self.assertFalse(reply["robots"][0]["silent"])
        page.forget()
        page.send("playback", time=BEGIN + LENGTH_S)
        reply = self.at(page, 1.8)
        self.assertEqual((reply["robots"][0]["silent"], reply["scans"]), (True, []))

    def test_requests_that_need_nodes_are_rejected(self) -> None:
        page = self.page()
        for kind, content in (
            ("graph", {"on": True}),
            ("set", {"node": "/n", "name": "a", "value": 1}),
            ("steer", {"topic": "/cmd_vel"}),
        ):
            page.forget()
            page.send(kind, **content)
            self.assertIn("this is a bag", page.wait_for("error")["text"])
        self.assertEqual(page.messages("panels"), [])

    @extended
    def test_the_page_shows_a_text_as_a_band_below_the_plots(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False, speed=1.0)
        browser = shared_browser()
        self.addCleanup(browser.driver.get, "about:blank")
        browser.errors()  # of previous tests
        browser.open(self.scope.url)
        browser.wait_for(f"#legend tr[data-field='{FIELD}']")
        browser.run(
            "const kind = CanvasRenderingContext2D.prototype, write = kind.fillText;"
            "window.written = []; kind.fillText = function(text, ...place) {"
            " if (this.canvas.parentElement.id === 'bands') window.written.push(text);"
            " return write.call(this, text, ...place); };"
        )
        browser.keys("a")
        browser.wait_for("#chooser-search").send_keys("/mode/data", Keys.ENTER, Keys.ESCAPE)
        row = "#legend tr[data-field='/mode/data.state']"
        browser.wait_for(row)

        def written() -> Any:
            return browser.run("return window.written.slice(-3)")

        wait_until(lambda: written() == ["/mode/data.state", "idle", "driving"], written)
        value = f"{row} [data-cell='value']"
        wait_until(lambda: browser.text(value) == "driving", lambda: browser.text("#legend"))
        self.assertEqual(browser.text(f"{row} [data-cell='frequency']"), "–")
        title = browser.find(f"{row} [data-cell='frequency']").get_attribute("title")
        self.assertEqual(title, "not measurable: a state has no numbers")

        def under_pointer(part: float) -> str:
            browser.run(
                "const bands = document.querySelector('#bands');"
                "const { top } = bands.getBoundingClientRect();"
                "const area = document.querySelector('#overlay').getBoundingClientRect();"
                "bands.dispatchEvent(new PointerEvent('pointermove', {bubbles: true,"
                " clientX: area.left + arguments[0] * area.width, clientY: top + 20}))",
                part,
            )
            return browser.text(".hover")

        # From 0 to 5 s; the page counts from its right edge.
        self.assertRegex(under_pointer(0.3), r"idle, since \S+ or earlier, until \S+")
        self.assertRegex(under_pointer(0.9), r"driving, since \S+, still so")
        # It has no axis, and is not offered for the trigger or the XY plot.
        self.assertEqual(browser.count(f"{row} [aria-label^='right axis']"), 0)
        self.assertEqual(browser.text("#trigger-field"), FIELD)
        self.assertEqual(browser.errors(), [])

    @extended
    def test_the_page_shows_it_with_its_own_clock(self) -> None:
        page = self.page()
        self.play(page, time=BEGIN + 5.001, playing=False, speed=1.0)
        browser = shared_browser()
        self.addCleanup(browser.driver.get, "about:blank")
        zone = "Emulation.setTimezoneOverride"
        self.addCleanup(browser.driver.execute_cdp_cmd, zone, {"timezoneId": ""})
        browser.driver.execute_cdp_cmd(zone, {"timezoneId": "UTC"})
        browser.errors()  # of previous tests
        browser.open(self.scope.url)
        browser.wait_for(f"#legend tr[data-field='{FIELD}']")
        wait_until(
            lambda: browser.text(".dygraph-xlabel") == "time, 2023-11-14, UTC",
            lambda: browser.text("#plot"),
        )
        self.assertIn("22:13:23", browser.text(".dygraph-axis-label-x"))
        place = "2023-11-14 22:13:25.00 UTC, 5.00 of 20.00 s"
        wait_until(
            lambda: browser.text("#playback-time") == place,
            lambda: browser.text("#playback-time"),
        )
        self.assertEqual(browser.text("#run"), "Run")
        self.assertFalse(browser.find("#show-graph").is_displayed())
        buttons = browser.driver.find_elements("css selector", ".run")
        self.assertEqual([one.text for one in buttons if one.is_displayed()], ["Run"])
        # A key plays and pauses it.
        first = browser.picture()
        browser.keys(" ")
        wait_until(lambda: browser.picture() != first, lambda: "the picture does not change")
        wait_until(lambda: browser.text("#run") == "Pause", lambda: browser.text("#run"))
        browser.keys(" ")
        wait_until(lambda: browser.text("#run") == "Run", lambda: browser.text("#run"))
        page.wait_for("playback", lambda reply: reply["playing"])
        wait_until(lambda: not page.messages("playback")[-1]["playing"], lambda: "it continues")
        # Moving the slider by keys seeks.
        browser.find("#playback-place").send_keys(Keys.END)
        wait_until(
            lambda: (
                "20.00 of 20.00 s" in browser.text("#playback-time")
                and "22:13:38" in browser.text(".dygraph-axis-label-x")
            ),
            lambda: browser.text("#playback-time") + browser.text("#plot"),
        )
        # From the end it restarts; the slider still has the focus.
        browser.keys(" ")
        wait_until(
            lambda: (
                page.messages("playback")[-1]["playing"]
                and re.search(r"UTC, [0-9]\.\d\d of", browser.text("#playback-time"))
            ),
            lambda: browser.text("#playback-time"),
        )
        browser.keys(" ")
        wait_until(lambda: browser.text("#run") == "Run", lambda: browser.text("#run"))
        browser.keys("g")
        wait_until(lambda: "no nodes" in browser.text("#notice"), lambda: browser.text("#notice"))
        self.assertTrue(browser.find("#scope-view").is_displayed())
        # Robots are shown only; the bag is played and seeked beside them.
        self.play(page, time=BEGIN + 15.05)
        browser.keys("r")
        self.wait_text(browser, "#robot-list", "odom: 1.50, 0.00 m, 0°, 0.1 m/s")
        # The path is a line across the picture, and the laser's echo a dot of three pixels.
        wait_until(
            lambda: self.painted(browser, "good") > 200 and 3 < self.painted(browser, "bad") < 30,
            lambda: [self.painted(browser, colour) for colour in ("good", "bad")],
        )
        self.assertFalse(browser.find("#robot-drive").is_displayed())
        self.assertFalse(browser.find("#robot-goal").is_displayed())
        browser.keys(" ")
        wait_until(
            lambda: "1.50" not in browser.text("#robot-list"), lambda: browser.text("#robot-list")
        )
        browser.wait_for("#playback-run[aria-pressed='true']").click()
        browser.wait_for("#playback-run[aria-pressed='false']")
        browser.find("#playback-place").send_keys(Keys.HOME)
        self.wait_text(browser, "#robot-list", "odom: 0.00, 0.00 m, 0°, 0.1 m/s")
        self.assertEqual(browser.errors(), [])
