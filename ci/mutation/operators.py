"""Operator for cosmic-ray with realistic faults; cosmic-ray finds it by an entry point."""

from typing import Any, Dict, Iterator, List, Tuple

from cosmic_ray.operators.operator import Operator
from parso.python.tree import Name

#: Any: parso has no types.
Node = Any

CLOSING = set(
    "close unregister shutdown cancel stop disconnect join release kill terminate".split()
)
#: Idempotent calls, and calls without which a loop is only busier.
IDEMPOTENT = set("set clear add discard update setdefault wait mkdir flush".split())
UNSEEN = ("debug", "sleep")
LOGGING = ("log", "debug", "info", "warn", "error", "exception", "critical", "print")
SWAPPED = {"min": "max", "max": "min", "[0]": "[-1]", "[-1]": "[0]"}


def text_of(node: Node) -> str:
    return str(node.get_code(include_prefix=False))


def called(node: Node) -> str:
    """Return the bare name of the function that a node calls; empty if it is not a call."""
    is_call = node.type == "atom_expr" and text_of(node.children[-1])[0] == "("
    return text_of(node.children[-2]).lstrip(".") if is_call else ""


def faults(node: Node) -> Iterator[Tuple[str, str]]:
    """Return the types of faults of a node, and the replacement texts."""
    if node.parent is None:
        return
    function, text = node.search_ancestor("funcdef"), text_of(node)
    if node.parent.type == "simple_stmt":
        yield from faults_of_statement(node, function)
    if node.type == "name" and text in SWAPPED and text_of(node.get_next_leaf()) == "(":
        yield "min for max", SWAPPED[text]
    if node.type == "trailer" and text in SWAPPED:
        yield "first for last", SWAPPED[text]
    if node.type == "except_clause":
        yield "uncaught exception", " ".join(["except ()", *map(text_of, node.children[2:])])
    if node.type == "arglist":
        parts = elements(node)
        plain = [child for child in node.children if child.type not in ("argument", "operator")]
        for i in range(len(plain) - 1):
            swapped = [*parts[:i], parts[i + 1], parts[i], *parts[i + 2 :]]
            yield "swapped arguments", ", ".join(swapped)
    is_display = node.type in ("testlist_comp", "dictorsetmaker")
    if is_display and "comp_for" not in node.children[-1].type and len(elements(node)) > 1:
        for parts in (elements(node)[1:], elements(node)[:-1]):
            comma = "," if text_of(node.get_previous_leaf()) == "(" else ""
            yield "dropped element", ", ".join(parts) + comma
    if node.type == "number" and text.isdigit() and text.strip("0"):
        place = node.parent.parent if node.parent.type == "test" else node.parent
        if place.type == "return_stmt" or text_of(place.parent).endswith(f"exit({text})"):
            yield "dropped exit status", "0"
    is_value = node.parent.type == "argument" and node.parent.children[-1] is node
    is_alone = node.parent.type == "trailer" and text_of(node.parent)[0] == "("
    if node.type == "name" and function and (node.parent.type == "arglist" or is_value or is_alone):
        names = variables(function, node)
        if text in names and len(names) > 1:
            yield "wrong variable", names[names.index(text) - 1]


def faults_of_statement(node: Node, function: Node) -> Iterator[Tuple[str, str]]:
    """Return the faults of a simple statement in a function, or None, like ``faults``."""
    name, text = called(node), text_of(node)
    operator = text_of(node.children[1]) if node.type == "expr_stmt" else ""
    is_bare = text in ("return", "raise") or node.type == "del_stmt" or operator[1:] == "="
    is_raised = node.type == "raise_stmt" and "NotImplementedError" not in text
    if name in CLOSING:
        yield "missing close", "pass"
    elif name and not name.endswith(UNSEEN) or is_bare or is_raised:
        yield "dropped statement", "pass"
        if name and name not in IDEMPOTENT and not name.startswith(LOGGING):
            yield "effect twice", f"{text}; {text}"
    is_member = operator[:1] in ("=", ":") and node.children[0].type == "atom_expr"
    if is_member and function and function.name.value != "__init__":
        yield "stale value", "pass"


def elements(node: Node) -> List[str]:
    """Return the texts between the commas of a node."""
    found = [""]
    for child in node.children:
        found = (
            [*found, ""] if text_of(child) == "," else [*found[:-1], found[-1] + child.get_code()]
        )
    return [text.strip() for text in found if text.strip()]


def variables(function: Node, node: Node) -> List[str]:
    """Return the parameters and variables that a function defines before a node, in order."""
    found: Dict[str, None] = {}
    end = (node.search_ancestor("expr_stmt") or node).start_pos
    leaf = function.name.get_next_leaf()
    while leaf.start_pos < end:
        if leaf.type == "name" and is_definition(leaf) and leaf.parent.type != "trailer":
            if leaf.search_ancestor("funcdef") is function and leaf.value not in ("self", "cls"):
                found[leaf.value] = None
        leaf = leaf.get_next_leaf()
    return list(found)


def is_definition(name: Node) -> bool:
    """Return whether a name is defined at its place; False in a statement with a fault."""
    try:
        return bool(name.is_definition())
    except AttributeError:  # parso expects a trailer where cosmic-ray has put a name
        return False


class Fault(Operator):
    """All faults as one operator."""

    def mutation_positions(self, node: Node) -> Iterator[Any]:
        return ((node.start_pos, node.end_pos) for _ in faults(node))

    def mutate(self, node: Node, index: int) -> Node:
        leaf = Name(list(faults(node))[index][1], node.start_pos, node.get_first_leaf().prefix)
        leaf.parent = node.parent
        return leaf

    @classmethod
    def examples(cls) -> Any:
        return ()


class Provider(Dict[str, Any]):
    """Provider of the operator for cosmic-ray."""

    def __init__(self) -> None:
        super().__init__(Fault=Fault)
