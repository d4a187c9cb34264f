"""Tests of writing and reading model files."""

import math

import pytest

from pid_control.identification.fit import identify
from pid_control.identification.model_file import ModelError, as_yaml, read_model
from pid_control.identification.response import Model
from pid_control.plant.system_parameters import SystemParameters
from plants import recorded


def test_saved_model_is_loaded_by_the_node() -> None:
    found = identify(recorded(Model(13.1, 0.04, 0.01, 0.1, 9.0)))
    text = as_yaml(found, "a\nrecord")
    assert text.startswith("# Identified from a record.\n")
    found = found._replace(test=found.test._replace(is_noise=False, follows_input=True))
    doubts = [line for line in as_yaml(found, "").splitlines() if line.startswith("# +- ")]
    start = "# +- does not hold in 95 of 100: the residual"
    assert doubts == [
        f"{start} follows the input, so the model lacks a term.",
        f"{start} is not noise.",
    ]
    for one, other in zip(read_model(text), found.model):
        assert one == pytest.approx(other, rel=1e-5)
    values = {name: float(value) for name, value in _pairs(text)}
    assert SystemParameters(**values).system_dead_time == pytest.approx(0.01, rel=1e-4)


def test_model_file_unreached_limit_is_unlimited() -> None:
    text = as_yaml(identify(recorded(Model(2.0, 1.0))), "a record")
    assert "system_max_speed: 1000000000.0  # not met" in text
    assert "system_min_input: 0.0  # not met" in text
    SystemParameters(**{name: float(value) for name, value in _pairs(text)})
    assert read_model(text).limit == math.inf


def _pairs(text: str) -> list:
    lines = [line.partition("#")[0] for line in text.splitlines()]
    return [line.split(": ") for line in lines if line]


@pytest.mark.parametrize(
    "text, why",
    [
        ("[1, 2]", "not a mapping of names to values"),
        ("system_param_T: 1", "system_param_K is missing"),
        ("system_param_K: 1", "system_param_T is missing"),
        ("{system_param_K: 1, system_param_T: -1}", "system_param_T must be above 0: -1"),
        (
            "{system_param_K: 1, system_param_T: 1, system_min_input: -0.1}",
            "system_min_input must be at least 0: -0.1",
        ),
        ("{system_param_K: x, system_param_T: 1}", "system_param_K must be a number: 'x'"),
        ("{system_param_K: true, system_param_T: 1}", "system_param_K must be a number: True"),
        ("{system_param_K: .nan, system_param_T: 1}", "system_param_K must be a number: nan"),
        ("{system_param_K: 0, system_param_T: 1}", "system_param_K must not be 0"),
        ("{system_param_K: 1, system_param_T: 0}", "system_param_T must be above 0: 0"),
        (
            "{system_param_K: 1, system_param_T: 1, system_dead_time: -1}",
            "system_dead_time must be at least 0: -1",
        ),
        (
            "{system_param_K: 1, system_param_T: 1, system_max_speed: 0}",
            "system_max_speed must be above 0: 0",
        ),
    ],
)
def test_read_model_invalid_text_names_the_problem(text: str, why: str) -> None:
    with pytest.raises(ModelError) as error:
        read_model(text)
    assert str(error.value) == why


def test_read_model_text_that_is_not_yaml_is_refused_on_one_line() -> None:
    with pytest.raises(ModelError, match="^while parsing .* line 2, column 1.*$"):
        read_model("a: [\n")


def test_read_model_takes_each_value_and_limits_that_are_reached() -> None:
    assert read_model("{system_param_K: -2, system_param_T: 1}") == Model(-2.0, 1.0)
    text = "{system_param_K: 1, system_param_T: 2, system_dead_time: 3, system_min_input: 4, "
    assert read_model(text + "system_max_speed: 5, a: b}") == Model(1.0, 2.0, 3.0, 4.0, 5.0)
    zeros = "{system_param_K: 1, system_param_T: 2, system_dead_time: 0, system_min_input: 0, "
    assert read_model(zeros + "system_max_speed: 1.0e+9}") == Model(1.0, 2.0)
