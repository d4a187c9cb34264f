"""Check the words of code and pages: no private language where the field has a word.

``python3 ci lint.language`` prints each breach and ends with status 1 if there is one. The form of
docstrings and the spelling are checked by ruff and codespell.
"""

import ast
import pathlib
import re
import sys
from typing import Iterator, Tuple

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SUFFIXES = (".bash", ".css", ".html", ".js", ".launch", ".md", ".py", ".rst", ".test", ".yaml")
#: Forbidden words, and the replacement.
WORDS = {
    r"\b(is|are|was|were|be) none\b": "write 'unset', 'missing', 'invalid' or 'not a ...'",
    r"(?i)\b(some|no|any)body\b|\bwhoever\b": "name the user, the caller, the node or the board",
    r"(?i)\banew\b": "write 'again'",
}
#: A docstring opens with a noun phrase, or an imperative.
OPENING = re.compile(r"(What|Whose|Who|Where|How)\b")
#: Only the command that checks controllers is a judge.
JUDGE = re.compile(r"(?i)judg")
#: Files about that command, and lists and pages that name it.
ABOUT_THE_JUDGE = re.compile(
    r"src/pid_control|docs/.*\.(md|yaml)$|README|ci/(endurance|lint/structure|tests/spaces)|pyproject"
    r"|docs/tests/test_console_pages|judge"
)
#: This module and its test, which quote the words.
QUOTING = ("ci/lint/language.py", "ci/tests/lint/test_language.py")


def openings(text: str) -> Iterator[Tuple[int, str]]:
    """Return line and breach of each docstring that opens with a question word.

    :param text: a Python module
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            docstring = ast.get_docstring(node) or ""
            if OPENING.match(docstring):
                line = node.body[0].lineno
                yield line, f"a docstring opens with '{docstring.split()[0]}'"


def words(text: str) -> Iterator[Tuple[int, str]]:
    """Return line and breach of each forbidden word."""
    for pattern, instead in WORDS.items():
        for found in re.finditer(pattern, text):
            line = text.count("\n", 0, found.start()) + 1
            yield line, f"'{found.group()}': {instead}"


def judges(text: str) -> Iterator[Tuple[int, str]]:
    """Return line and breach of each check that is called a judgement."""
    for number, line in enumerate(text.splitlines(), 1):
        if JUDGE.search(line) and "pid_control" not in line:
            yield number, "'judge': write 'check' or 'validate'"


def breaches() -> Iterator[str]:
    """Return a line for each breach in the project."""
    for path in sorted(WORKSPACE.glob("*")):
        for file in sorted(path.rglob("*")) if path.name in ("src", "ci", "docs") else [path]:
            place = file.relative_to(WORKSPACE).as_posix()
            is_text = file.suffix in SUFFIXES or "/scripts/" in place or file.parent.name == "ci"
            is_generated = "/_build/" in place or "__pycache__" in place
            if not (is_text and file.is_file()) or place in QUOTING or is_generated:
                continue
            text = file.read_text("utf-8")
            found = list(words(text))
            if file.suffix == ".py":
                found += openings(text)
                if file.stem == file.parent.name:
                    found.append((1, f"the module repeats its folder's name, {file.stem}"))
            if not ABOUT_THE_JUDGE.search(place):
                found += judges(text)
            yield from (f"{place}:{line}: {breach}" for line, breach in sorted(found))


if __name__ == "__main__":
    lines = list(breaches())
    print("\n".join(lines))
    sys.exit(1 if lines else 0)
