"""Nobody outside nodekit reaches past its public surface, in whatever form a module is named."""

import ast
import pathlib
import re
from typing import Collection, Iterator, List, Tuple

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
NODEKIT = WORKSPACE / "src" / "nodekit"
#: What is public beside the names of the front door; docs/api.md describes each.
PUBLIC = (
    "nodekit.entry_point",
    "nodekit.lifecycle_states",
    "nodekit.master",
    "nodekit.message_definitions",
    "nodekit.testing",
)
#: nodekit itself, and what has lists of its rooms and tests that they are held.
INSIDE = (
    "src/nodekit/scripts",
    "src/nodekit/src",
    "src/nodekit/test",
    "ci/lint",
    "ci/mutation",
    "ci/tests/lint",
    "ci/tests/mutation",
)
#: Texts with lines of Python, or with commands.
TEXTS = {".md", ".rst", ".bash", ".launch", ".test"}
#: A text that is the name of a module, as for ``importlib`` or behind ``-m``.
_NAME = re.compile(r"nodekit(\.\w+)+")
_LINE = re.compile(r"^\s*(?:from|import) (nodekit(?:\.\w+)+)|-m[ \"',\[]+(nodekit(?:\.\w+)+)")


def offered() -> List[str]:
    """Return the names that the front door offers, without importing it."""
    tree = ast.parse((NODEKIT / "src" / "nodekit" / "__init__.py").read_text("utf-8"))
    (homes,) = [
        node.value
        for node in tree.body
        if isinstance(node, ast.AnnAssign) and getattr(node.target, "id", "") == "_HOMES"
    ]
    return list(ast.literal_eval(homes))  # type: ignore[arg-type]


def named(tree: ast.AST) -> Iterator[Tuple[int, str]]:
    """Return line and full name of all of nodekit that a module names."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom) and not node.level:
            for alias in node.names:
                yield node.lineno, f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if _NAME.fullmatch(node.value):
                yield node.lineno, node.value
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            yield node.lineno, f"{node.value.id}.{node.attr}"


def named_in_text(text: str) -> Iterator[Tuple[int, str]]:
    """Return line and full name of all of nodekit that examples in a text import or run."""
    for number, line in enumerate(text.splitlines(), 1):
        for match in _LINE.finditer(line):
            yield number, match.group(1) or match.group(2)


def is_public(name: str, names: Collection[str]) -> bool:
    """Tell whether anybody may use something.

    :param name: its full name
    :param names: those of the front door
    """
    package, _, rest = name.partition(".")
    first = rest.partition(".")[0]
    if package != "nodekit" or not rest or first in names or first.startswith("__"):
        return True
    return any((name + ".").startswith(public + ".") for public in PUBLIC)


def breaches() -> Iterator[str]:
    """Return a line for each place outside nodekit that reaches past its public surface."""
    names = offered()
    for folder in ("src", "ci", "docs"):
        for path in sorted((WORKSPACE / folder).rglob("*")):
            place = path.relative_to(WORKSPACE).as_posix()
            if path.is_dir() or any(place.startswith(inside + "/") for inside in INSIDE):
                continue
            if path.suffix == ".py" or (not path.suffix and _is_python(path)):
                found = named(ast.parse(path.read_text("utf-8"), str(path)))
            elif path.suffix in TEXTS and path.name != "CHANGELOG.rst":
                found = named_in_text(path.read_text("utf-8"))
            else:
                continue
            for line, name in found:
                if not is_public(name, names):
                    yield f"{place}:{line}: {name} is not public: see docs/api.md"


def _is_python(path: pathlib.Path) -> bool:
    with path.open("rb") as file:
        first = file.readline(80)
    return first.startswith(b"#!") and b"python" in first
