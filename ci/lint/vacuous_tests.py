"""Check that tests assert something even if their data is empty.

``python3 ci lint.vacuous_tests`` prints each test with all of its assertions in loops over
possibly empty data, or about all items of it, and ends with status 1 if there is one. A test passes
once it asserts that the data is not empty. Data from hypothesis is ignored: it is not always empty.
"""

import ast
import pathlib
import sys
from typing import Iterator, List, Set, Tuple

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
#: Folders of tests.
TESTS = ("src/*/test/**/test_*.py", "ci/tests/**/test_*.py", "docs/tests/test_*.py")

#: Beginnings of names of functions that assert something; a wait fails after its timeout.
ASSERTING = ("assert", "check", "expect", "fail", "raises", "until", "wait")
#: Calls with a non-empty result if each argument, or else their object, is not empty.
_PASSING = set(
    "enumerate list map reversed set sorted tuple chain product zip "
    "items keys splitlines split values".split()
)


def idle_tests(tree: ast.Module) -> Iterator[Tuple[int, str]]:
    """Return line and name of each test that asserts nothing if its data is empty.

    :param tree: a module of tests
    """
    everywhere = filled_names(tree, set())
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and function.name.startswith("test"):
            known = everywhere | filled_names(function, everywhere)
            checks = [is_idle for each in function.body for is_idle in _checks(each, known, False)]
            is_given = any("given" in ast.dump(each) for each in function.decorator_list)
            if checks and all(checks) and not is_given:
                yield function.lineno, function.name


def filled_names(tree: ast.AST, known: Set[str]) -> Set[str]:
    """Return the names that are never assigned or returned as empty.

    :param tree: a module, or a function
    :param known: such names of the enclosing scope
    """
    values: List[Tuple[str, ast.AST]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            values += [(each.id, node.value) for each in node.targets if isinstance(each, ast.Name)]
        elif isinstance(node, ast.FunctionDef) and node is not tree:
            returns = [each for each in ast.walk(node) if isinstance(each, ast.Return)]
            values += [(node.name, each.value or each) for each in returns]
    filled: Set[str] = set()
    for name, value in values:
        if is_filled(value, known | filled):
            filled.add(name)
    return filled - {name for name, value in values if not is_filled(value, known | filled)}


def is_filled(node: ast.AST, known: Set[str]) -> bool:
    """Return whether the value of an expression is certainly not empty.

    :param node: the expression
    :param known: names of such values
    """
    if isinstance(node, ast.Constant):
        return bool(node.value)
    if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
        stars = [each.value for each in node.elts if isinstance(each, ast.Starred)]
        return len(stars) < len(node.elts) or any(is_filled(each, known) for each in stars)
    if isinstance(node, ast.Dict):
        return None not in node.keys and bool(node.keys)
    if isinstance(node, (ast.Name, ast.Attribute)):  # constants are written by the author
        name = node.id if isinstance(node, ast.Name) else node.attr
        return name in known or name.isupper()
    if isinstance(node, (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)):
        return all(is_filled(each.iter, known) and not each.ifs for each in node.generators)
    return isinstance(node, ast.Call) and _gives_something(node, known)


def _gives_something(call: ast.Call, known: Set[str]) -> bool:
    name, arguments = _name(call), call.args
    if name == "range":
        end = arguments[min(1, len(arguments) - 1)]
        return not isinstance(end, ast.Constant) or end.value != 0
    if name not in _PASSING:
        return isinstance(call.func, ast.Name) and name in known
    parts = arguments[name == "map" :] or [getattr(call.func, "value", call.func)]
    return all(is_filled(each, known) for each in parts)


def _checks(node: ast.AST, known: Set[str], is_idle: bool) -> Iterator[bool]:
    """Return for each assertion below a node whether empty data may satisfy it.

    :param node: the node to search, without functions defined in it
    :param known: names of non-empty values
    :param is_idle: whether the node itself may never be reached
    """
    if isinstance(node, (ast.FunctionDef, ast.Lambda)):
        return
    if isinstance(node, ast.Assert):
        yield is_idle or _is_about_all(node.test, known)
    elif isinstance(node, ast.Call) and _name(node).lower().lstrip("_").startswith(ASSERTING):
        yield is_idle or any(_is_about_all(each, known) for each in node.args[:1])
    for child in ast.iter_child_nodes(node):
        in_loop = (
            isinstance(node, ast.For) and child in node.body and not is_filled(node.iter, known)
        )
        yield from _checks(child, known, is_idle or in_loop)


def _is_about_all(node: ast.AST, known: Set[str]) -> bool:
    """Return whether empty data satisfies an expression: ``all(...)``, ``not any(...)``."""
    wanted = "all"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        node, wanted = node.operand, "any"
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args):
        return False
    return node.func.id == wanted and not is_filled(node.args[0], known)


def _name(call: ast.Call) -> str:
    return getattr(call.func, "attr", "") or getattr(call.func, "id", "")


def all_idle() -> Iterator[str]:
    """Return a line for each test that asserts nothing if its data is empty."""
    for path in sorted(each for place in TESTS for each in WORKSPACE.glob(place)):
        for line, name in idle_tests(ast.parse(path.read_text("utf-8"))):
            where = f"{path.relative_to(WORKSPACE)}:{line}: {name}"
            yield f"{where} asserts nothing if its data is empty: assert that it is not"


if __name__ == "__main__":
    sys.exit("\n".join(all_idle()) or 0)
