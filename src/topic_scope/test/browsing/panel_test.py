"""Base of the tests of the page's panels."""

import rospy
from browsing.page_test import PageTest
from browsing.waiting import wait_until
from selenium.webdriver.common.keys import Keys

GENERATOR = "/signal_generator"


def row(name: str) -> str:
    """Return the selector of a parameter of the signal generator."""
    return f".panel[data-node='{GENERATOR}'] .parameter[data-name='{name}']"


class PanelTest(PageTest):
    """Test with the panel of the signal generator, with about the course's signal."""

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        for name in ("amplitude", "frequency", "waveform"):
            key = f"{GENERATOR}/{name}"
            cls.addClassCleanup(rospy.set_param, key, rospy.get_param(key))

    def setUp(self) -> None:
        for name, value in (("amplitude", 2.0), ("frequency", 6.28), ("waveform", "sine")):
            rospy.set_param(f"{GENERATOR}/{name}", value)
        super().setUp()
        self.browser.wait_for(row("frequency"))
        self.wait_value("frequency", 6.28)

    def slider(self, name: str) -> float:
        """Return the position of a slider."""
        return float(self.browser.value(row(name) + " input[type=range]"))

    def wait_value(self, name: str, value: float) -> None:
        """Wait until slider and field show a value."""

        def shown() -> bool:
            typed = float(self.browser.value(row(name) + " .value"))
            return abs(typed - value) < 1e-9 and abs(self.slider(name) - value) < 0.05

        wait_until(shown, lambda: self.browser.value(row(name) + " .value"))

    def wait_parameter(self, name: str, value: object) -> None:
        """Wait until the parameter server has a value."""
        key = f"{GENERATOR}/{name}"
        wait_until(lambda: rospy.get_param(key) == value, lambda: rospy.get_param(key))

    def type_in(self, name: str, text: str) -> str:
        """Type a value and Enter; return the selector of the control."""
        control = row(name) + " .value"
        self.browser.find(control).send_keys(Keys.CONTROL, "a")
        self.browser.find(control).send_keys(text, Keys.ENTER)
        return control

    def wait_refused(self, name: str, *parts: str) -> None:
        """Wait until the error text contains some words."""
        refusal = row(name) + " .refusal"
        wait_until(
            lambda: all(part in self.browser.text(refusal) for part in parts),
            lambda: self.browser.text(row(name)),
        )
