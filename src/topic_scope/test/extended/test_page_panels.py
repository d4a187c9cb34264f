"""The page sets parameters, calls services and shows the graph, for several users at once."""

import re
import subprocess
from contextlib import contextmanager
from typing import Iterator, List

import roslib.packages
import rospy
from browsing.browser import HEIGHT, WIDTH
from browsing.panel_test import GENERATOR, PanelTest, row
from browsing.waiting import wait_until
from selenium.webdriver.common.keys import Keys
from sensor_msgs.msg import JointState
from wire.foreign import Foreign

#: All usable controls of the page.
_CONTROLS = (
    "[...document.querySelectorAll('button, input, select, a[href], summary, [tabindex=\"0\"]')]"
    ".filter((one) => one.checkVisibility() && !one.matches(':disabled'))"
)
_ROLES = (
    "button",
    "checkbox",
    "combobox",
    "textbox",
    "searchbox",
    "slider",
    "spinbutton",
    "link",
    "ColorWell",
    "DisclosureTriangle",
    "dialog",
    "table",
    "region",
    "image",
    "group",
)


class Panels(PanelTest):
    """Use of the panels beside the plot."""

    def test_a_list_and_a_switch(self) -> None:
        self.browser.choose(row("waveform") + " select", "triangle")
        self.wait_parameter("waveform", "triangle")
        switch = ".panel[data-node='/process'] [data-name='keep_positive'] input"
        self.browser.press(switch)
        wait_until(lambda: not rospy.get_param("/process/keep_positive"), lambda: "still on")
        self.browser.press(switch)
        wait_until(lambda: rospy.get_param("/process/keep_positive"), lambda: "still off")

    def test_dependent_values_are_set_together(self) -> None:
        names = ["multisine_" + part for part in ("amplitudes", "frequencies", "phases")]
        for name in names:
            key = f"{GENERATOR}/{name}"
            self.addCleanup(rospy.set_param, key, rospy.get_param(key))
            field = self.type_in(name, "[1, 2, 3]")
            if name != names[-1]:
                self.wait_refused(name, "three lists must have one length", "together with")
                self.assertEqual(self.browser.value(field), "[1, 2, 3]")
        for name in names:
            self.wait_parameter(name, [1.0, 2.0, 3.0])
            wait_until(
                lambda: (
                    self.browser.value(row(name) + " .value") == "[1.0, 2.0, 3.0]"
                    and self.browser.text(row(name) + " .refusal") == ""
                ),
                lambda: self.browser.text(row(name)),
            )

    def test_a_foreign_node_with_dynamic_reconfigure_has_a_panel(self) -> None:
        foreign = Foreign("/foreign")
        self.addCleanup(foreign.close)
        row = ".panel[data-node='/foreign'] .parameter[data-name='{}'] ".format
        self.browser.wait_for(row("gain"))
        self.assertEqual(self.browser.count(".panel[data-node='/foreign'] .parameter"), 5)
        self.browser.choose(row("mode") + "select", "fast")
        wait_until(lambda: foreign.values["mode"] == "fast", lambda: foreign.values)
        self.assertEqual(self.browser.text(row("rate") + "option"), "Low High")
        self.browser.choose(row("rate") + "select", "100")
        wait_until(lambda: foreign.values["rate"] == 100, lambda: foreign.values)
        self.assertEqual(self.browser.value(row("rate") + "select"), "100")
        gain = self.browser.find(row("gain") + ".value")
        for text, reply in (("11", "must be"), ("7", "/foreign changed it to gain = 5.0")):
            gain.send_keys(Keys.CONTROL, "a")
            gain.send_keys(text, Keys.ENTER)
            wait_until(
                lambda: reply in self.browser.text(row("gain") + ".refusal"),
                lambda: self.browser.text(row("gain")),
            )
        self.assertEqual(foreign.values["gain"], 5.0)
        rospy.set_param("/foreign/count", 8)
        wait_until(
            lambda: self.browser.value(row("count") + ".value") == "8",
            lambda: self.browser.text(row("count")),
        )

    def test_two_users_see_the_same(self) -> None:
        with self.second_page():
            self.browser.find(row("frequency") + " input[type=range]").send_keys(Keys.ARROW_LEFT)
            wanted = self.slider("frequency")
            self.wait_parameter("frequency", wanted)
            self.browser.choose("#window", "1")
            first_picture = self.browser.picture()
            wait_until(
                lambda: self.browser.picture() != first_picture,
                lambda: "the second page does not change",
            )
        self.wait_value("frequency", wanted)
        self.assertEqual(self.browser.value("#window"), "5")  # each page has its own view
        picture = self.browser.picture()
        wait_until(
            lambda: self.browser.picture() != picture, lambda: "the first page does not change"
        )

    @contextmanager
    def second_page(self) -> Iterator[None]:
        """Open the page a second time, during a ``with`` block."""
        driver = self.browser.driver
        first = driver.current_window_handle
        driver.execute_script("window.open('about:blank')")
        second = next(handle for handle in driver.window_handles if handle != first)
        driver.switch_to.window(second)
        self.browser.resize(WIDTH, HEIGHT)
        self.browser.open(self.scope.url)
        self.browser.wait_for(row("frequency"))
        yield
        self.assertEqual(self.browser.errors(), [])
        driver.close()
        driver.switch_to.window(first)

    def test_finds_a_parameter_by_a_word(self) -> None:
        self.browser.find("#filter").send_keys("peak of the signal")
        wait_until(
            lambda: not self.browser.find(row("frequency")).is_displayed(), lambda: "all shown"
        )
        self.assertTrue(self.browser.find(row("amplitude")).is_displayed())

    def test_any_field_is_found_by_topic_and_a_joint_by_its_name(self) -> None:
        publisher = rospy.Publisher("/robot/joint_states", JointState, queue_size=1, latch=True)
        self.addCleanup(publisher.unregister)
        publisher.publish(JointState(name=["left", "right"], position=[1.5, -2.5]))
        self.browser.keys("a")
        group = "#chooser-list [data-topic='/robot/joint_states']"
        self.browser.wait_for("#chooser-list [data-topic='/signal']")
        self.assertEqual(self.browser.count("#chooser-list [data-topic='/rosout']"), 0)
        field = "/robot/joint_states/position[right]"
        wait_until(
            lambda: self.browser.count(f"{group} input[aria-label='{field}']"),
            lambda: self.browser.text(group),
        )
        self.browser.press("#chooser-all")
        self.browser.wait_for("#chooser-list [data-topic='/rosout']")
        self.browser.find("#chooser-search").send_keys("robot [right] position", Keys.ENTER)
        value = f"#legend tr[data-field='{field}'] [data-cell='value']"
        wait_until(
            lambda: self.browser.text(value) == "−2.5000", lambda: self.browser.text("#legend")
        )
        self.browser.keys(Keys.DOWN, Keys.DOWN, Keys.ENTER)  # to its topic, then to the field
        wait_until(
            lambda: not self.browser.count(f"#legend tr[data-field='{field}']"),
            lambda: self.browser.text("#legend"),
        )
        self.browser.keys(Keys.ESCAPE)
        fields = [f"/many/data[{index}]" for index in range(32)]
        self.show(fields=fields)
        self.browser.keys("a")
        self.browser.find("#chooser-search").send_keys("/many/data[99]", Keys.ENTER)
        sentence = "A page shows at most 32 traces: remove one first."
        self.assertEqual(self.browser.text("#chooser-note"), sentence)
        self.assertEqual(self.browser.count("#legend tr"), 32)
        self.browser.keys(Keys.ESCAPE)

    def test_graph_follows_the_nodes_and_managed_ones_have_states(self) -> None:
        self.browser.keys("g")
        self.browser.wait_for("#graph .node[data-name='/process']")
        self.assertEqual(self.edges(), ["/process > /proc_signal", "/signal > /process"])
        rate = "#graph .edge[data-to='/process'] text"
        wait_until(
            lambda: re.match(r"(9\d(\.\d)?|10\d) Hz\Z", self.browser.text(rate)),
            lambda: self.browser.text(rate),
        )
        talker = subprocess.Popen(
            [
                roslib.packages.find_node("basic_comms", "talker.py")[0],
                "__ns:=/lab/desk",
                "_managed:=true",
            ]
        )
        try:
            self.browser.wait_for("#graph .node[data-name='/lab/desk/talker']")
            self.assertEqual(self.browser.text("#graph .group"), "/lab/desk")
            self.browser.keys("g")
            managed = ".managed-node[data-node='/lab/desk/talker'] "
            self.browser.wait_for(managed + "[aria-label='/lab/desk/talker: configure']").click()
            self.browser.wait_for(managed + "[data-state='inactive']")
            self.browser.wait_for(managed + "[aria-label='/lab/desk/talker: activate']").click()
            state = self.browser.wait_for(managed + "[data-state='active']")
            self.assertEqual(state.text, "active")
            self.browser.keys("g")
        finally:
            talker.terminate()
            talker.wait(30.0)
        wait_until(lambda: not self.browser.count("#graph .group"), lambda: "it is still shown")
        self.look_around_the_graph()
        self.browser.keys("g")
        self.assertTrue(self.browser.find("#plot").is_displayed())

    def look_around_the_graph(self) -> None:
        """Zoom, find, and plot a topic by the keyboard."""
        frame, sheet = "document.querySelector('.sheet')", "document.querySelector('#graph')"
        size = f"return [{sheet}.getBoundingClientRect().width, {frame}.clientWidth]"
        width, room = self.browser.run(size)
        self.assertLessEqual(width, room + 1)
        self.browser.press("#graph-closer")
        self.assertAlmostEqual(self.browser.run(size)[0], 1.25 * width, delta=1.0)
        self.browser.keys("0")
        self.assertAlmostEqual(self.browser.run(size)[0], width, delta=1.0)
        self.browser.keys("/", "/proc_signal")
        self.assertEqual(self.browser.value("#graph-search"), "/proc_signal")  # it keeps "/"
        wait_until(
            lambda: (
                self.browser.count("#graph .found") == 1
                and self.browser.count("#graph .topic.found[data-name='/proc_signal']") == 1
            ),
            lambda: self.browser.text("#graph-found"),
        )
        self.assertRegex(self.browser.text("#graph-found"), r"1 of \d+")
        self.browser.find("#graph-search").clear()
        self.browser.resize(390, 700)  # a phone
        wait_until(lambda: self.browser.run(size)[0] <= 391, lambda: self.browser.run(size))
        self.browser.resize(WIDTH, HEIGHT)
        topic = self.browser.find("#graph .topic[data-name='/signal']")
        topic.send_keys(Keys.ENTER)
        self.browser.wait_for("#legend tr[data-field='/signal/frequency']")
        self.assertTrue(self.browser.find("#plot").is_displayed())
        self.browser.keys("g")

    def edges(self) -> List[str]:
        """Return the edges from and to the node process."""
        found = self.browser.run(
            "return [...document.querySelectorAll('#graph .edge')]"
            ".map((edge) => edge.dataset.from + ' > ' + edge.dataset.to)"
        )
        return sorted(edge for edge in found if "/process" in edge.split(" > "))

    def test_all_controls_are_reached_by_keys_and_named(self) -> None:
        self.browser.keys("t", "c", "v", "l")  # trigger and cursors: all handles of the plot
        self.browser.wait_for(".handle.cursor")
        self.browser.wait_for(".handle.level-cursor")
        self.all_have_names("the scope")
        words = r"5.00 s until now\. /signal/signal_y: from −[12]\.\d{4} to [12]\.\d{4}, mean"
        wait_until(
            lambda: any(
                (role, name) == ("image", "plot over time") and re.match(words, text)
                for role, name, text in self.browser.accessible()
            ),
            lambda: self.browser.text("#plot-text"),
        )
        self.browser.run(
            "window.reached = new Set(); document.body.focus();"
            "document.addEventListener('focusin', (event) => window.reached.add(event.target));"
        )
        count = self.browser.run(f"return {_CONTROLS}.length")
        self.browser.keys(*[Keys.TAB] * (count + 5))
        missed = self.browser.run(
            f"return {_CONTROLS}.filter((one) => !window.reached.has(one))"
            ".map((one) => one.outerHTML.slice(0, 120))"
        )
        self.assertEqual(missed, [])
        self.assertGreater(count, 60)
        self.browser.run("document.activeElement.blur()")
        for key, dialog in (("a", "chooser"), ("x", "axes"), ("m", "measures"), ("s", "setup")):
            self.browser.keys(key)
            self.browser.wait_for(f"#{dialog}")
            self.all_have_names(dialog)
            self.browser.keys(Keys.ESCAPE)
        for opener, dialog in (
            ("#show-trigger", "trigger-more"),
            ("[aria-label^='more of /']", "trace"),
        ):
            self.browser.press(opener)
            self.browser.wait_for(f"#{dialog}")
            self.all_have_names(dialog)
            self.browser.keys(Keys.ESCAPE)
        self.browser.run("document.activeElement.blur()")
        self.browser.keys("?")
        self.browser.wait_for("#help")
        self.browser.keys(Keys.ENTER)  # its button has the focus
        wait_until(
            lambda: not self.browser.find("#help").is_displayed(), lambda: "help is still open"
        )
        for key, view in (("g", "graph"), ("r", "robots")):
            self.browser.keys(key)
            self.browser.wait_for(f"#{view}-view")
            self.all_have_names(view)
        names = [name for _, name, _ in self.browser.accessible()]
        self.assertIn("take the wheel", " ".join(names).lower())

    def test_a_key_right_after_a_dialog_is_not_lost(self) -> None:
        self.browser.keys("a")
        self.browser.wait_for("#chooser-search:focus")
        # Within one script, no frame is drawn: the closed dialog's field still has the focus.
        had_focus = self.browser.run(
            "document.getElementById('chooser').close();"
            "const focused = document.activeElement;"
            "focused.dispatchEvent(new KeyboardEvent('keydown', {key: 'x', bubbles: true}));"
            "return focused.id"
        )
        self.assertEqual(had_focus, "chooser-search")
        self.browser.wait_for("#axes")

    def all_have_names(self, what: str) -> None:
        """Check that all controls have names."""
        nameless = [row for row in self.browser.accessible() if row[0] in _ROLES and not row[1]]
        self.assertEqual(nameless, [], what)

    def test_read_only_page_has_no_controls(self) -> None:
        self.addCleanup(self.leave_page)
        # As from a scope that is open to the network, which a test must not be.
        script = self.browser.driver.execute_cdp_cmd(
            "Page.addScriptToEvaluateOnNewDocument",
            {
                "source": "const parse = JSON.parse; JSON.parse = (text) => {"
                " const read = parse(text);"
                " if (read.type === 'hello') read.readonly = true; return read; };"
            },
        )
        try:
            self.browser.open(self.scope.url)
            self.browser.wait_for(row("amplitude"))
            self.assertTrue(self.browser.find("#readonly").is_displayed())
            self.assertEqual(self.browser.text(row("amplitude") + " output"), "2")
            self.assertEqual(self.browser.count(".panel input, .panel select, .panel button"), 0)
        finally:
            self.browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
