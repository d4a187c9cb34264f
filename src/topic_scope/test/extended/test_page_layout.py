"""Layout of the page on usual screens: no overlaps, nothing cut off."""

import json
from typing import Any, Dict, List
from urllib.parse import quote

import rospy
from browsing.browser import HEIGHT, WIDTH
from browsing.page_test import PROCESSED, SIGNAL, BrowserTest, PageTest
from browsing.waiting import wait_until
from nav_msgs.msg import Odometry
from selenium.webdriver.common.keys import Keys
from wire.robot import Robot

LAPTOP, SCREEN, PHONE = (1366, 768), (1920, 1080), (390, 844)
#: Topic without a publisher, whose row has a text in place of figures.
LONG = "/robot1/left_arm/joint_states/position[shoulder]"
#: Boxes of visible elements.
_BOXES = """
return [...document.querySelectorAll(arguments[0])].filter((one) => one.checkVisibility())
  .map((one) => { const { left, top, right, bottom } = one.getBoundingClientRect();
    return { left, top, right, bottom, text: one.textContent }; })
"""
#: Number of lines of each unbreakable part of the names.
_LINES = """
return [...document.querySelectorAll("#legend .name > span:first-of-type")].flatMap((name) =>
  [...name.childNodes].filter((one) => one.nodeType === Node.TEXT_NODE).map((part) => {
    const range = document.createRange();
    range.selectNodeContents(part);
    return range.getClientRects().length; }))
"""
#: Widths of the labels of a goal's numbers, and the widths needed for one line.
_ROOM = """
return [...document.querySelectorAll(".goal-numbers label")].map((label) => {
  const range = document.createRange();
  range.selectNodeContents(label.firstChild);
  return { room: label.clientWidth, needed: range.getBoundingClientRect().width,
    lines: range.getClientRects().length }; })
"""
#: Sizes of controls; for a control in a label, of the label.
_TARGETS = """
return [...document.querySelectorAll("button, select, input, a[href], summary, .handle")]
  .filter((one) => one.checkVisibility())
  .map((one) => { const { width, height } = (one.closest("label") ?? one).getBoundingClientRect();
    return { width, height, what: one.outerHTML.slice(0, 90) }; })
"""

Box = Dict[str, Any]


def overlap(one: Box, other: Box) -> bool:
    """Return whether two boxes overlap."""
    across = min(one["right"], other["right"]) - max(one["left"], other["left"])
    down = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
    return across > 0.5 and down > 0.5


