"""Console blocks of a documentation page, compared with output; deprecated, kept in 1.x.

Fenced blocks of the language ``console`` are read: a line ``$ command`` is typed, the lines after
it are what it prints. In those, ``...`` stands for any text, and alone on a line for any lines.
A block with the caption ``Terminal N`` is about a command that keeps running there, and ``^C`` in
it ends that; any other block is about commands that end by themselves.
"""

import re
import warnings
from typing import List, NamedTuple, Optional, Sequence

warnings.warn("nodekit.testing.console: deprecated module; copy it", DeprecationWarning, 2)

_FENCE = re.compile(r"^```\s*(?:\{code-block\}\s*)?(\w*)\s*$")
_TERMINAL = re.compile(r"^:caption: *(Terminal .*?)\s*$")
_ESCAPES = re.compile(r"\x1b\[[0-9;]*[A-Za-z]|\x1b\][^\x07]*\x07|\r")
ANYTHING = "..."
INTERRUPT = "^C"


class Instruction(NamedTuple):
    """Command that a reader types, and the output to expect.

    :param line: line of the page
    :param typed: a command, INTERRUPT, or None to go on watching a terminal
    :param terminal: name of the terminal for what keeps running, None for the rest
    :param expected: lines to be seen
    """

    line: int
    typed: Optional[str]
    terminal: Optional[str]
    expected: List[str]


def instructions_of(page: str) -> List[Instruction]:
    """List the instructions on a page.

    :param page: the text of the page, Markdown
    """
    instructions: List[Instruction] = []
    language: Optional[str] = None
    for number, line in enumerate(page.splitlines(), 1):
        fence = _FENCE.match(line)
        if fence or line.startswith("```"):
            language = (fence.group(1) if fence else "other") if language is None else None
            terminal, fresh = None, True
        elif language == "console":
            caption = _TERMINAL.match(line)
            if caption:
                terminal = caption.group(1)
            elif line.startswith("$ ") or line == INTERRUPT:
                typed = line if line == INTERRUPT else line[2:].strip()
                instructions.append(Instruction(number, typed, terminal, []))
                fresh = False
            elif fresh and line.strip():
                instructions.append(Instruction(number, None, terminal, [line.rstrip()]))
                fresh = False
            elif not fresh:
                instructions[-1].expected.append(line.rstrip())
    return [
        instruction._replace(expected=_without_blank_end(instruction.expected))
        for instruction in instructions
    ]


def plain(output: str) -> str:
    """Return output without the escape codes of terminals."""
    return _ESCAPES.sub("", output)


def is_all(expected: Sequence[str], output: str) -> bool:
    """Return whether the whole output is as expected, from the first line to the last."""
    parts = [r"(?:.*\n)*?" if line == ANYTHING else _pattern(line) + r"\s*\n" for line in expected]
    text = output.rstrip("\n") + "\n" if output.strip() else ""
    return re.fullmatch("".join(parts), text) is not None


def find(expected: Sequence[str], output: str, start: int = 0) -> Optional[int]:
    """Find lines in output, in their order and with any others in between.

    :param expected: the lines
    :param output: what to search
    :param start: index in ``output`` to begin at
    :returns: index behind the last line, None where some are not there
    """
    for line in expected:
        if line == ANYTHING or not line.strip():
            continue
        found = re.compile(f"^{_pattern(line)}[ \t]*$", re.MULTILINE).search(output, start)
        if not found:
            return None
        start = found.end()
    return start


def _pattern(line: str) -> str:
    return ".*?".join(re.escape(part) for part in line.split(ANYTHING))


def _without_blank_end(lines: List[str]) -> List[str]:
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    return lines
