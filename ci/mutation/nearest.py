"""The unit tests of a package that import a module, the nearest first."""

import ast
import functools
import pathlib
import runpy
from typing import Dict, List, Set

from ..lint import code_rules


@functools.lru_cache(maxsize=None)
def graph() -> Dict[str, Set[str]]:
    """Return what each module imports of the others."""
    modules = code_rules.modules()
    return code_rules.import_graph({name: ast.parse(path.read_bytes()) for name, path in modules})


def unit_tests(package: pathlib.Path, module: str) -> List[pathlib.Path]:
    """Return the test files that import a module or name a script, even indirectly.

    A test that conftest.py ignores is left out: pytest would run it if it is named.

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
    distances = {test: distance(imported_by(test), name) for test in tests}
    near = [test for test in tests if distances[test] < len(graph())]
    return sorted(near, key=lambda test: (test.stem != f"test_{path.stem}", distances[test]))


@functools.lru_cache(maxsize=None)
def imported_by(test: pathlib.Path) -> Set[str]:
    """Return what a test imports, itself or through a helper in its folder."""
    names: Set[str] = set()
    for _, imported in code_rules.imports(ast.parse(test.read_bytes())):
        names |= {imported, imported.rpartition(".")[0]}
        helper = test.with_name(imported.split(".")[0] + ".py")
        if helper.is_file() and helper != test:
            names |= imported_by(helper)
    return names


def distance(names: Set[str], module: str) -> int:
    """Return over how many imports a module is reached from some names; a large number if not."""
    seen: Set[str] = set()
    steps = 0
    while module not in names:
        seen |= names
        names = {name for one in names for name in graph().get(one, ())} - seen
        steps += 1
        if not names:
            return len(graph())
    return steps
