"""Parser of formulas: a checked subset of Python's grammar, never executed.

The lexer runs first, so Python's parser sees only listed tokens, with placeholders for the fields.
The resulting tree is walked once, and any node that is not listed here is rejected.
"""

import ast
import math
from typing import Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple, Type

import numpy

from topic_scope.formulas.expression import (
    Computed,
    Delay,
    Derivative,
    Elementwise,
    Field,
    Highest,
    Lowest,
    LowPass,
    Mean,
    Node,
    Number,
    Operands,
)
from topic_scope.formulas.signals import Signal
from topic_scope.timing.nanoseconds import to_ns
from topic_scope.formulas.lexer import FormulaError, Token, text_of, tokens_of

#: Deepest nesting of operations and functions, and most fields of a formula.
DEPTH, FIELDS = 24, 8
#: Most functions over time, which take longer than the others.
OVER_TIME = 8
#: Longest delay and averaging window [s], and the longest total of a formula.
SECONDS = 600.0
#: Bounds of the cut-off frequency of a low-pass [Hz].
CUTOFF = (0.02, 1e6)

_OPERATIONS: Dict[Type[ast.AST], Callable[..., numpy.ndarray]] = {
    ast.Add: numpy.add,
    ast.Sub: numpy.subtract,
    ast.Mult: numpy.multiply,
    ast.Div: numpy.divide,
    ast.Mod: numpy.mod,
    ast.Pow: numpy.power,
    ast.USub: numpy.negative,
    ast.UAdd: numpy.positive,
}
_OF_ONE: Dict[str, Callable[..., numpy.ndarray]] = {
    "abs": numpy.abs,
    "sqrt": numpy.sqrt,
    "exp": numpy.exp,
    "log": numpy.log,
    "log10": numpy.log10,
    "sin": numpy.sin,
    "cos": numpy.cos,
    "tan": numpy.tan,
    "asin": numpy.arcsin,
    "acos": numpy.arccos,
    "atan": numpy.arctan,
    "deg": numpy.degrees,
    "rad": numpy.radians,
    "floor": numpy.floor,
    "ceil": numpy.ceil,
    "sign": numpy.sign,
}
_OF_TWO: Dict[str, Callable[..., numpy.ndarray]] = {
    "atan2": numpy.arctan2,
    "hypot": numpy.hypot,
    "min": numpy.minimum,
    "max": numpy.maximum,
}
#: Functions over time: class, description of the second argument, and its bounds.
_OVER_TIME: Dict[str, Tuple[Callable[[Computed, float], Computed], str, float, float]] = {
    "delay": (Delay, "a time in s", -SECONDS, SECONDS),
    "mean": (Mean, "a time in s", 1e-6, SECONDS),
    "highest": (Highest, "a time in s", 0.0, SECONDS),
    "lowest": (Lowest, "a time in s", 0.0, SECONDS),
    "lowpass": (LowPass, "a frequency in Hz", *CUTOFF),
}
_CONSTANTS = {"pi": math.pi}
#: Names of all functions.
FUNCTIONS: Tuple[str, ...] = (*_OF_ONE, *_OF_TWO, *_OVER_TIME, "derivative")


class Formula(NamedTuple):
    """Parsed formula.

    :param tokens: its tokens
    :param tree: its expression tree
    """

    tokens: Sequence[Token]
    tree: Computed

    @property
    def fields(self) -> Tuple[str, ...]:
        """Fields of the formula; the stamps of the first are used."""
        return tuple(self.tree.fields)

    def computed(self, signals: Mapping[str, Signal]) -> Signal:
        """Evaluate the formula on complete signals.

        :param signals: the samples by name of the field
        """
        return self.tree.signal(Operands.of(signals), to_ns(-math.inf), to_ns(math.inf))

    def text(self, names: Callable[[str], str] = str) -> str:
        """Return the formula as text.

        :param names: returns the text of a field
        """
        return text_of(
            [
                Token("field", names(token.text)) if token.kind == "field" else token
                for token in self.tokens
            ]
        )


def parse_formula(text: str) -> Formula:
    """Parse a formula.

    :param text: the formula, without the ``=`` before it
    :raises FormulaError: if it is invalid; the text states the reason
    """
    tokens = tokens_of(text)
    fields: List[str] = []
    parts: List[str] = []
    for token in tokens:
        if token.kind == "field":
            parts.append(f"_{len(fields)}")
            fields.append(token.text)
        else:
            parts.append(token.text)
    if len(set(fields)) > FIELDS:
        raise FormulaError(f"a formula has at most {FIELDS} fields, not {len(set(fields))}")
    try:
        parsed = ast.parse(" ".join(parts), mode="eval")
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise FormulaError("invalid formula") from None
    tree = _Reader(fields).node(parsed.body, 0)
    if isinstance(tree, Number):
        raise FormulaError("a formula needs at least one field, such as /topic/field")
    past = _far(tree)
    if past > SECONDS:
        raise FormulaError(
            f"delays, means and filters reach over {past:.0f} s: at most {SECONDS:.0f}"
        )
    return Formula(tokens, tree)


