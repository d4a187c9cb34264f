"""Which unit tests of a package import a module, the nearest first."""

import ast
import functools
import pathlib
import runpy
from typing import Dict, List, Set

from ..lint import code_rules


class UnitTests:
    """The unit tests of all packages."""

    def __init__(self) -> None:
        self._names = {path: name for name, path in code_rules.modules()}

    @functools.cached_property
    def _graph(self) -> Dict[str, Set[str]]:
        trees = {name: ast.parse(path.read_text("utf-8")) for path, name in self._names.items()}
        return code_rules.import_graph(trees)

    def all_of(self, package: str) -> List[pathlib.Path]:
        """Return all files of a package, but for those that pytest is told to ignore here.

        It would not ignore them where they are named, and what they need is not installed.
        """
        place = code_rules.SOURCES / package / "test" / "unit"
        told = place / "conftest.py"
        ignored = runpy.run_path(str(told)).get("collect_ignore", ()) if told.is_file() else ()
        return sorted(path for path in place.glob("test_*.py") if path.name not in ignored)

    def of(self, module: pathlib.Path) -> List[pathlib.Path]:
        """Return the files in the module's package that import it, even by way of others."""
        package = module.relative_to(code_rules.SOURCES).parts[0]
        distances: Dict[pathlib.Path, int] = {}
        for test in self.all_of(package):
            distance = self._distance(test, self._names[module])
            if distance:
                distances[test] = distance
        return sorted(distances, key=lambda test: distances[test])

    def _distance(self, test: pathlib.Path, module: str) -> int:
        """Return over how many imports a test has a module; 0 if it does not have it."""
        tree = ast.parse(test.read_text("utf-8"))
        level = {
            name
            for _, imported in code_rules.imports(tree)
            for name in (imported, imported.rpartition(".")[0])
        }
        seen: Set[str] = set()
        distance = 1
        while level and module not in level:
            seen |= level
            level = {name for one in level for name in self._graph.get(one, ())} - seen
            distance += 1
        return distance if level else 0
