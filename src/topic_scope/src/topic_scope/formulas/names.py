"""Names of traces: fields, formulas and differences, and the fields that each needs.

``=/a/x - 2*/b/y`` is computed by a formula, see :mod:`.parser`; so is the difference
``/a/x-/b/y``, which needs no ``=``. Everything else is the name of a field.
"""

import re
from functools import lru_cache
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from topic_scope.formulas.parser import Formula, parse_formula
from topic_scope.formulas.lexer import FormulaError, Token, text_of, tokens_of
from topic_scope.messages import fields
from topic_scope.messages.field_functions import STATE
from topic_scope.messages.fields import FieldError

_MARK = "="
#: Two fields with a minus between them, which may be in quotes and brackets, too.
_DIFFERENCE = re.compile(r'((?:"[^"]*"|\[[^]]*\]|[^"[])*?)-("?/.*)')


def is_formula(text: str) -> bool:
    """Return whether a name is written as a formula."""
    return text.lstrip().startswith(_MARK)


@lru_cache(maxsize=256)
def formula_of(name: str) -> Optional[Formula]:
    """Return the formula of a trace; None for a field or an invalid name.

    :param name: a name that :func:`expand` has returned or rejected
    """
    if problem_of(name):
        return None
    if is_formula(name):
        return parse_formula(name.lstrip()[1:])
    difference = _DIFFERENCE.fullmatch(name)
    return parse_formula(" - ".join(difference.groups())) if difference else None


@lru_cache(maxsize=256)
def is_state(name: str) -> bool:
    """Return whether a trace is a state: a text, or a number with named values.

    :param name: a name that :func:`expand` has returned or rejected
    """
    return problem_of(name) is None and formula_of(name) is None and fields.parted(name)[1] == STATE


def terms(name: str) -> Tuple[str, ...]:
    """Return the fields that a trace is computed from; for a field, its name."""
    formula = formula_of(name)
    return formula.fields if formula else (name,)


def expand(name: str) -> List[str]:
    """Return the trace names that an argument denotes.

    :param name: of a field, as for :func:`.fields.expand`, or of a computed trace
    :returns: global names; a single name for a computed trace
    :raises FieldError: if the name is invalid, or a field of a formula denotes several
    """
    return expand_with(name, fields.expand)


@lru_cache(maxsize=256)
def problem_of(name: str) -> Optional[str]:
    """Return why a text is not a valid trace name; None if it is valid."""
    try:
        expand(name)
    except FieldError as error:
        return str(error)
    return None


def expand_with(name: str, resolve: Callable[[str], List[str]]) -> List[str]:
    """Return the trace names that a name denotes.

    :param name: as for :func:`expand`
    :param resolve: returns the names that a field name denotes
    :raises FieldError: as raised by ``resolve``, or if a field of a formula denotes several
    """
    if is_formula(name):
        formula = parse_formula(name.lstrip()[1:])
        return [_MARK + formula.text(lambda field: _one(resolve(field)))]
    difference = _DIFFERENCE.fullmatch(name)
    if not difference:
        return resolve(name)
    sides = [_one(resolve(part)) for part in difference.groups()]
    for side in sides:
        if not fields.FIELD.fullmatch(side):
            raise FieldError(
                f'{side}: a topic with a hyphen needs quotes in a formula: "/a-b"/field'
            )
    return ["-".join(sides)]


def with_letters(text: str, traces: Sequence[str]) -> str:
    """Return a formula with its letters replaced by names of traces.

    :param text: the formula as it was typed
    :param traces: the traces ``a``, ``b``, ``c`` and so on: fields or computed traces
    :raises FormulaError: if it has other letters, or is not a formula
    """
    letters: Dict[str, Sequence[Token]] = {}
    for letter, name in zip("abcdefghijklmnopqrstuvwxyz", traces):
        formula = formula_of(name)
        inner = [Token("field", name)] if formula is None else list(formula.tokens)
        letters[letter] = inner if formula is None else [Token("(", "("), *inner, Token(")", ")")]
    tokens: List[Token] = []
    for token in tokens_of(text.lstrip()[1:]):
        if token.kind == "name" and len(token.text) == 1 and token.text not in letters:
            raise FormulaError(f"no trace {token.text}: {_known(traces)}")
        is_letter = token.kind == "name" and token.text in letters
        tokens += letters[token.text] if is_letter else [token]
    return _MARK + text_of(tokens)


def _known(traces: Sequence[str]) -> str:
    if not traces:
        return "none has been chosen; the name of a field begins with /"
    last = "abcdefghijklmnopqrstuvwxyz"[min(len(traces), 26) - 1]
    return "there is a" if last == "a" else f"there are a to {last}"


def _one(names: List[str]) -> str:
    if len(names) != 1:
        raise FieldError("a formula takes single fields, but one of these names denotes several")
    if fields.parted(names[0])[1] == STATE:
        raise FieldError(f"{names[0]} is a state: formulas and differences take numbers")
    return names[0]
