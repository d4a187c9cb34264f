"""Mutants of modules and of the page's scripts, and a random draw of them."""

import collections
import hashlib
import json
import os
import pathlib
import subprocess
from typing import Any, Counter, List, NamedTuple, Sequence, Tuple

from ..lint import code_rules
from . import javascript

SOURCES = code_rules.SOURCES
#: Test helpers, which the tests of all packages test.
FOR_TESTS = ("nodekit.testing",)


class Unfit(Exception):
    """Error if there is nothing to measure; the text is the reason."""


class Mutant(NamedTuple):
    """A module with one change."""

    #: Its path below src.
    module: str
    kind: str
    #: Identifies the mutant in each run, independent of other lines.
    key: str
    text: str
    line: int
    #: The lines that differ, as ```old` → `new```.
    change: str

    def __str__(self) -> str:
        return f"src/{self.module}:{self.line}: {self.kind}: {self.change}"


def change_of(original: str, mutated: str) -> Tuple[int, str]:
    """Return the number of the first different line of two texts, and the different lines."""
    old, new = original.splitlines(), mutated.splitlines()
    first = [*(a == b for a, b in zip(old, new)), False].index(False)
    old, new = old[first:], new[first:]
    end = [*(a == b for a, b in zip(old[::-1], new[::-1])), False].index(False)
    texts = [" ".join(" ".join(lines[: len(lines) - end]).split()) for lines in (old, new)]
    return first + 1, f"`{texts[0]}` → `{texts[1]}`"


def is_pure(name: str) -> bool:
    return code_rules.is_in(name, code_rules.PURE)


def modules_of(wiring: bool, packages: Sequence[str], places: Sequence[str]) -> List[pathlib.Path]:
    """Return modules and scripts.

    :param wiring: True for modules that connect to ROS and the page's scripts, False for pure ones
    :param packages: packages of the modules; empty for all
    :param places: files and folders; all of their modules are returned instead
    :raises Unfit: if a package or a place lacks such a module
    """
    known = {path: wiring for path in sorted(SOURCES.glob("*/www/js/**/*.js"))}
    for name, path in code_rules.modules():
        if path.name != "__init__.py" and path.parent.name != "scripts":
            known[path] = is_pure(name) != wiring and not code_rules.is_in(name, FOR_TESTS)
    roots = [pathlib.Path(text).resolve() for text in places]
    if roots:
        known = {path: bool({path, *path.parents} & set(roots)) for path in known}
    chosen = [path for path, is_chosen in known.items() if is_chosen]
    if packages:
        roots = [SOURCES / package for package in packages]
        chosen = [path for path in chosen if set(roots) & set(path.parents)]
    for root in roots:
        if not any(root in (path, *path.parents) for path in chosen):
            raise Unfit(f"{root} is not a module of a package, and contains no such module")
    return chosen


def ask(tool: str, **request: Sequence[Any]) -> List[Any]:
    """Request an answer of cosmic.py.

    :param tool: the Python interpreter of cosmic-ray's environment
    :raises Unfit: if cosmic-ray fails
    """
    done = subprocess.run(
        [tool, "-B", str(pathlib.Path(__file__).with_name("cosmic.py"))],
        input=json.dumps(request),
        stdout=subprocess.PIPE,
        encoding="utf-8",
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
    )
    if done.returncode:
        raise Unfit("cosmic-ray could not make mutants")
    return list(json.loads(done.stdout))


def draw(tool: str, modules: Sequence[pathlib.Path], count: int, seed: int) -> List[Mutant]:
    """Draw mutants of some modules, evenly by type of fault as far as possible.

    The draw depends on the seed and the sources: a change in one module hardly affects others.

    :param tool: the Python interpreter of cosmic-ray's environment
    :raises Unfit: if cosmic-ray fails
    """
    names = {path: name for name, path in code_rules.modules()}
    found = ask(tool, list=[(str(path), is_pure(names[path])) for path in modules if path in names])
    for path in modules:
        if path not in names:
            found += javascript.listed(str(path), path.read_text("utf-8"))
    seen: Counter[str] = collections.Counter()
    for one in found:
        name = f"{pathlib.Path(one['module']).relative_to(SOURCES)}: {one['kind']}: {one['place']}"
        seen[name] += 1
        one["key"] = f"{name}: {seen[name]}"
        one["lot"] = hashlib.sha256(f"{seed} {one['key']}".encode()).hexdigest()
    for one in sorted(found, key=lambda one: str(one["lot"])):
        seen[one["kind"]] += 1
        one["rank"] = seen[one["kind"]]
    chosen = sorted(found, key=lambda one: (one["rank"], one["lot"]))[:count]
    made = iter(ask(tool, make=[one["recipe"] for one in chosen if "recipe" in one]))
    drawn = []
    for one in chosen:
        path, text = pathlib.Path(one["module"]), one.get("made") or next(made)
        line, change = change_of(path.read_text("utf-8"), text)
        module = str(path.relative_to(SOURCES))
        drawn.append(Mutant(module, one["kind"], one["key"], text, line, change))
    return drawn