class Layout(BrowserTest):
    """Layout of the page; all in one session."""

    ARGUMENTS = PageTest.ARGUMENTS

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.addClassCleanup(cls.leave_page)
        cls.addClassCleanup(cls.browser.resize, WIDTH, HEIGHT)
        cls.open_page()
        cls.browser.wait_for(f"#legend tr[data-field='{PROCESSED}']")

    @classmethod
    def open_page(cls) -> None:
        """Load the page with two traces, and one without data."""
        cls.leave_page()
        setup = {"fields": [SIGNAL, PROCESSED, LONG]}
        cls.browser.open(f"{cls.scope.url}#{quote(json.dumps(setup))}")

    def tearDown(self) -> None:
        self.browser.resize(*LAPTOP)
        self.assertEqual(self.browser.errors(), [])

    def boxes(self, selector: str) -> List[Box]:
        """Return the boxes of visible elements."""
        found: List[Box] = self.browser.run(_BOXES, selector)
        return found

    def resize(self, width: int, height: int) -> None:
        """Resize the page, and wait until everything is redrawn."""
        self.browser.resize(width, height)
        for _ in range(2):  # a redrawn element may move its neighbours
            self.browser.driver.execute_async_script("requestAnimationFrame(arguments[0])")

    def show_cursors(self) -> None:
        """Show cursors of both kinds until the end of the test."""
        for button in ("#cursors", "#level-cursors"):
            self.browser.run("document.querySelector(arguments[0]).click()", button)
        self.addCleanup(self.browser.keys, "v", "c")
        wait_until(lambda: len(self.boxes(".handle b")) == 4, lambda: self.boxes(".handle b"))

    def test_all_figures_and_labels_are_visible_with_cursors(self) -> None:
        self.show_cursors()
        for size in (LAPTOP, SCREEN, PHONE):
            self.resize(*size)
            labels, readouts = self.boxes(".handle b"), self.boxes(".overlay .readout")
            self.assertEqual([len(labels), len(readouts)], [4, 2])
            for label in labels:
                self.assertFalse(any(overlap(label, one) for one in readouts), (size, label))
            self.assertFalse(overlap(*readouts), (size, readouts))
            for field in (SIGNAL, PROCESSED):
                row = f"#legend tr[data-field='{field}'] "
                cells, buttons = self.boxes(row + "[data-cell]"), self.boxes(row + "td:last-child")
                self.assertEqual([len(cells), len(buttons)], [10, 0 if size == PHONE else 1])
                for cell in cells:
                    self.assertFalse(any(overlap(cell, one) for one in buttons), (size, cell))
                    self.assertTrue(0 <= cell["left"] and cell["right"] <= size[0], (size, cell))

    def test_names_are_broken_between_their_parts_alone(self) -> None:
        self.show_cursors()
        for size in (LAPTOP, SCREEN, PHONE):
            self.resize(*size)
            lines = self.browser.run(_LINES)
            self.assertGreater(len(lines), 8)
            self.assertEqual(set(lines), {1}, size)
        row = f"#legend tr[data-field='{LONG}'] .name > span:first-of-type"
        self.assertEqual(self.browser.text(row), LONG)

    def show_robots(self) -> None:
        """Show the robots until the end of the test."""
        self.browser.keys("r")
        self.addCleanup(self.browser.keys, "r")

    def test_missing_robots_are_explained(self) -> None:
        self.show_robots()
        for part, what in (("drive", "Twist"), ("goal", "PoseStamped")):
            reason = self.browser.wait_for(f"#{part}-topic-none").text
            self.assertIn(f"no node subscribes to geometry_msgs/{what}", reason)
            self.assertFalse(self.browser.find(f"#{part}-topic").is_enabled())

    def test_one_robot_with_two_odometries_is_listed_once(self) -> None:
        robot = Robot("/al/")
        self.addCleanup(robot.close)
        truth = rospy.Publisher("/al/ground_truth", Odometry, queue_size=1)
        self.addCleanup(truth.unregister)
        message = Odometry(child_frame_id="base")
        message.header.frame_id = "odom"
        message.pose.pose.position.x = 0.25
        message.pose.pose.orientation.w = 1.0
        self.show_robots()

        def listed() -> str:
            truth.publish(message)
            return self.browser.text("#robot-list button")

        said = "al: 0.00, 0.00 m, 0°, 0 m/s\nal/ground_truth is 0.25 m and 0° away"
        wait_until(lambda: listed() == said, listed)
        self.assertEqual(self.browser.count("#robot-list li"), 1)
        self.assertFalse(self.boxes("#goal-topic-none, #drive-topic-none"))
        for size in (LAPTOP, SCREEN, PHONE):  # the numbers of a goal are not cut off
            self.resize(*size)
            labels = self.browser.run(_ROOM)
            self.assertEqual([label["lines"] for label in labels], [1, 1, 1], size)
            for label in labels:
                self.assertGreaterEqual(label["room"], label["needed"], (size, label))

    def test_phone_layout_has_the_plot_first_and_large_targets(self) -> None:
        browser = self.browser
        self.resize(*PHONE)
        self.open_page()
        browser.wait_for(f"#legend tr.gone[data-field='{LONG}']")  # then without choices
        self.fits_a_phone("folded")
        (stage,) = self.boxes("#stage")
        self.assertLess(stage["top"], 60)
        self.assertGreater(stage["bottom"] - stage["top"], 0.45 * PHONE[1])
        folded = "#trigger, #csv, #show-setup, #theme, #kind, #panels, #legend .choice"
        self.assertEqual(self.boxes(folded), [])
        browser.press("#show-controls")
        self.addCleanup(browser.run, "document.querySelector('#show-controls').click()")
        self.assertEqual(browser.find("#show-controls").get_attribute("aria-expanded"), "true")
        self.assertEqual(len(self.boxes(folded)), 5 + 3 * 2)  # all but the panels
        self.show_cursors()
        browser.press("#show-panels")
        browser.wait_for("#panels .parameter")
        self.fits_a_phone("unfolded")
        for opened in ("a", "m", "x", "s", "?"):
            browser.keys(opened)
            browser.wait_for("dialog[open]")
            self.fits_a_phone(opened)
            browser.keys(Keys.ESCAPE)
        self.addCleanup(browser.run, "document.querySelector('#show-scope').click()")
        for view in "gr":
            browser.keys(view)
            self.fits_a_phone(view)
            browser.keys(view)

    def fits_a_phone(self, what: str) -> None:
        """Check that the page fits the screen, and the sizes of its controls."""
        size = "const { scrollWidth, scrollHeight } = document.documentElement;"
        shown = self.browser.run(size + "return [scrollWidth, scrollHeight]")
        self.assertEqual(shown[0], PHONE[0], what)
        self.assertLess(shown[1], 1.2 * PHONE[1], what)
        targets = self.browser.run(_TARGETS)
        self.assertGreater(len(targets), 5)
        small = [one for one in targets if min(one["width"], one["height"]) < 39.5]
        self.assertEqual(small, [], what)

    def test_graph_and_robot_views_hide_the_scope(self) -> None:
        own = "#kind, #show-panels, #foot-frames, #foot-view"
        self.assertEqual(len(self.boxes(own)), 4)
        self.addCleanup(self.browser.run, "document.querySelector('#show-scope').click()")
        for key in "gr":
            self.browser.keys(key)
            self.assertEqual(self.boxes(own), [], key)
            self.browser.keys(key)
        self.assertEqual(len(self.boxes(own)), 4)