def _far(tree: Computed) -> float:
    """Return the longest time span that a value of a formula depends on [s]."""
    none = numpy.empty(0, numpy.int64)
    nothing = Signal(none, numpy.empty(0), none, 0.0)
    back, ahead = tree.lookaround(Operands.of(dict.fromkeys(tree.fields, nothing)))
    return max(abs(back), abs(ahead))


class _Reader:
    """Builder of the expression tree of a formula.

    :param fields: fields of the placeholders
    """

    def __init__(self, fields: Sequence[str]) -> None:
        self._fields = fields
        self._over_time = 0

    def node(self, parsed: ast.AST, depth: int) -> Node:
        """Return the expression of a node of Python's syntax tree.

        :param depth: its nesting depth
        :raises FormulaError: if the node is not allowed
        """
        if depth > DEPTH:
            raise FormulaError(f"operations are nested too deeply (at most {DEPTH})")
        if isinstance(parsed, ast.Constant) and type(parsed.value) in (int, float):
            value = parsed.value
            return _number(lambda: float(value))
        if isinstance(parsed, ast.Name):
            return self._named(parsed.id)
        if isinstance(parsed, ast.BinOp) and type(parsed.op) in _OPERATIONS:
            sides = [self.node(side, depth + 1) for side in (parsed.left, parsed.right)]
            return _each(_OPERATIONS[type(parsed.op)], sides)
        if isinstance(parsed, ast.UnaryOp) and type(parsed.op) in _OPERATIONS:
            return _each(_OPERATIONS[type(parsed.op)], [self.node(parsed.operand, depth + 1)])
        if isinstance(parsed, ast.Call) and isinstance(parsed.func, ast.Name):
            return self._call(parsed.func.id, [self.node(one, depth + 1) for one in parsed.args])
        if isinstance(parsed, ast.Tuple):
            raise FormulaError(
                "unexpected comma; it separates arguments of a function, decimals need a point"
            )
        raise FormulaError("invalid formula")

    def _named(self, name: str) -> Node:
        if name.startswith("_"):
            return Field(self._fields[int(name[1:])])
        if name in _CONSTANTS:
            return Number(_CONSTANTS[name])
        if name in FUNCTIONS:
            raise FormulaError(f"{name} needs its arguments in brackets")
        raise FormulaError(f"unknown name {name}; the name of a field begins with /")

    def _call(self, name: str, arguments: List[Node]) -> Node:
        if name not in FUNCTIONS:
            raise FormulaError(f"unknown function {name}; known are {', '.join(FUNCTIONS)}")
        count = 1 if name in _OF_ONE or name == "derivative" else 2
        if len(arguments) != count:
            raise FormulaError(f"{name} takes {count} argument{'s' * (count > 1)}")
        if name in _OF_ONE or name in _OF_TWO:
            return _each({**_OF_ONE, **_OF_TWO}[name], arguments)
        self._over_time += 1
        if self._over_time > OVER_TIME:
            raise FormulaError(f"a formula has at most {OVER_TIME} delays, filters and derivatives")
        of, *others = arguments
        if isinstance(of, Number):
            raise FormulaError(f"{name} takes a trace, not a number")
        if not others:
            return Derivative(of)
        make, tokens, low, high = _OVER_TIME[name]
        if not isinstance(others[0], Number) or not low <= others[0].value <= high:
            raise FormulaError(
                f"{name}: the second argument must be {tokens}, from {low:g} to {high:g}"
            )
        return make(of, others[0].value)


def _each(function: Callable[..., numpy.ndarray], arguments: List[Node]) -> Node:
    """Return an operation, or its result if all arguments are numbers."""
    numbers = [one.value for one in arguments if isinstance(one, Number)]
    if len(numbers) == len(arguments):
        return _number(lambda: float(function(*map(numpy.float64, numbers))))
    return Elementwise(function, arguments)


def _number(compute: Callable[[], float]) -> Number:
    """Return a number; always a float, so that powers of integers cannot grow without bound."""
    try:
        with numpy.errstate(all="ignore"):
            value = compute()
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise FormulaError("a constant is infinite or not a number")
    return Number(value)
