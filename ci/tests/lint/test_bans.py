"""Tests of ruff's bans on calls that could execute input as code or commands."""

import subprocess

import pytest

from ci.lint.code_rules import SOURCES
from ci.tiers.tier_plan import RUFF

LIBRARY = "src/basic_comms/src/basic_comms/nodes/x.py"


def refused(place: str, text: str) -> bool:
    """Return whether ruff rejects a file."""
    command = [RUFF, "check", "--quiet", "--stdin-filename", place, "-"]
    done = subprocess.run(command, input=text.encode(), cwd=str(SOURCES.parent), timeout=60)
    return done.returncode == 1


@pytest.mark.parametrize(
    "text",
    [
        "eval('1')\n",
        "exec('1')\n",
        "import os\n\nos.system('true')\n",
        "from os import popen as run\n\nrun('true')\n",
        "import subprocess\n\nsubprocess.run(['true'])\n",
        "import yaml\n\nyaml.unsafe_load('1')\n",
        "import rosparam\n\nrosparam.main()\n",
        "import zoneinfo\n\nzoneinfo.ZoneInfo('UTC')\n",
        "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n    pass\n",
    ],
)
def test_banned_code_is_refused(text: str) -> None:
    assert refused(LIBRARY, text)
    assert refused("src/basic_comms/scripts/x.py", text)
    assert not refused("src/basic_comms/test/unit/x.py", text)
    assert not refused("ci/tests/x.py", text)


def test_module_that_starts_processes_may_do_nothing_else() -> None:
    place = "src/pid_control/src/pid_control/programs/program_command.py"
    assert not refused(place, "import subprocess\n\nsubprocess.run(['true'])\n")
    assert refused(place, "eval('1')\n")


def test_any_other_call_is_not_refused() -> None:
    assert not refused(LIBRARY, "import re\nimport yaml\n\nre.compile('1')\nyaml.safe_load('1')\n")
