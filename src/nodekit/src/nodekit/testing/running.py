"""Run the tests of a file under rostest, and tell of all that fails."""

import os
import unittest
from typing import Any, Type

import rostest
from rosunit import xmlrunner


#: Where this variable of the environment is set, a run ends with the first test that fails, as
#: where it is enough to know that one does: what follows would often wait for the same in vain.
FAIL_FAST = "NODEKIT_TESTS_FAIL_FAST"
#: The name of the only tests to run, where this variable is set.
ONLY = "NODEKIT_TESTS_ONLY"


class Result(xmlrunner._XMLTestResult):
    """What has come out; rosunit's own only counts what fails in a subTest or in setUpClass."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.failfast = bool(os.environ.get(FAIL_FAST))

    def addSubTest(self, test: unittest.TestCase, subtest: Any, error: Any) -> None:
        super().addSubTest(test, subtest, error)
        if error is not None:
            self._error = error  # the whole test's, which is told when it stops

    def addError(self, test: Any, error: Any) -> None:
        super().addError(test, error)
        if not isinstance(test, unittest.TestCase):  # nothing that starts and stops
            self._tests.append(xmlrunner._TestInfo.create_error(test, 0.0, error))


def rosrun(package: str, name: str, case: Type[unittest.TestCase]) -> None:
    """Run a test case as ``rostest.rosrun`` does; the results tell why, wherever it failed.

    :param package: name of the package
    :param name: name of the test, as in the launch file
    :param case: the class of the tests
    :raises SystemExit: with status 1 when a test fails
    """
    xmlrunner._XMLTestResult = Result
    if os.environ.get(ONLY):
        unittest.TestLoader.testNamePatterns = [f"*.{os.environ[ONLY]}"]
    rostest.rosrun(package, name, case)
