"""The case that the tests of the page share: one browser and one scope for all of its tests."""

import unittest
from typing import List

from browsing.browser import Browser
from browsing.scope_process import ScopeProcess

SIGNAL, PROCESSED = "/signal/signal_y", "/proc_signal/data"


class PageTest(unittest.TestCase):
    """Shows the two signals of the course, and checks after each test that nothing was wrong."""

    browser: Browser
    scope: ScopeProcess
    #: Complaints of the browser that a test provokes.
    expected_errors: List[str]

    @classmethod
    def setUpClass(cls) -> None:
        cls.scope = ScopeProcess(SIGNAL, PROCESSED, "--window", "5")
        cls.addClassCleanup(cls.scope.stop)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)
        cls.scope.wait_until_served()

    def setUp(self) -> None:
        self.expected_errors = []
        self.browser.open(self.scope.url)
        self.browser.wait_for(f"#legend tr[data-field='{PROCESSED}']")

    def tearDown(self) -> None:
        errors = [
            error
            for error in self.browser.errors()
            if not any(expected in error for expected in self.expected_errors)
        ]
        self.assertEqual(errors, [])
