"""bridge --help lists all options and parameters, even without ROS 2."""

import os
import pathlib
import subprocess
import sys

import pytest

from ros2_bridge.rules.settings import BridgeParameters

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "bridge"


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_names_each_parameter(option: str) -> None:
    nowhere = {**os.environ, "ROS2_BRIDGE_ENVIRONMENT": "/nowhere"}
    command = [sys.executable, str(SCRIPT), option]
    done = subprocess.run(command, env=nowhere, capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
    declared = BridgeParameters().declared
    assert declared
    for name in declared:
        assert f"\n  _{name} " in done.stdout
    assert "--print-pairs" in done.stdout
    assert "reaction to a goal (default: 5 s)" in " ".join(done.stdout.split())
    assert max(map(len, done.stdout.splitlines())) <= 100
