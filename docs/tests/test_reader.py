"""The reader of tutorials does what a page says, and notices what is wrong on it."""

import re
from pathlib import Path

import pytest
from reader import PageError, Reader

TERMINAL = "```{code-block} console\n:caption: Terminal 1\n\n%s\n```\n"
CONSOLE = "```console\n%s\n```\n"


def assert_wrong(page: str, reason: str) -> None:
    with Reader(timeout=2.0, limit=6.0) as reader, pytest.raises(PageError, match=reason):
        reader.follow(page)


def test_the_right_page_is_followed_to_its_end() -> None:
    waits = "$ trap 'echo bye; exit' INT; echo hi; touch ~/x; while true; do sleep 0.1; done\nhi"
    page = TERMINAL % waits + CONSOLE % "$ ls ~/x\n.../x" + TERMINAL % "^C\nbye"
    with Reader() as reader:
        assert reader.follow(page) == 3


def test_the_home_directory_of_whoever_runs_the_tests_is_left_alone() -> None:
    with Reader() as reader:
        reader.follow(CONSOLE % "$ touch ~/of_the_reader")
    assert not (Path.home() / "of_the_reader").exists()


def test_a_terminal_is_watched_from_where_it_was_last_looked_at() -> None:
    page = TERMINAL % "$ echo a; echo b; echo c\nb" + TERMINAL % "c"
    with Reader() as reader:
        assert reader.follow(page) == 2
    assert_wrong(page + TERMINAL % "a", "line 15: Terminal 1")


def test_a_command_is_run_again_until_it_shows_what_the_page_says() -> None:
    page = TERMINAL % "$ sleep 0.3; touch ~/late" + CONSOLE % "$ ls ~/late\n...late"
    with Reader() as reader:
        assert reader.follow(page) == 2


def test_a_failure_is_fine_where_it_is_shown() -> None:
    with Reader() as reader:
        assert reader.follow(CONSOLE % "$ echo no; false\nno") == 1
    assert_wrong(CONSOLE % "$ false", "status 1")
    assert_wrong(CONSOLE % "$ echo no", "status 0")


@pytest.mark.parametrize("shown", ["a", "a\nb\nc", "b\na", ""])
def test_output_other_than_shown_is_wrong(shown: str) -> None:
    assert_wrong(CONSOLE % ("$ echo a; echo b\n" + shown), "seen:\na\nb")


def test_a_command_that_does_not_end_is_wrong() -> None:
    assert_wrong(CONSOLE % "$ exec sleep 60", "line 2: exec sleep 60\nthe page takes longer")


def test_a_page_that_takes_too_long_is_wrong() -> None:
    reason = "line 4: Terminal 1\nthe page takes longer than 0 s"
    with Reader(limit=0.0) as reader, pytest.raises(PageError, match=reason):
        reader.follow(TERMINAL % "a")


def test_a_line_that_a_terminal_never_prints_is_wrong() -> None:
    assert_wrong(TERMINAL % "$ echo a; exec sleep 60\nb", re.escape("line 4: echo a"))
    assert_wrong(TERMINAL % "$ echo a\nb", "status 0")


def test_a_terminal_takes_one_command_at_a_time() -> None:
    with Reader() as reader:
        assert reader.follow(TERMINAL % "$ sleep 0.1" + TERMINAL % "$ echo b\nb") == 2
    assert_wrong(TERMINAL % "$ exec sleep 60" + TERMINAL % "$ echo b", "is busy")


def test_interrupting_what_has_ended_or_never_began_is_wrong() -> None:
    assert_wrong(
        TERMINAL % "$ echo $$ >~/pid; echo done\ndone"
        + CONSOLE % "$ while grep -qs ') [^Z]' /proc/$(cat ~/pid)/stat; do sleep 0.05; done"
        + TERMINAL % "^C",
        "ended",
    )
    assert_wrong(TERMINAL % "^C", "nothing was started")
    assert_wrong(CONSOLE % "^C", "outside of a terminal")
