"""Judge controllers with known flaws, and correct ones drawn at random."""

import contextlib
import csv
import os
import pathlib
import subprocess
import sys
import time
from typing import List

from ..benchmark.peer_programs import WORKSPACE
from .checks import Check, at_least, at_most, none_of
from .context import Soak

PACKAGE = WORKSPACE / "src" / "pid_control"
CONTROLLERS = PACKAGE / "test" / "controllers"
#: Expected first flaw by controller, if it is not the controller's name.
FLAWS = {
    "crash_at_start": "crash",
    "mute": "silent",
    "time_sleep": "machine clock",
    "time_time": "machine clock",
    "wrong_dt": "interval",
}
#: Longest time of a judgement [s].
LONGEST_S = 60.0
#: Correct controllers drawn at random, a quarter of the variable UNIT_TEST_EXAMPLES.
DRAWN = 200


def run(soak: Soak) -> List[Check]:
    """Judge all of them, one after the other."""
    directory = soak.session.directory
    table = directory / "judged.csv"
    flawed = sorted(CONTROLLERS.glob("flaw_*.py"))
    good = [*sorted(CONTROLLERS.glob("good_*.py")), PACKAGE / "scripts" / "controller.py"]
    missed, blamed, took = [], [], []
    for file in [*flawed, *good]:
        began = time.monotonic()
        with (directory / "judge.log").open("ab") as log:
            subprocess.run(
                [str(PACKAGE / "scripts" / "judge"), "--csv", str(table), str(file)],
                env={**os.environ, "TMPDIR": str(directory)},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                timeout=5.0 * LONGEST_S,
            )
        took.append(time.monotonic() - began)
        with table.open() as opened:
            (row,) = csv.DictReader(opened)
        table.unlink()
        if file in good and row["verdict"] != "passed":
            blamed.append(f"{file.stem}: {row['verdict']}: {row['why']}")
        name = file.stem[len("flaw_") :]
        expected = FLAWS.get(name, name.replace("_", " "))
        if file in flawed and row["flaws"].split(", ")[0] != expected:
            missed.append(f"{file.stem}: {row['flaws'] or row['verdict']}, not {expected}")
    return [
        at_least("controllers judged", len(took), 24),
        none_of("flaws that are not named", missed),
        none_of("good controllers that do not pass", blamed),
        none_of(f"false causes of {DRAWN} controllers drawn at random", false_causes()),
        at_most("longest judgement", max(took), LONGEST_S, "s"),
        none_of("processes left behind", left_behind(directory)),
    ]


def false_causes() -> List[str]:
    """Return what fails in the unit test of correct controllers, with more of them."""
    test = PACKAGE / "test" / "unit" / "test_diagnosis.py"
    name = "test_judge_correct_controllers_get_no_false_cause"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"{test}::{name}"],
        cwd=str(WORKSPACE),
        env={**os.environ, "UNIT_TEST_EXAMPLES": str(4 * DRAWN)},
        stdout=subprocess.PIPE,
        universal_newlines=True,
    )
    return [] if done.returncode == 0 else done.stdout.splitlines()[-20:]


def left_behind(directory: pathlib.Path) -> List[str]:
    """Return the processes that the judge has started and that still run."""
    found = []
    for environ in pathlib.Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if f"TMPDIR={directory}".encode() in environ.read_bytes().split(b"\0"):
                found.append(environ.parent.name)
    return found
