"""Test runner for rostest that reports all failures, those of subTest and setUpClass too."""

import os
import sys
import unittest
from functools import partialmethod
from typing import Any, Callable, List, Type, TypeVar

import rostest
from rosunit import xmlrunner

from nodekit.rospy_internals.shutdown import ignore_requests_to_others

#: Environment variable that ends a run at the first failing test: later tests would often wait in
#: vain for the same condition.
FAIL_FAST = "NODEKIT_TESTS_FAIL_FAST"
#: Environment variable with the name of the only test to run.
ONLY = "NODEKIT_TESTS_ONLY"
#: Argument of a test node that runs only the tests that are marked by :func:`extended`.
EXTENDED = "--extended"

_ALL_NAMES = unittest.TestLoader.getTestCaseNames
_Test = TypeVar("_Test", bound=Callable[..., Any])


def extended(test: _Test) -> _Test:
    """Mark a test as slow, or of a rare fault: it runs only if the node has ``--extended``."""
    test.is_extended = True  # type: ignore[attr-defined]
    return test


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
    else:
        unittest.TestLoader.getTestCaseNames = partialmethod(  # type: ignore[assignment]
            names_of_tier, EXTENDED in sys.argv
        )
    ignore_requests_to_others()  # of the masters of tests that run beside this one
    rostest.rosrun(package, name, case)


def names_of_tier(
    loader: unittest.TestLoader, is_extended: bool, case: Type[unittest.TestCase]
) -> List[str]:
    """Return the names of a class's tests that :func:`extended` marks, or of the others.

    :param loader: finds all tests
    :param is_extended: whether the marked tests are returned
    :param case: test case class
    """
    names = _ALL_NAMES(loader, case)
    return [name for name in names if hasattr(getattr(case, name), "is_extended") == is_extended]
