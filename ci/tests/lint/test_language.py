"""Tests of the check of words: each type of breach, and plain text."""

import pytest

from ci.lint import language


@pytest.mark.parametrize(
    "text",
    ["a number that is none", "somebody", "told to Nobody", "whoever asks", "built anew"],
)
def test_words_private_word_is_found_in_its_line(text: str) -> None:
    assert [line for line, _ in language.words("a\n# " + text + "\n")] == [2]


@pytest.mark.parametrize("text", ["if value is None:", "a new one", "no body", "none is left"])
def test_words_plain_text_is_accepted(text: str) -> None:
    assert list(language.words(text)) == []


@pytest.mark.parametrize("opening", ["What a node makes.", "Whose it is.", "How long it takes."])
def test_openings_question_word_is_found(opening: str) -> None:
    for text in f'"""{opening}"""\n', f'def f():\n    """{opening}"""\n':
        assert len(list(language.openings(text))) == 1


def test_openings_noun_phrase_is_accepted() -> None:
    assert list(language.openings('"""Whole numbers."""\n\nclass A:\n    """Clock."""\n')) == []


def test_judges_only_the_command_is_accepted() -> None:
    assert list(language.judges("rosrun pid_control judge x\n")) == []
    assert len(list(language.judges("def judge_name(): ...\n"))) == 1
