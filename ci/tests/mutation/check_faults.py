"""Check the faults of Python modules by examples, run by ci/mutants in cosmic-ray's environment.

cosmic-ray is not installed where the unit tests run, so pytest does not collect this file.
"""

import ast
import sys
import tempfile
from typing import List, Tuple

from cosmic import mutants_of
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

HEAD = "def f(self, a, b):\n    "
#: A statement of a function, and its mutants.
EXAMPLES = [
    ("self.stop()", ["pass"]),
    ("self.send()", ["pass", "self.send(); self.send()"]),
    ("self.items.add(a)", ["pass", "self.items.add(b)"]),
    ("self._x = a", ["pass"]),
    ("self._x: int = a", ["pass"]),
    ("a += b", ["pass"]),
    ("del a[b]", ["pass"]),
    ("raise OSError('no')", ["pass"]),
    ("return", ["pass"]),
    ("return 1", ["return 0"]),
    ("return 2 if a else b", ["return 0 if a else b", "return 2 if not a else b"]),
    ("return sys.exit(130)", ["return sys.exit(0)"]),
    ("c = g(a, 'x')", ["c = g('x', a)", "c = g(b, 'x')"]),
    ("c = g(x=a)", ["c = g(x=b)"]),
    ("c = min(x)", ["c = max(x)"]),
    ("c = x[0]", ["c = x[-1]", "c = x[-1]", "c = x[1]"]),
    ("c = x[-1]", ["c = x[1]", "c = x[-0]", "c = x[-2]", "c = x[0]"]),
    (
        "x[0] = a; g(b)",
        ["pass; g(b)", "x[0] = a; pass", "x[0] = a; g(b); g(b)", "x[0] = a; g(a)"]
        + [f"x[{index}] = a; g(b)" for index in ("-1", "1", "-1")],
    ),
    ("c = [a, b]", ["c = [a]", "c = [b]"]),
    ("c = (a, b)", ["c = (a,)", "c = (b,)"]),
    ("c = {a: x, b: y}", ["c = {a: x}", "c = {b: y}"]),
    ("c = not a", ["c = a"]),
    ("c = a and b", ["c = a or b"]),
    ("c = a == b", ["c = a != b"]),
    ("c = a < b", ["c = a <= b", "c = a >= b", "c = a > b"]),
    ("c = True", ["c = False"]),
    ("c = x if a else y", ["c = x if not a else y"]),
    ("log.info('%d', a + 1)", ["pass"]),
    ("try: c = a\n    except OSError: c = b", ["try: c = a\n    except (): c = b"]),
    ("for c in a: d = c", ["for c in []: d = c"]),
]
#: Statements without mutants.
LEFT = [
    "'''Return 1 and not 2.'''",
    "c: Callable[[Literal[1]], None] = a",
    "c = f'{a + 1}'",
    "c = 0.5",
    "time.sleep(0.5)",
    "log.debug('%d', a + 1)",
    "raise NotImplementedError",
    "c = a",
    "c = [x for x in a]",
]
OTHERS = ["class A:\n    LIMIT = 1\n", "def __repr__(self):\n    return a + b\n", "X = f(1, g)\n"]


def changes_of(text: str) -> List[str]:
    """Return the texts of all mutants of a module that connects to ROS."""
    with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
        file.write(text)
        file.flush()
        recipes = [one["recipe"] for one in mutants_of(file.name, False)]
    return [str(mutate_code(text, get_operator(name)(), index)) for _, name, index in recipes]


def normalized(texts: List[str]) -> List[str]:
    return sorted(ast.unparse(ast.parse(text)) for text in texts)


def main() -> int:
    """Print each example with unexpected mutants.

    :returns: exit status
    """
    cases: List[Tuple[str, List[str]]] = [
        (f"{HEAD}{line}\n", [f"{HEAD}{new}\n" for new in expected])
        for line, expected in [*EXAMPLES, *((line, []) for line in LEFT)]
    ]
    cases += [(text, []) for text in OTHERS]
    wrong = [
        text for text, expected in cases if normalized(changes_of(text)) != normalized(expected)
    ]
    for text in wrong:
        print(f"{text}became\n{''.join(changes_of(text)) or 'nothing'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
