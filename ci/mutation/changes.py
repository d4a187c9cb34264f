"""What can be changed in a module of wiring, one thing at a time, as text.

A statement is dropped, a condition turned round, an exception not caught, a loop not entered, a
number is one more, a flag the other one. Left as they are: what runs at import, type hints, texts
and what is logged, and figures with a point, which say how patient something is.
"""

import ast
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple, Type

#: What logs, besides rospy's "log…": its arguments are for people to read.
LOGGING = {"debug", "info", "warning", "error", "exception", "critical"}
#: What nobody sees the lack of, by the end of its name: without a pause a loop is busier.
UNSEEN = ("debug", "sleep")
#: Functions that make what people read.
FOR_READERS = {"__repr__", "__str__"}

COMPARISONS: Dict[Type[ast.cmpop], str] = {
    ast.Eq: "!=",
    ast.NotEq: "==",
    ast.Is: "is not",
    ast.IsNot: "is",
    ast.In: "not in",
    ast.NotIn: "in",
    ast.Lt: ">=",
    ast.GtE: "<",
    ast.Gt: "<=",
    ast.LtE: ">",
}
ARITHMETIC: Dict[Type[ast.operator], str] = {
    ast.Add: "-",
    ast.Sub: "+",
    ast.Mult: "/",
    ast.Div: "*",
}


class Change(NamedTuple):
    """A piece of a source text, and what stands there instead."""

    #: Of the text in UTF-8, as in the positions of ast.
    begin: int
    end: int
    new: str


class Source:
    """The text of a module, and all that can be changed in it."""

    def __init__(self, text: str) -> None:
        self._tree = ast.parse(text)
        self._bytes = text.encode()
        self._starts = [0]
        for line in self._bytes.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def lines_of(self, change: Change) -> Tuple[int, str, str]:
        """Return where a change begins, and in one line each what is there and what will be.

        :returns: number of the first line, from 1 on; its text with the lines that are changed
            along with it; the same with the change
        """
        first = self._bytes.count(b"\n", 0, change.begin)
        last = self._bytes.count(b"\n", 0, change.end)
        begin, end = self._starts[first], self._starts[last + 1]
        before = self._bytes[begin:end].decode()
        parts = (
            self._bytes[begin : change.begin],
            change.new.encode(),
            self._bytes[change.end : end],
        )
        after = b"".join(parts).decode()
        return first + 1, " ".join(before.split()), " ".join(after.split())

    def changed(self, change: Change) -> str:
        """Return the text with a change."""
        parts = self._bytes[: change.begin], change.new.encode(), self._bytes[change.end :]
        return b"".join(parts).decode()

    def changes(self) -> List[Change]:
        """Return all changes, in the order of the text."""
        functions = [
            node
            for node in ast.walk(self._tree)
            if isinstance(node, ast.FunctionDef) and node.name not in FOR_READERS
        ]
        found = {
            change
            for function in functions
            for statement in function.body
            for change in self._of_statement(statement, function.name)
        }
        return sorted(found)

    def _replaced(self, node: ast.AST, new: str) -> Change:
        return Change(self._begin(node), self._end(node), new)

    def _between(self, left: ast.AST, right: ast.AST, new: str) -> Change:
        """Return another operator between two operands, whose brackets stay where they are."""
        begin, end = self._end(left), self._begin(right)
        gap = self._bytes[begin:end].decode()
        closing = len(gap) - len(gap.lstrip(") \n"))
        opening = len(gap) - len(gap.rstrip("( \n"))
        return Change(begin + closing, end - opening, new)

    # Any: a node with a place in the text, which most kinds of node have.
    def _begin(self, node: Any) -> int:
        return self._starts[node.lineno - 1] + int(node.col_offset)

    def _end(self, node: Any) -> int:
        return self._starts[node.end_lineno - 1] + int(node.end_col_offset)

    def _of_statement(self, node: ast.AST, function: str) -> Iterator[Change]:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            return  # its functions have their turn
        if may_be_dropped(node, function):
            yield self._replaced(node, "pass")
        if isinstance(node, ast.Raise):
            return
        if isinstance(node, (ast.For, ast.comprehension)):
            yield self._replaced(node.iter, "()")
        if isinstance(node, ast.ExceptHandler) and node.type:
            yield self._replaced(node.type, "()")
        if isinstance(node, ast.expr):
            yield from self._of_expression(node)
        for condition in conditions(node):
            yield self._replaced(condition, f"(not ({self._text(condition)}))")
        hidden = hidden_parts(node)
        for child in ast.iter_child_nodes(node):
            if child not in hidden:
                yield from self._of_statement(child, function)

    def _of_expression(self, node: ast.expr) -> Iterator[Change]:
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            new = COMPARISONS[type(node.ops[0])]
            yield self._between(node.left, node.comparators[0], new)
        elif isinstance(node, ast.BoolOp):
            new = "or" if isinstance(node.op, ast.And) else "and"
            for left, right in zip(node.values, node.values[1:]):
                yield self._between(left, right, new)
        elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
            if not any(is_text(side) for side in (node.left, node.right)):
                yield self._between(node.left, node.right, ARITHMETIC[type(node.op)])
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield self._replaced(node, f"bool({self._text(node.operand)})")
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield self._replaced(node, str(not node.value))
        elif isinstance(node, ast.Constant) and isinstance(node.value, int):
            yield self._replaced(node, str(node.value + 1))

    def _text(self, node: ast.AST) -> str:
        return self._bytes[self._begin(node) : self._end(node)].decode()


def may_be_dropped(node: ast.AST, function: str) -> bool:
    """Tell whether a statement does something of its own, so that others go on without it.

    :param function: the name of the function that it is in
    """
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Call) and not called(node.value).endswith(UNSEEN)
    if isinstance(node, ast.Return):
        return node.value is None
    if isinstance(node, ast.Raise):
        return "NotImplementedError" not in ast.dump(node)
    if isinstance(node, ast.Assign) and function != "__init__":
        return all(isinstance(one, (ast.Attribute, ast.Subscript)) for one in node.targets)
    return isinstance(node, (ast.AugAssign, ast.Delete, ast.Break, ast.Continue))


def conditions(node: ast.AST) -> List[ast.expr]:
    """Return the conditions of a node that are not turned round by their own operator."""
    found = []
    if isinstance(node, (ast.If, ast.While, ast.IfExp)):
        found = [node.test]
    elif isinstance(node, ast.comprehension):
        found = node.ifs
    return [one for one in found if not isinstance(one, (ast.Compare, ast.UnaryOp))]


def hidden_parts(node: ast.AST) -> List[Optional[ast.AST]]:
    """Return the parts of a node in which nothing is changed."""
    if isinstance(node, ast.AnnAssign):
        return [node.annotation]
    if isinstance(node, ast.arg):
        return [node.annotation]
    if isinstance(node, ast.JoinedStr):
        return list(node.values)
    if isinstance(node, ast.Call):
        if called(node) in LOGGING or called(node).startswith("log"):
            return [*node.args, *node.keywords]
    return []


def called(node: ast.Call) -> str:
    """Return the bare name of what is called."""
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or isinstance(getattr(node, "value", None), str)
