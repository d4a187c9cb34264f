"""Tests of the parameter ~managed: allowed values, and cost if false."""

import subprocess
import sys
from typing import Any

import pytest

from nodekit.parameters.parameter_types import MISSING, ParameterError
from nodekit.process.run import selected_class


class Plain:
    """A class of a node."""

    def __init__(self, node: object) -> None:
        pass


@pytest.mark.parametrize("held", [MISSING, {}, {"rate": 5.0}, {"managed": False}, "a scalar", 1])
def test_class_stays_itself(held: Any) -> None:
    assert selected_class(Plain, "/lab/node", held) is Plain


@pytest.mark.parametrize("value", ["true", 1, 0, None, [True], {}])
def test_no_truth_value_is_refused(value: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        selected_class(Plain, "/lab/node", {"managed": value})
    text = str(caught.value)
    assert text.startswith("parameter /lab/node/managed: refused ")
    assert text.endswith(": must be true or false")


def test_lifecycle_modules_are_imported_only_if_needed() -> None:
    program = """
import sys
from nodekit.process.run import selected_class
found = lambda: [name for name in sys.modules if "lifecycle" in name]
selected_class(int, "/node", {"managed": False})
assert not found(), found()
assert selected_class(int, "/node", {"managed": True}) is not int
assert found()
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_transport_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ParameterError, match="/lab/node/transport: refused 'udp'.*auto, tcp"):
        selected_class(Plain, "/lab/node", {"transport": "udp"})
