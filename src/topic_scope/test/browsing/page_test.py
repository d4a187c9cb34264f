"""What the tests of the page share: one browser and one scope for all tests of a case."""

import unittest
from typing import ClassVar, List, Sequence

from browsing.browser import Browser
from browsing.scope_process import ScopeProcess

SIGNAL, PROCESSED = "/signal/signal_y", "/proc_signal/data"


class BrowserTest(unittest.TestCase):
    """Has a scope and a browser, which shows nothing yet."""

    #: What the scope's command line says besides the port.
    ARGUMENTS: ClassVar[Sequence[str]] = ()
    browser: Browser
    scope: ScopeProcess

    @classmethod
    def setUpClass(cls) -> None:
        cls.scope = ScopeProcess(*cls.ARGUMENTS)
        cls.addClassCleanup(cls.scope.stop)
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)
        cls.scope.wait_until_served()


class PageTest(BrowserTest):
    """Shows the two signals of the course, and checks after each test that nothing was wrong."""

    ARGUMENTS = (SIGNAL, PROCESSED, "--window", "5")
    #: Complaints of the browser that a test provokes.
    expected_errors: List[str]

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
