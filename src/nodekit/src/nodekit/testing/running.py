"""Run the tests of a file under rostest, and tell of all that fails."""

import unittest
from typing import Any, Type

import rostest
from rosunit import xmlrunner


class Result(xmlrunner._XMLTestResult):
    """What has come out; rosunit's own only counts what fails in a subTest or in setUpClass."""

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
    rostest.rosrun(package, name, case)
