"""Tests that mypy rejects features newer than Python 3.8."""

import pathlib
import subprocess
import sys
from typing import List

import pytest

WORKSPACE = pathlib.Path(__file__).resolve().parents[3]

NEWER = {
    "a method of str": 'def f() -> str:\n    return "a_b".removeprefix("a_")\n',
    "an operator of dict": "def f(a: dict, b: dict) -> object:\n    return a | b\n",
    "a function": "import math\n\nBOTH = math.lcm(2, 3)\n",
    "a decorator": "import functools\n\n\n@functools.cache\ndef f() -> int:\n    return 1\n",
    "a type with brackets": "NAMES = list[int]\n",
    "a statement": "def f(a: int) -> None:\n    match a:\n        case 1:\n            pass\n",
    "brackets of with": "with (open('a') as a, open('b') as b):\n    pass\n",
}


def check(tmp_path: pathlib.Path, text: str) -> List[str]:
    """Return mypy's errors for a module, with the settings of the project."""
    module = tmp_path / "module.py"
    module.write_text(text)
    command = [sys.executable, "-m", "mypy", "--config-file", str(WORKSPACE / "pyproject.toml")]
    command += ["--cache-dir", str(tmp_path.parent / "cache"), str(module)]
    done = subprocess.run(command, stdout=subprocess.PIPE, encoding="utf-8", timeout=300)
    lines = done.stdout.splitlines()
    assert (done.returncode == 0) == (lines[-1].startswith("Success"))
    return lines[:-1]


@pytest.mark.parametrize("what", sorted(NEWER))
def test_newer_python_is_refused(tmp_path: pathlib.Path, what: str) -> None:
    assert check(tmp_path, NEWER[what])


def test_features_of_its_python_are_accepted(tmp_path: pathlib.Path) -> None:
    assert check(tmp_path, "import math\n\nif (whole := math.prod([2, 3])) > 5:\n    pass\n") == []
