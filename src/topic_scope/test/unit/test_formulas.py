"""Formulas: results, error texts, and that no text ever runs code."""

import ast
import math
import time
from typing import Callable, Dict, List

import numpy
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from topic_scope.formulas import parser
from topic_scope.formulas.names import expand, formula_of, terms, with_letters
from topic_scope.formulas.expression import Operands
from topic_scope.formulas.parser import FUNCTIONS, parse_formula
from topic_scope.formulas.signals import Signal
from topic_scope.formulas.lexer import LONGEST, FormulaError, text_of, tokens_of
from topic_scope.messages.fields import FieldError
from topic_scope.timing.nanoseconds import NS, array_to_ns, to_ns

TIMES = numpy.arange(0.0, 4.0, 0.01)


def signal(compute: Callable[[numpy.ndarray], numpy.ndarray], shift: float = 0.0) -> Signal:
    """Return samples of a function, taken each 10 ms."""
    times = TIMES + shift
    return Signal(array_to_ns(times), compute(times), array_to_ns(times + 0.5), 0.05)


X = signal(lambda t: 3.0 * numpy.sin(t))
Y = signal(lambda t: 4.0 * numpy.cos(t), 0.004)
SIGNALS = {"/p/x": X, "/p/y": Y}


def computed(text: str) -> Signal:
    return parse_formula(text).computed(SIGNALS)


#: Formulas with numpy's results for the same samples, y interpolated.
_Y = numpy.interp(X.times, Y.times, Y.values)
TRUTHS: Dict[str, numpy.ndarray] = {
    "/p/x - 2*/p/y": X.values - 2.0 * _Y,
    "sqrt(/p/x**2 + /p/y**2)": numpy.sqrt(X.values**2 + _Y**2),
    "deg(atan2(/p/x, /p/y))": numpy.degrees(numpy.arctan2(X.values, _Y)),
    "-/p/x + 1": 1.0 - X.values,
    "2 * /p/x / (/p/y)": 2.0 * X.values / _Y,
    "/p/x/2/4": X.values / 8.0,
    "/p/x%2 - -1": X.values % 2.0 + 1.0,
    "-/p/x**2": -(X.values**2),
    "2**3**2 * /p/x": 512.0 * X.values,
    "max(min(/p/x, .5), -5e-1)": numpy.clip(X.values, -0.5, 0.5),
    "hypot(/p/x,abs(/p/y))": numpy.hypot(X.values, _Y),
    "exp(log(/p/x + 4.)) - 10**log10(2)": X.values + 4.0 - 2.0,
    "rad(180)*/p/x - pi * /p/x": 0.0 * X.values,
    "asin(sin(/p/x/4)) + acos(cos(1)) + atan(tan(1))": X.values / 4.0 + 2.0,
    "floor(/p/x) + ceil(/p/x) + sign(/p/x)": numpy.floor(X.values)
    + numpy.ceil(X.values)
    + numpy.sign(X.values),
}


@pytest.mark.parametrize("text", TRUTHS)
def test_it_computes_what_numpy_does_at_the_stamps_of_its_first_operand(text: str) -> None:
    found = computed(text)
    known = numpy.isfinite(found.values)
    assert (
        found.times.tolist() == X.times.tolist() and found.received.tolist() == X.received.tolist()
    )
    # The second trace starts 4 ms later, so the first sample is before it.
    assert known[1:].all() and known[0] == ("/p/y" not in text)
    assert found.values[1:] == pytest.approx(TRUTHS[text][1:], abs=1e-9)


def test_the_first_operand_gives_the_stamps() -> None:
    assert computed("/p/y - /p/x").times.tolist() == Y.times.tolist()
    assert computed("2*/p/y + /p/x").times.tolist() == Y.times.tolist()
    assert parse_formula("/p/y + /p/x + /p/y").fields == ("/p/y", "/p/x")


