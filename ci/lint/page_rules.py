"""Check the imports between the scripts of the oscilloscope's page.

``python3 ci lint.page_rules`` prints each breach and ends with status 1 if there is one.
"""

import os
import pathlib
import re
import sys
from typing import Dict, Iterator, List, Set, Tuple

from .code_rules import LONGEST, cycles
from .structure import PAGE

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "src" / "topic_scope" / "www" / "js"

ROOMS = list(PAGE)
#: Besides the folders: scripts that assemble the page and may import all, and non-modules.
ENTRY = "main.js"
NO_MODULES = ("start.js",)

_COMMENT = re.compile(r"/\*.*?\*/|^\s*//.*?$", re.DOTALL | re.MULTILINE)
_IMPORT = re.compile(
    r"""^\s*(?:import|export)\b(?P<names>[^;"']*)\bfrom\s*["'](?P<of>[^"']+)["']"""
    r"""|^\s*import\s*["'](?P<bare>[^"']+)["']"""
    r"""|\bimport\(\s*["'](?P<later>[^"']+)["']\s*\)""",
    re.MULTILINE,
)
_TYPE = re.compile(r"""\bimport\(["']([^"']+)["']\)""")


def without_comments(text: str) -> str:
    """Return a script with its comments blanked, so that each line keeps its number."""
    return _COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)


def imports(text: str) -> Iterator[Tuple[int, str, List[str]]]:
    """Return line, address and names of all imports of a script.

    :param text: the script without its comments
    """
    for found in _IMPORT.finditer(text):
        line = text.count("\n", 0, found.end() - 1) + 1
        names = re.findall(r"[\w$]+", re.sub(r"\S+ as ", "", found["names"] or ""))
        yield line, found["of"] or found["bare"] or found["later"], names


def breaches(texts: Dict[str, str]) -> Iterator[str]:
    """Return a message for each forbidden import, and each misplaced script.

    :param texts: content of each script, by its path below the folder of the scripts
    """
    graph: Dict[str, Set[str]] = {}
    for module, whole in sorted(texts.items()):
        room, text = os.path.dirname(module), without_comments(whole)
        if room not in ROOMS and module not in (ENTRY, *NO_MODULES):
            yield f"{module}: it is in no room"
        if len(whole.splitlines()) > LONGEST:
            yield f"{module}: longer than {LONGEST} lines"
        graph[module] = set()
        for line, address, names in imports(text):
            target = os.path.normpath(os.path.join(room, address))
            graph[module].add(target)
            if target not in texts or target in NO_MODULES:
                yield f"{module}:{line}: there is no module {address}"
            elif room in ROOMS and os.path.dirname(target) not in ROOMS[: ROOMS.index(room) + 1]:
                yield f"{module}:{line}: {room} may not import {target}"
            for name in names:
                if len(re.findall(rf"(?<![\w$]){re.escape(name)}(?![\w$])", text)) < 2:
                    yield f"{module}:{line}: {name} is imported and not used"
        for address in _TYPE.findall(whole):
            if os.path.normpath(os.path.join(room, address)) not in texts:
                yield f"{module}: a comment names {address}, which does not exist"
    yield from cycles(graph)


def scripts() -> Dict[str, str]:
    """Return the content of each script, by its path below their folder."""
    paths = SCRIPTS.rglob("*.js")
    return {path.relative_to(SCRIPTS).as_posix(): path.read_text("utf-8") for path in paths}


if __name__ == "__main__":
    sys.exit("\n".join(breaches(scripts())) or 0)
