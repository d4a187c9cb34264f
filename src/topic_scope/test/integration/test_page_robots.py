"""Robots on the page: view, goals and driving."""

import math

import genpy.dynamic
import rospy
from browsing.page_test import PageTest
from browsing.waiting import wait_until
from geometry_msgs.msg import Point
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from visualization_msgs.msg import Marker, MarkerArray
from wire.robot import Robot

from nodekit.testing.running import extended

STATUS = "string robot_name\nuint8 mode\nfloat32[] sensor_readings\n"
CANVAS = "#robot-canvas"


class PageRobots(PageTest):
    """Use of the page to drive a robot."""

    def wait_text(self, selector: str, text: str) -> None:
        """Wait until an element has a text."""
        wait_until(lambda: text in self.browser.text(selector), lambda: self.browser.text(selector))

    def changed(self, picture: int) -> int:
        """Wait until the picture changes."""
        wait_until(lambda: self.browser.picture(CANVAS) != picture, lambda: "the same picture")
        return self.browser.picture(CANVAS)

    @extended
    def test_robot_is_shown_sent_to_a_goal_and_driven(self) -> None:
        browser, robot = self.browser, Robot("/")
        self.addCleanup(robot.close)
        world = rospy.Publisher("/world", MarkerArray, queue_size=1, latch=True)
        browser.keys("r")
        self.wait_text("#robot-list", "odom: 0.00, 0.00 m, 0°, 0 m/s")
        browser.wait_for("#drive-topic option[value='/cmd_vel']")
        picture = browser.picture(CANVAS)
        walls = [Point(*place) for place in ((-2, -1, 0), (-2, 1, 0), (2, -1, 0), (2, 1, 0))]
        world.publish(MarkerArray([Marker(type=Marker.LINE_LIST, points=walls)]))
        picture = self.changed(picture)

        # A click on the picture; the page shows its position.
        browser.find("#goal-pick").click()
        canvas = browser.find("#robot-canvas")
        steps = ActionChains(browser.driver).move_to_element(canvas).move_by_offset(100, -50)
        steps.click_and_hold().move_by_offset(0, -40).release().perform()
        (goal,) = wait_until(lambda: robot.goals[:], lambda: browser.text("#notice"))
        self.wait_text("#goal-state", "Sent on /goal")
        place = goal.pose.position
        self.assertGreater(place.x, 0.1)
        self.assertAlmostEqual(place.y, place.x / 2.0, delta=0.02)  # y is up, one scale for both
        self.assertAlmostEqual(goal.pose.orientation.z, 0.7071, delta=1e-3)
        self.assertEqual(browser.find("#goal-pick").get_attribute("aria-pressed"), "false")
        self.assertAlmostEqual(float(browser.value("#goal-heading")), 90.0, delta=0.2)
        picture = self.changed(picture)

        # By numbers, the heading in degrees.
        for name, text in (("x", "1.5"), ("y", "-0.5"), ("heading", "-120")):
            field = browser.find(f"#goal-{name}")
            field.clear()
            field.send_keys(text)
        browser.find("#goal-send").click()
        goal = wait_until(lambda: robot.goals[1:], lambda: browser.text("#goal-state"))[0]
        self.assertEqual((goal.pose.position.x, goal.pose.position.y), (1.5, -0.5))
        turn = goal.pose.orientation
        self.assertAlmostEqual(2.0 * math.atan2(turn.z, turn.w), math.radians(-120.0))
        browser.find("#robot-canvas").click()  # takes the focus from the field
        picture = self.changed(picture)

        # Keys move the picture, or, with the wheel, the robot while they are held.
        browser.keys(Keys.ARROW_UP)
        picture = self.changed(picture)
        self.assertEqual(robot.commands, [])
        browser.find("#drive").click()
        self.wait_text("#drive-state", "Driving on /cmd_vel, Twist")
        ActionChains(browser.driver).key_down(Keys.ARROW_UP).key_down("a").perform()
        wait_until(lambda: robot.x > 0.1 and robot.heading > 0.1, lambda: str(robot.commands))
        # A zero, too, if the dead man's switch opened on a busy machine.
        self.assertLessEqual({command.speed for command in robot.commands}, {0.0, 0.2})
        wait_until(lambda: robot.commands[-1].turn == 1.0, lambda: str(robot.commands[-3:]))
        ActionChains(browser.driver).key_up("a").key_up(Keys.ARROW_UP).perform()
        wait_until(lambda: robot.commands[-1][1:] == (0.0, 0.0), lambda: str(robot.commands[-1]))
        count = len(robot.commands)
        self.changed(picture)

        # The same with a button; leaving the view ends driving.
        button = browser.find("#drive-pad [aria-label='back']")
        ActionChains(browser.driver).click_and_hold(button).perform()
        wait_until(lambda: robot.commands[-1].speed == -0.2, lambda: str(robot.commands[-1]))
        self.assertLessEqual({one.speed for one in robot.commands[count:]}, {0.0, -0.2})
        browser.run("window.dispatchEvent(new Event('blur'))")
        wait_until(lambda: robot.commands[-1].speed == 0.0, lambda: str(robot.commands[-1]))
        ActionChains(browser.driver).release().perform()
        stick = browser.find("#joystick")
        ActionChains(browser.driver).move_to_element(stick).click_and_hold().move_by_offset(
            30, 0
        ).perform()
        wait_until(lambda: -0.6 < robot.commands[-1].turn < -0.4, lambda: str(robot.commands[-1]))
        ActionChains(browser.driver).release().perform()
        wait_until(lambda: robot.commands[-1].turn == 0.0, lambda: str(robot.commands[-1]))
        browser.keys(Keys.ESCAPE)
        self.wait_text("#drive", "Take the wheel")
        # A followed robot is in the middle of the picture; moving the picture ends following.
        browser.keys("f")
        row = "#robot-list button[aria-pressed='true'][data-topic='/odom']"
        browser.wait_for(row)

        def middle() -> bool:
            ActionChains(browser.driver).move_to_element_with_offset(canvas, 1, 1).perform()
            ActionChains(browser.driver).move_to_element(canvas).perform()
            reply = browser.text("#robot-pointer").replace("−", "-").replace(" m", "").split(", ")
            return math.dist(list(map(float, reply)), (robot.x, robot.y)) < 0.05

        wait_until(middle, lambda: (browser.text("#robot-pointer"), robot.x, robot.y))
        browser.keys(Keys.ARROW_LEFT)
        wait_until(lambda: not browser.count(row), lambda: browser.text("#robot-list"))
        self.assertFalse(middle())
        self.fleet_has_tiles()
        self.assertIn("robots", str(browser.run("return location.hash")))
        browser.keys("r")

    def fleet_has_tiles(self) -> None:
        """Publish the status of a robot in a type that is not installed, and then stop."""
        status_class = genpy.dynamic.generate_dynamic("not_here/RobotStatus", STATUS)
        status = rospy.Publisher(
            "/al/status", status_class["not_here/RobotStatus"], queue_size=1, latch=True
        )
        self.addCleanup(status.unregister)
        status.publish("al", 1, [12.5, 21.0])
        tile = "#fleet .tile[data-topic='/al/status']"
        self.wait_text(tile, "no data for")
        self.assertEqual(self.browser.text(f"{tile} h3"), "al")
        self.assertEqual(self.browser.text(f"{tile} .mode"), "moving")
        self.assertEqual(self.browser.text(f"{tile} dd"), "12.50 V 21.00 °C")
        status.publish("al", 4, [11.0, 21.0])
        self.wait_text(f"{tile}[data-mode='error'] dd", "11.00 V")
