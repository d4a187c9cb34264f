"""Tests that mypy rejects features newer than Python 3.8."""

import pathlib
import subprocess
import sys
from typing import Dict, Set

import pytest

WORKSPACE = pathlib.Path(__file__).resolve().parents[3]

NEWER = {
    "a_method_of_str": 'def f() -> str:\n    return "a_b".removeprefix("a_")\n',
    "an_operator_of_dict": "def f(a: dict, b: dict) -> object:\n    return a | b\n",
    "a_function": "import math\n\nBOTH = math.lcm(2, 3)\n",
    "a_decorator": "import functools\n\n\n@functools.cache\ndef f() -> int:\n    return 1\n",
    "a_type_with_brackets": "NAMES = list[int]\n",
}
FINE = "import math\n\nif (whole := math.prod([2, 3])) > 5:\n    pass\n"
#: After such an error mypy looks at no other module.
SYNTAX = {
    "a_statement": "def f(a: int) -> None:\n    match a:\n        case 1:\n            pass\n",
    "brackets_of_with": "with (open('a') as a, open('b') as b):\n    pass\n",
}


def refused(folder: pathlib.Path, texts: Dict[str, str]) -> Set[str]:
    """Return the names of modules with errors by mypy, with the settings of the project."""
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(text)
    command = [sys.executable, "-m", "mypy", "--config-file", str(WORKSPACE / "pyproject.toml")]
    command += ["--cache-dir", str(folder / "cache"), *(f"{name}.py" for name in texts)]
    done = subprocess.run(
        command, cwd=str(folder), stdout=subprocess.PIPE, encoding="utf-8", timeout=300
    )
    assert done.returncode
    return {line.partition(".py:")[0] for line in done.stdout.splitlines() if ": error: " in line}


def test_only_features_of_newer_python_are_refused(tmp_path: pathlib.Path) -> None:
    assert refused(tmp_path, {**NEWER, "fine": FINE}) == set(NEWER)


@pytest.mark.parametrize("what", sorted(SYNTAX))
def test_newer_syntax_is_refused(tmp_path: pathlib.Path, what: str) -> None:
    assert refused(tmp_path, {what: SYNTAX[what]}) == {what}
