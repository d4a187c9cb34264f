"""Unit tests of a package that import a module, the nearest first."""

import ast
import functools
import pathlib
import runpy
from typing import Dict, List, Set

from ..lint import code_rules

MODULES = dict(code_rules.modules())


def unit_tests(package: pathlib.Path, module: str) -> List[pathlib.Path]:
    """Return the test files that import a module or name a script, even indirectly.

    Tests that conftest.py ignores are omitted: pytest would run them if they are named.

    :param package: a folder with its tests
    :param module: the module's path below src
    """
    path, folder = pathlib.Path(module), package / "test" / "unit"
    conftest = folder / "conftest.py"
    ignored = runpy.run_path(str(conftest)).get("collect_ignore", ()) if conftest.is_file() else ()
    tests = sorted(test for test in folder.glob("test_*.py") if test.name not in ignored)
    if path.suffix == ".js":
        return [test for test in tests if path.name in test.read_text("utf-8")]
    name = ".".join(path.with_suffix("").parts[2:])
    steps = {test: imports_between(test).get(name) for test in tests}
    near = [
        (test.stem != f"test_{path.stem}", count, test) for test, count in steps.items() if count
    ]
    return [test for *_, test in sorted(near)]


@functools.lru_cache(maxsize=None)
def imports_between(test: pathlib.Path) -> Dict[str, int]:
    """Return the number of imports from a test to each module, also through helpers beside it."""
    steps: Dict[str, int] = {}
    names, count = imported_by(test), 1
    while names:
        steps.update(dict.fromkeys(names, count))
        helpers = {name: test.with_name(f"{name}.py") for name in names}
        paths = {MODULES.get(name, helpers[name]) for name in names}
        names = {name for path in paths if path.is_file() for name in imported_by(path)} - set(
            steps
        )
        count += 1
    return steps


@functools.lru_cache(maxsize=None)
def imported_by(path: pathlib.Path) -> Set[str]:
    """Return the modules that a file imports, and the names in them."""
    found = [name for _, name in code_rules.imports(ast.parse(path.read_bytes()))]
    return {*found, *(name.rpartition(".")[0] for name in found)}
