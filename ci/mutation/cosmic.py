"""List or create mutants of modules: runs in cosmic-ray's environment, communicates by JSON."""

import json
import pathlib
import re
import sys
from typing import Any, Dict, Iterator, List, Tuple

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from operators import LOGGING, Node, called, faults, text_of

#: cosmic-ray's own operators and their types of faults. Only the smallest replacements of an
#: operator are used: a test that detects "-" for "+" detects "**" as well.
CORE = {
    r"\w+_(Add_Sub|Sub_Add|Mul_Div|Div_Mul|FloorDiv_Div|Mod_FloorDiv|Pow_Mul|LShift_RShift"
    r"|RShift_LShift|BitOr_BitAnd|BitAnd_BitOr|BitXor_BitAnd|Delete_USub)": "operator",
    r"\w+_(Eq_NotEq|NotEq_Eq|Is_IsNot|IsNot_Is|(Lt|Gt)E?_(Lt|Gt)E?)": "comparison",
    r"AddNot|ReplaceAndWithOr|ReplaceOrWithAnd|ReplaceUnaryOperator_Delete_Not": "condition",
    r"NumberReplacer|ReplaceTrueWithFalse|ReplaceFalseWithTrue": "constant",
    r"ZeroIterationForLoop|ReplaceBreakWithContinue|ReplaceContinueWithBreak": "loop",
}


def is_hidden(node: Node, kind: str, pure: bool) -> bool:
    """Return whether no test can be expected to detect a change: in type hints, texts and logs.

    :param pure: whether the module is pure; otherwise numbers with a point are time-outs
    """
    function = node.search_ancestor("funcdef")
    if function is None and kind not in ("operator", "dropped element"):
        return True  # settings: only tables and computations are changed
    if function is not None and function.name.value in ("__repr__", "__str__"):
        return True
    if kind == "constant" and ("." in text_of(node) and not pure or list(faults(node))):
        return True
    if kind == "operator" and any("string" in child.type for child in node.parent.children):
        return True
    if kind == "condition" and node.type in ("if_stmt", "while_stmt", "assert_stmt", "test"):
        if node.children[2 if node.type == "test" else 1].type in ("comparison", "not_test"):
            return True  # they have separate operators
    while node.parent is not None:
        above = node.parent
        is_hint = above.type in ("annassign", "tfpdef") and above.children[1] is node
        is_hint = is_hint or above.type == "funcdef" and above.annotation is node
        is_logged = node.type == "trailer" and called(above).startswith(LOGGING)
        is_text = above.type in ("decorator", "raise_stmt") or above.type.startswith("fstring")
        if is_hint or is_logged or is_text:
            return True
        node = above
    return False


def mutants_of(module: str, pure: bool) -> Iterator[Dict[str, Any]]:
    """Return all mutants of a module, without their texts."""
    source = pathlib.Path(module).read_text("utf-8")
    lines, nodes = source.splitlines(), list(ast_nodes(get_ast(source)))
    for name in operator_names():
        own = [kind for core, kind in CORE.items() if re.fullmatch(f"core/({core})", name)]
        places: List[Tuple[Node, str]] = []
        for node in nodes if own else ():
            places += [(node, own[0]) for _ in get_operator(name)().mutation_positions(node)]
        for node in nodes if name == "fault/Fault" else ():
            places += [(node, kind) for kind, _ in faults(node)]
        for occurrence, (node, kind) in enumerate(places):
            if not is_hidden(node, kind, pure):
                function = node.search_ancestor("funcdef")
                where = function.name.value if function else ""
                line = lines[node.start_pos[0] - 1].strip()
                place = " ".join(f"{name}: {where}: {line}: {text_of(node)}".split())
                recipe = (module, name, occurrence)
                yield dict(module=module, kind=kind, place=place, recipe=recipe)


if __name__ == "__main__":
    asked = json.loads(sys.stdin.read())
    answer = [one for module, pure in asked.get("list", ()) for one in mutants_of(module, pure)]
    for module, name, occurrence in asked.get("make", ()):
        source = pathlib.Path(module).read_text("utf-8")
        answer.append(mutate_code(source, get_operator(name)(), occurrence))
    print(json.dumps(answer))
