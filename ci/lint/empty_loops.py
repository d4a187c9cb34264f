"""Check that tests assert something also where their data is empty.

``python3 ci lint.empty_loops`` prints each test all of whose assertions stand in loops over
what may be empty, or are about all of it, and ends with status 1 if there is one. It passes once
the test asserts that the data is there. What hypothesis gives is left out: it is not empty each
time.
"""

import ast
import pathlib
import sys
from typing import Iterator, List, Set, Tuple

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
#: Where tests are.
TESTS = ("src/*/test/**/test_*.py", "ci/tests/**/test_*.py", "docs/tests/test_*.py")

#: How the name of what asserts something begins; a wait fails where what it is for does not come.
ASSERTING = ("assert", "check", "expect", "fail", "raises", "until", "wait")
#: Calls that give as much as their first argument has.
_AS_MUCH = {"enumerate", "list", "map", "reversed", "set", "sorted", "tuple"}
#: Methods that give as much as their object has.
_METHODS = {"items", "keys", "splitlines", "split", "values"}
#: Calls that give something only where each of their arguments has something.
_EACH = {"product", "zip"}
#: Calls that never end.
_ENDLESS = {"count", "cycle", "repeat"}


def idle_tests(tree: ast.Module) -> Iterator[Tuple[int, str]]:
    """Return line and name of each test that asserts nothing where its data is empty.

    :param tree: a module of tests
    """
    everywhere = filled_names(tree.body, set())
    everywhere |= _giving_functions(tree, everywhere)
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and function.name.startswith("test"):
            known = everywhere | filled_names(function.body, everywhere)
            checks = [is_idle for each in function.body for is_idle in _checks(each, known, False)]
            is_given = any("given" in ast.dump(each) for each in function.decorator_list)
            if checks and all(checks) and not is_given:
                yield function.lineno, function.name


def filled_names(body: List[ast.stmt], known: Set[str]) -> Set[str]:
    """Return the names that stand for something that is not empty, whenever they are assigned.

    :param body: statements, with those of classes and blocks in them
    :param known: such names of around them
    """
    filled: Set[str] = set()
    empty: Set[str] = set()
    for statement in body:
        for node in ast.walk(statement):
            if isinstance(node, ast.Assign):
                targets, value = node.targets, node.value
            elif isinstance(node, ast.AnnAssign) and node.value is not None:
                targets, value = [node.target], node.value
            else:
                continue
            kind = filled if is_filled(value, known | filled) else empty
            kind.update(target.id for target in targets if isinstance(target, ast.Name))
    return filled - empty


def _giving_functions(tree: ast.Module, known: Set[str]) -> Set[str]:
    """Return the names of the module's functions that are certain to return something filled."""
    giving: Set[str] = set()
    for function in tree.body:
        if isinstance(function, ast.FunctionDef):
            returns = [each.value for each in ast.walk(function) if isinstance(each, ast.Return)]
            if returns and all(value is not None and is_filled(value, known) for value in returns):
                giving.add(function.name)
    return giving


def is_filled(node: ast.AST, known: Set[str]) -> bool:
    """Tell whether an expression is certain to give at least one thing.

    :param node: the expression
    :param known: names that stand for such a thing
    """
    if isinstance(node, ast.Constant):
        return bool(node.value)
    if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
        return any(
            not isinstance(each, ast.Starred) or is_filled(each.value, known) for each in node.elts
        )
    if isinstance(node, ast.Dict):
        return any(
            key is not None or is_filled(value, known) for key, value in zip(node.keys, node.values)
        )
    if isinstance(node, (ast.Name, ast.Attribute)):  # a constant is what an author has written
        name = node.id if isinstance(node, ast.Name) else node.attr
        return name in known or name.isupper()
    if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Mult)):
        return is_filled(node.left, known) or is_filled(node.right, known)
    if isinstance(node, (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)):
        return all(is_filled(each.iter, known) and not each.ifs for each in node.generators)
    return isinstance(node, ast.Call) and _gives_something(node, known)


def _gives_something(call: ast.Call, known: Set[str]) -> bool:
    name, arguments = _name(call), call.args
    if name in _ENDLESS or name == "dict" and call.keywords:
        return True
    if isinstance(call.func, ast.Name) and name in known:
        return True
    if name in _METHODS and isinstance(call.func, ast.Attribute):
        return is_filled(call.func.value, known)
    if name == "range":
        end = arguments[min(1, len(arguments) - 1)]
        return not isinstance(end, ast.Constant) or end.value != 0
    if name == "chain":
        return any(is_filled(each, known) for each in arguments)
    if name in _EACH:
        return bool(arguments) and all(is_filled(each, known) for each in arguments)
    return (
        name in _AS_MUCH
        and bool(arguments)
        and is_filled(arguments[-1 if name == "map" else 0], known)
    )


def _checks(node: ast.AST, known: Set[str], is_idle: bool) -> Iterator[bool]:
    """Return for each assertion below a node whether it may hold of nothing.

    :param node: what to look through, without the functions that are defined in it
    :param known: names of what is not empty
    :param is_idle: whether the node itself may never be come to
    """
    if isinstance(node, (ast.FunctionDef, ast.Lambda)):
        return
    if isinstance(node, ast.Assert):
        yield is_idle or _is_about_all(node.test, known)
    elif isinstance(node, ast.Call) and _name(node).lower().lstrip("_").startswith(ASSERTING):
        yield is_idle or any(_is_about_all(each, known) for each in node.args[:1])
    if isinstance(node, ast.For):
        yield from _checks(node.iter, known, is_idle)
        idle_inside = is_idle or not is_filled(node.iter, known)
        for each in node.body:
            yield from _checks(each, known, idle_inside)
        return
    for child in ast.iter_child_nodes(node):
        yield from _checks(child, known, is_idle)


def _is_about_all(node: ast.AST, known: Set[str]) -> bool:
    """Tell whether an expression is true where there is nothing: ``all(...)``, ``not any(...)``."""
    if isinstance(node, ast.BoolOp) and isinstance(node.op, ast.And):
        return all(_is_about_all(each, known) for each in node.values)
    wanted = "all"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        node, wanted = node.operand, "any"
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args):
        return False
    return node.func.id == wanted and not is_filled(node.args[0], known)


def _name(call: ast.Call) -> str:
    function = call.func
    return getattr(function, "attr", "") or getattr(function, "id", "")


def main() -> int:
    """Print each test that asserts nothing where its data is empty; 1 if there is one."""
    found = 0
    for path in sorted(each for place in TESTS for each in WORKSPACE.glob(place)):
        for line, name in idle_tests(ast.parse(path.read_text("utf-8"))):
            found += 1
            where = f"{path.relative_to(WORKSPACE)}:{line}: {name}"
            print(f"{where} asserts nothing where its data is empty: assert that there is some")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