def test_a_delay_moves_and_a_derivative_lies_in_the_middle() -> None:
    late = computed("delay(/p/x, 0.25)")
    assert (
        late.times == pytest.approx(X.times + NS // 4) and late.values.tolist() == X.values.tolist()
    )
    ahead = computed("/p/x - delay(/p/x, -0.25)")
    inside = ahead.times < 3.7 * NS
    truth = 3.0 * (numpy.sin(TIMES) - numpy.sin(TIMES + 0.25))
    assert ahead.values[inside] == pytest.approx(truth[inside], abs=1e-4)
    slope = computed("derivative(/p/x)")
    times = slope.times / NS
    assert times == pytest.approx(TIMES[:-1] + 0.005)
    assert slope.values == pytest.approx(3.0 * numpy.cos(times), abs=1e-4)


def operands() -> Operands:
    return Operands.of(SIGNALS)


@pytest.mark.parametrize(
    "text, until, lookaround",
    [
        ("/p/x - /p/y", 3.99, (0.05, 0.05)),
        ("delay(/p/y, 0.5)", 4.494, (0.5, -0.5)),
        ("delay(/p/x, -0.5) + /p/y", 3.49, (0.05, 0.5)),
        ("derivative(/p/x)", 3.985, (0.05, 0.05)),
        ("mean(/p/x, 2)", 3.99, (2.0, 0.0)),
        ("lowpass(/p/x, 1)", 3.99, (20.0 / (2.0 * math.pi), 0.0)),
        ("delay(mean(/p/x, 2), 1)", 4.99, (3.0, -1.0)),
        ("highest(/p/x, 0.5) - lowest(/p/y, 1)", 2.994, (1.1, 1.1)),
    ],
)
def test_up_to_when_it_is_known_and_what_it_needs(
    text: str, until: float, lookaround: List[float]
) -> None:
    tree = parse_formula(text).tree
    assert tree.until(operands()) / NS == pytest.approx(until)
    assert tree.lookaround(operands()) == pytest.approx(lookaround)


SPANS = st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 1.0))


@given(
    st.sampled_from(
        [
            "/p/x - delay(/p/y, 0.3)",
            "/p/x - highest(/p/y, 0.2)",
            "lowest(/p/y, 0.2)",
            "mean(/p/x, 0.5)",
            "derivative(/p/y) - /p/x",
            *list(TRUTHS)[:3],
        ]
    ),
    SPANS,
)
@settings(max_examples=30, deadline=None)
def test_a_part_of_it_is_the_same_as_that_part_of_all(text: str, span: List[float]) -> None:
    tree = parse_formula(text).tree
    start, end = to_ns(span[0]), to_ns(span[0] + span[1])
    part = tree.signal(operands(), start, end).between(start, end)
    whole = tree.signal(operands(), to_ns(-math.inf), to_ns(math.inf)).between(start, end)
    assert part.times.tolist() == whole.times.tolist()
    assert numpy.nan_to_num(part.values) == pytest.approx(numpy.nan_to_num(whole.values), abs=1e-9)


# --- Errors ---------------------------------------------------------------------------------------

SENTENCES = {
    "": "the formula is empty",
    "/a +": "unexpected end of the formula",
    "sqrt(/a": 'missing ")"',
    "/a)": 'unmatched ")"',
    "1 + 2": "a formula needs at least one field, such as /topic/field",
    "/a, /b": "unexpected comma; it separates arguments of a function, decimals need a point",
    "1,5*/a": "unexpected comma; it separates arguments of a function, decimals need a point",
    "/a^2": "a power is written with **, not with ^",
    "/a 2": "at '2': expected + - * / % ** or a bracket",
    "/a(/b)": "at '(/b)': expected + - * / % ** or a bracket",
    "* /a": "at '* /a': expected a field, a number or a function",
    "2/a + 1": "unknown name a; the name of a field begins with /",
    "sin + /a": "sin needs its arguments in brackets",
    "foo(/a)": f"unknown function foo; known are {', '.join(FUNCTIONS)}",
    "sqrt(/a, 2)": "sqrt takes 1 argument",
    "atan2(/a)": "atan2 takes 2 arguments",
    "delay(2, 1)": "delay takes a trace, not a number",
    "delay(/a, /b)": "delay: the second argument must be a time in s, from -600 to 600",
    "delay(/a, 1e9)": "delay: the second argument must be a time in s, from -600 to 600",
    "mean(/a, 0)": "mean: the second argument must be a time in s, from 1e-06 to 600",
    "lowpass(/a, 0)": "lowpass: the second argument must be a frequency in Hz, from 0.02 to 1e+06",
    "delay(delay(/a, 600), 1)": "delays, means and filters reach over 601 s: at most 600",
    "delay(delay(/a, -600), -1)": "delays, means and filters reach over 601 s: at most 600",
    "highest(delay(/a, -599), 2)": "delays, means and filters reach over 601 s: at most 600",
    "/a + 2**2**2**2**2**2": "a constant is infinite or not a number",
    "/a + 0/0": "a constant is infinite or not a number",
    "/a + " + "9" * 400: "a constant is infinite or not a number",
    "/a" + " + /a" * 60: "a formula has at most 100 tokens, not 121",
    "(" * 21 + "/a" + ")" * 21: "brackets are nested too deeply (at most 20)",
    "-" * 30 + "/a": "operations are nested too deeply (at most 24)",
    "1" + "**1" * 30 + "*/a": "operations are nested too deeply (at most 24)",
    "/a" + " " * LONGEST: "a formula has at most 500 characters, not 502",
    "+".join(f"/t{index}" for index in range(9)): "a formula has at most 8 fields, not 9",
    "+".join(["derivative(/a)"] * 9): "a formula has at most 8 delays, filters and derivatives",
}


