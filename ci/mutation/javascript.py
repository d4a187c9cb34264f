"""Mutants of the page's scripts, created from their text, because cosmic-ray cannot parse them."""

import re
from typing import Any, Dict, Iterator, Tuple

#: Comments and texts, which are not changed.
TEXTS = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`", re.DOTALL
)
#: Pairs that replace each other, in code with spaces around operators.
PAIRS = (
    ("operator", r"(?<= )\+(?= )", "+", r"(?<= )-(?= )", "-"),
    ("operator", r"(?<= )\*(?= )", "*", r"(?<= )/(?= )", "/"),
    ("comparison", r"(?<= )<(?= )", "<", r"(?<= )<=(?= )", "<="),
    ("comparison", r"(?<= )>(?= )", ">", r"(?<= )>=(?= )", ">="),
    ("comparison", r"===", "===", r"!==", "!=="),
    ("condition", r"&&", "&&", r"\|\|", "||"),
    ("constant", r"\btrue\b", "true", r"\bfalse\b", "false"),
    ("constant", r"(?<![\w.])0(?![\w.])", "0", r"(?<![\w.])1(?![\w.])", "1"),
    ("min for max", r"(?<=Math\.)min\b", "min", r"(?<=Math\.)max\b", "max"),
    ("first for last", r"(?<=[\w\])])\[0\](?! = )", "[0]", r"\.at\(-1\)", ".at(-1)"),
)
#: A statement on a separate line: a call, or an assignment to a member.
STATEMENT = re.compile(
    r"(?<=[;{}\"]\n) +(?!return\b|throw\b|super\b)([\w.?]+)(\([^{\n]*\)| [-+*]?= .*);$",
    re.MULTILINE,
)
CLOSING = re.compile(r"(^|\.)(close|remove|cancel|stop|release|forget|disconnect|clear|un)\w*$")
IDEMPOTENT = re.compile(r"(^|\.)(set|show|refresh|draw|hide|toggle|fit|place|update)\w*$")
#: A call with first two arguments without brackets.
CALL = re.compile(r"(?<=\w)\((?P<first>[^(){}\[\],=]+), (?P<second>[^(){}\[\],=]+)(?=[,)])")


def edits(text: str) -> Iterator[Tuple[str, int, int, str]]:
    """Return type, begin, end and new text of all changes of a script."""
    code = TEXTS.sub(lambda match: re.sub(r"[^\n]", '"', match[0]), text)
    for kind, one, one_text, other, other_text in PAIRS:
        for pattern, new in ((one, other_text), (other, one_text)):
            for match in re.finditer(pattern, code):
                yield kind, match.start(), match.end(), new
    for match in CALL.finditer(code):
        first, second = text[slice(*match.span("first"))], text[slice(*match.span("second"))]
        yield "swapped arguments", match.start("first"), match.end(), f"{second}, {first}"
    for match in STATEMENT.finditer(code):
        begin, end, target = match.start(1), match.end(), match[1]
        if match[2][0] != "(":
            yield "stale value", begin, end, ";"
        elif CLOSING.search(target):
            yield "missing close", begin, end, ";"
        elif match[2].count("(") == match[2].count(")"):
            yield "dropped statement", begin, end, ";"
            if not IDEMPOTENT.search(target):
                yield "effect twice", begin, end, f"{text[begin:end]} {text[begin:end]}"


def listed(module: str, text: str) -> Iterator[Dict[str, Any]]:
    """Return all mutants of a script, as cosmic.py lists those of a module, with their texts."""
    lines = text.splitlines()
    for kind, begin, end, new in edits(text):
        place = f"{lines[text.count(chr(10), 0, begin)].strip()}: {text[begin:end]} {new}"
        made = text[:begin] + new + text[end:]
        yield dict(module=module, kind=kind, place=place, made=made)
