"""Lexer of formulas: field names, numbers, functions, operators, brackets.

Only the tokens listed here reach the parser: no quotes except around a topic, no dots except in
numbers and fields, no square or curly brackets, no lambda. A ``/`` starts a field name where an
operand is expected, and is a division everywhere else.
"""

import re
from typing import List, NamedTuple, Sequence

from topic_scope.messages.fields import FIELD, FieldError

#: Most characters and tokens of a formula, and how deep its brackets may be nested.
LONGEST, TOKENS, BRACKETS = 500, 100, 20

_NUMBER = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.])", re.ASCII)
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_OPERATOR = re.compile(r"\*\*|[-+*/%]")


class FormulaError(FieldError):
    """Invalid formula; the text states the reason."""


class Token(NamedTuple):
    """Token of a formula.

    :param kind: ``field``, ``number``, ``name``, ``operator``, or the character itself
    :param text: as it was typed
    """

    kind: str
    text: str


def tokens_of(text: str) -> List[Token]:
    """Split a formula into tokens.

    :param text: the formula, without the ``=`` before it
    :raises FormulaError: if the formula is too long, or contains an unexpected character
    """
    if len(text) > LONGEST:
        raise FormulaError(f"a formula has at most {LONGEST} characters, not {len(text)}")
    tokens: List[Token] = []
    place, depth, operand = 0, 0, True  # operand: an operand is expected here
    while place < len(text):
        if text[place] == " ":
            place += 1
            continue
        token = _operand_at(text, place) if operand else _other_at(text, place)
        depth += {"(": 1, ")": -1}.get(token.kind, 0)
        if depth < 0:
            raise FormulaError('unmatched ")"')
        if depth > BRACKETS:
            raise FormulaError(f"brackets are nested too deeply (at most {BRACKETS})")
        tokens.append(token)
        place += len(token.text)
        is_function = token.kind == "name" and text[place:].lstrip(" ").startswith("(")
        operand = is_function or token.kind in ("(", ",", "operator")
    if len(tokens) > TOKENS:
        raise FormulaError(f"a formula has at most {TOKENS} tokens, not {len(tokens)}")
    if operand:
        raise FormulaError("unexpected end of the formula" if tokens else "the formula is empty")
    if depth:
        raise FormulaError('missing ")"')
    return tokens


def text_of(tokens: Sequence[Token]) -> str:
    """Return tokens as a formula, with spaces for legibility."""
    parts: List[str] = []
    before = Token("(", "(")
    for token in tokens:
        is_sign = token.kind == "operator" and before.kind in ("(", ",", "operator")
        if token.text == "**":
            parts.append("**")
        elif token.kind == "operator" and not is_sign:
            parts.append(f" {token.text} ")
        else:
            parts.append(token.text + (" " if token.kind == "," else ""))
        before = token
    return "".join(parts)


def _operand_at(text: str, place: int) -> Token:
    for kind, pattern in (("field", FIELD), ("number", _NUMBER), ("name", _NAME)):
        match = pattern.match(text, place)
        if match:
            return Token(kind, match.group())
    if text[place] in "+-":
        return Token("operator", text[place])
    if text[place] == "(":
        return Token("(", "(")
    raise FormulaError(f"{_shown(text, place)}: expected a field, a number or a function")


def _other_at(text: str, place: int) -> Token:
    match = _OPERATOR.match(text, place)
    if match:
        return Token("operator", match.group())
    if text[place] in "),":
        return Token(text[place], text[place])
    if text[place] == "^":
        raise FormulaError("a power is written with **, not with ^")
    raise FormulaError(f"{_shown(text, place)}: expected + - * / % ** or a bracket")


def _shown(text: str, place: int) -> str:
    more = "…" if len(text) > place + 12 else ""
    return f"at {text[place : place + 12]!r}{more}"
