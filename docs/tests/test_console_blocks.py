"""Consoles on pages: what is typed, and what counts as the output that is shown."""

import pytest
from console_blocks import Instruction, find, instructions_of, is_all, plain


PAGE = """\
# Title

```console
$ one
shown

last
$ two

```

```sh
$ not a console
```

```{code-block} console
:caption: Terminal 2

$ stays --open
started
```

```console
```

```{code-block} console
:caption: Terminal 2

printed later
^C
bye
```

$ not in a block
"""


def test_steps_come_in_the_order_of_the_page() -> None:
    assert instructions_of(PAGE) == [
        Instruction(4, "one", None, ["shown", "", "last"]),
        Instruction(8, "two", None, []),
        Instruction(19, "stays --open", "Terminal 2", ["started"]),
        Instruction(29, None, "Terminal 2", ["printed later"]),
        Instruction(30, "^C", "Terminal 2", ["bye"]),
    ]


@pytest.mark.parametrize(
    "expected, output",
    [
        ([], ""),
        ([], "\n"),
        (["a", "b"], "a\nb\n"),
        (["a"], "a"),
        (["a..."], "abc\n"),
        (["...c", "d"], "abc  \nd\n"),
        (["a", "...", "z"], "a\nb\nc\nz\n"),
        (["a", "...", "z"], "a\nz\n"),
        (["a", "", "b"], "a\n\nb\n\n"),
        (["(1+1)*2"], "(1+1)*2\n"),
    ],
)
def test_all_of_the_output_is_as_shown(expected: list, output: str) -> None:
    assert is_all(expected, output)


@pytest.mark.parametrize(
    "expected, output",
    [
        ([], "a\n"),
        (["a"], ""),
        (["a"], "a\nb\n"),
        (["b"], "a\nb\n"),
        (["a", "b"], "b\na\n"),
        (["a"], "ab\n"),
        (["a...c"], "ab\nc\n"),
        (["a", "...", "z"], "a\nz\nb\n"),
        (["1.5"], "125\n"),
    ],
)
def test_some_of_the_output_is_not_as_shown(expected: list, output: str) -> None:
    assert not is_all(expected, output)


def test_lines_are_found_among_others_in_their_order() -> None:
    output = "a\nb 1\nc\nb 2\n"
    assert find(["b ..."], output) == len("a\nb 1")
    assert find(["c", "...", "b ..."], output) == len(output) - 1
    assert find(["b ..."], output, start=len("a\nb 1\n")) == len(output) - 1
    assert find(["c", "a"], output) is None
    assert find(["b"], output) is None
    assert find([], output, start=3) == 3


def test_escape_codes_are_no_text() -> None:
    assert plain("\x1b]2;title\x07\x1b[1mbold\x1b[0m\r\n") == "bold\n"
