"""Test runner for rostest that reports all failures, those of subTest and setUpClass too."""

import os
import unittest
from typing import Any, Type

import rostest
from rosunit import xmlrunner

#: Environment variable that ends a run at the first failing test: later tests would often wait in
#: vain for the same condition.
FAIL_FAST = "NODEKIT_TESTS_FAIL_FAST"
#: Environment variable with the name of the only test to run.
ONLY = "NODEKIT_TESTS_ONLY"


class Result(xmlrunner._XMLTestResult):
    """Result with the errors of subTest and setUpClass, which rosunit's own only counts."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.failfast = bool(os.environ.get(FAIL_FAST))

    def addSubTest(self, test: unittest.TestCase, subtest: Any, error: Any) -> None:
        super().addSubTest(test, subtest, error)
        if error is not None:
            self._error = error  # of the whole test, reported when it stops

    def addError(self, test: Any, error: Any) -> None:
        super().addError(test, error)
        if not isinstance(test, unittest.TestCase):  # an error of setUpClass
            self._tests.append(xmlrunner._TestInfo.create_error(test, 0.0, error))


def rosrun(package: str, name: str, case: Type[unittest.TestCase]) -> None:
    """Run a test case as ``rostest.rosrun`` does, with the reason of each failure in the results.

    :param package: name of the package
    :param name: name of the test, as in the launch file
    :param case: test case class
    :raises SystemExit: with status 1 if a test fails
    """
    xmlrunner._XMLTestResult = Result
    if os.environ.get(ONLY):
        unittest.TestLoader.testNamePatterns = [f"*.{os.environ[ONLY]}"]
    rostest.rosrun(package, name, case)