@pytest.mark.parametrize("text", SENTENCES)
def test_error_texts(text: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse_formula(text)
    assert str(caught.value) == SENTENCES[text]


@pytest.mark.parametrize(
    "text",
    [
        "delay(/a, 600)",
        "-" + "/a*(" * 20 + "1" + ")" * 20,
        "-" * 24 + "/a",
        "/a" + " " * (LONGEST - 2),
        "sin (/a)",
    ],
)
def test_formulas_at_the_limits_are_valid(text: str) -> None:
    assert parse_formula(text).fields == ("/a",)


@pytest.mark.parametrize(
    "text",
    [
        "mean(/p/x, 1)",
        "lowpass(/p/x, 5)",
        "delay(/p/x, 0.3)",
        "delay(/p/x, -0.3)",
        "/p/x - delay(/p/y, 0.3)",
        "/p/x - derivative(/p/y)",
        "/p/x - highest(/p/y, 0.3)",
    ],
)
def test_part_of_a_formula_has_the_values_of_the_whole(text: str) -> None:
    start, end = 2 * NS, 3 * NS
    part = parse_formula(text).tree.signal(Operands.of(SIGNALS), start, end).between(start, end)
    whole = computed(text).between(start, end)
    assert part.times.tolist() == whole.times.tolist()
    assert part.values == pytest.approx(whole.values, abs=1e-6)


def test_as_many_tokens_as_the_limit_are_valid() -> None:
    assert len(tokens_of("-/a" + " + /a" * 49)) == 100


ATTACKS = [
    "__import__('os').system('id')*/a",
    "().__class__.__bases__[0].__subclasses__()",
    "/a.__class__",
    "/a if 1 else /b",
    "[x for x in /a]",
    "lambda: /a",
    "{/a}",
    "/a[0].real()",
    "/a[-1]",
    "f'{/a}'",
    "'a'*10**9 + /a",
    "eval(/a)",
    "open(/a)",
    "sqrt.__globals__(/a)",
    "sqrt(x=/a)",
    "sqrt(*/a)",
    "sqrt(**/a)",
    "(/a := 1)",
    "/a and /b",
    "not /a",
    "~/a",
    "/a << 99999",
    "1 << 99999 * /a",
    "/a == /a",
    "1_000*/a",
    "0x10*/a",
    "1j*/a",
    "1e5j*/a",
    "True*/a",
    "None",
    "...",
    "/a;import os",
    "/a\nimport os",
    "/a # x",
    "/a\\",
    "/a\x00",
    "ﬁeld*/a",  # characters that Python normalises
    "_0*/a",
    "_1*/a",
    "_*/a",
    "__*/a",
    "await /a",
    "/a @ /b",
    "/a // 2",
    "print(/a)",
]


@pytest.mark.parametrize("text", ATTACKS)
def test_nothing_else_of_python_is_read(text: str) -> None:
    with pytest.raises(FormulaError):
        parse_formula(text)


FRAGMENTS = st.lists(
    st.sampled_from(
        [
            *"()+-*/%,.0123456789 '\"[]{}:;=@~|&^!<>\\#_",
            "**",
            "/a",
            "/b/c[0]",
            "sqrt",
            "delay",
            "mean",
        ]
        + [
            "lambda ",
            "__import__",
            ".__class__",
            "pi",
            "a",
            "1e999",
            "lowpass(",
            "if",
            "else",
            "\n",
        ]
    ),
    max_size=40,
).map("".join)


@given(st.one_of(FRAGMENTS, st.text(max_size=60)))
@example("(" * 500)
@example("-" * 499 + "1")
@example("9" * 500)
@example("-/a*.5**sqrt(/b/c[0])")
@settings(max_examples=80, deadline=None)
def test_any_text_is_parsed_or_rejected_and_only_listed_nodes_are_used(text: str) -> None:
    try:
        formula = parse_formula(text)
    except FieldError as error:
        assert str(error)
        return
    plain = "".join("_f" if word.kind == "field" else word.text for word in formula.tokens)
    node_types = {type(node) for node in ast.walk(ast.parse(plain, mode="eval"))}
    allowed = {ast.Expression, ast.BinOp, ast.UnaryOp, ast.Call, ast.Name, ast.Load, ast.Constant}
    assert node_types <= allowed | set(parser._OPERATIONS)
    again = parse_formula(formula.text())
    assert again.tokens == formula.tokens and again.fields == formula.fields


def test_the_costliest_formula_is_computed_in_bounded_time() -> None:
    times = array_to_ns(numpy.arange(0.0, 60.0, 0.001))
    noise = numpy.random.default_rng(1).normal(size=len(times))
    signals = {"/a": Signal(times, noise, times, 0.01)}
    text = "+".join(["lowpass(/a, 0.02)"] * 8 + ["/a**2**.5"] * 7)
    began = time.process_time()
    found = parse_formula(text).computed(signals)
    assert time.process_time() - began < 5.0  # it takes about 0.1
    assert len(found.values) == 60000


# --- Names ----------------------------------------------------------------------------------------


def test_names_of_formulas_are_written_in_one_way() -> None:
    assert expand("=/a/x-2*/b/y") == ["=/a/x - 2 * /b/y"]
    assert expand(" = ( /a.derivative@stamp )/-2 ** -1") == ["=(/a.derivative@stamp) / -2**-1"]
    assert expand("=deg(atan2(/p/y,/p/x))") == ["=deg(atan2(/p/y, /p/x))"]
    assert expand("=max(/a/x,-1)") == ["=max(/a/x, -1)"]
    assert terms("=/a/x - 2 * /b[arm-1]/y + /a/x") == ("/a/x", "/b[arm-1]/y")
    assert terms("/a/x-/b/y") == ("/a/x", "/b/y") and terms("/a/x.yaw") == ("/a/x.yaw",)
    assert formula_of("/a/x") is None
    for wrong in ("=", "=/a/x:y", "=/a.eval", "=/a +", "=1"):
        with pytest.raises(FieldError):
            expand(wrong)


def test_letters_are_replaced_by_traces_and_formulas() -> None:
    traces = ["/s/y", "=/u + 1", "/u-/v"]
    assert with_letters("=a - 2*b", traces) == "=/s/y - 2 * (/u + 1)"
    assert with_letters("=sqrt(c)/a", traces) == "=sqrt((/u - /v)) / /s/y"
    assert parse_formula(with_letters("=sqrt(c)/a", traces)[1:]).fields == ("/u", "/v", "/s/y")
    for text, sentence in (
        ("=d", "no trace d: there are a to c"),
        ("=a +", "unexpected end of the formula"),
    ):
        with pytest.raises(FormulaError, match=sentence):
            with_letters(text, traces)
    with pytest.raises(FormulaError, match="none has been chosen"):
        with_letters("=a", [])
    with pytest.raises(FormulaError, match="there is a"):
        with_letters("=b", ["/s/y"])
    with pytest.raises(FormulaError, match="there are a to z"):
        with_letters("=B", ["/s/y"] * 30)


@settings(max_examples=30)
@given(st.sampled_from([*TRUTHS, "delay(/p/x,-.5)", "a - 2*b"]))
def test_written_formula_is_parsed_as_the_same(text: str) -> None:
    words = tokens_of(text)
    assert tokens_of(text_of(words)) == words
