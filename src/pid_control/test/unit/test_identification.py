"""Tests of the identification of known plants, and of records that are not usable."""

import math
import xml.etree.ElementTree
from typing import Dict, List, Optional, Tuple
from unittest import mock

import numpy
import pytest

from pid_control.identification import fit
from pid_control.identification.fit import Identification, identify
from pid_control.identification.model_file import as_yaml
from pid_control.identification.record import IdentificationError, Record, record_of
from pid_control.identification.report import as_picture, as_text
from pid_control.identification.residual_test import ResidualTest
from pid_control.identification.response import Model
from pid_control.identification.step_reading import StepReading, read_step, why_they_differ
from plants import answered, check_random_plants, errors_of, recorded

NOISE = 0.05
VALUES = numpy.array([1.0, 2.0, 4.0])
HELD = ([0.5, 1.0, 2.5], [0.3, 0.7, 0.7])
SLOW = Model(2.0, 1.0)
RECORD = answered([(2.0, 0.5)], Model(13.1, 0.4, 0.1), 6.0)._replace(left_out=3)
WIDE = Model(1.1, 0.12, 0.013, 0.014, 0.15, 1.6, 0.017)
#: An identification with each term, which not all residuals confirm.
FOUND = Identification(
    Model(10.0, 0.5, 0.1, 0.2, 9.0, 20.0, 0.05),
    WIDE,
    RECORD.outputs,
    0.1 * RECORD.span,
    0.9,
    ResidualTest(False, True, False, False, 12.0),
)
#: One without a term, whose input was recorded late.
PLAIN = FOUND._replace(
    model=Model(10.0, 0.5, -0.2),
    uncertainty=WIDE._replace(dead_zone=math.inf, limit=math.inf),
    test=ResidualTest(True, True, False, True, 99.0),
)


@pytest.mark.extended
@pytest.mark.parametrize("noise, most", [(0.0, 0.01), (NOISE, 0.05)])
def test_each_value_of_random_plants_is_found(noise: float, most: float) -> None:
    """Of 10 plants, half without noise; ci/soak counts the larger draw."""
    check_random_plants(5, noise, most, covered=0.8)


@pytest.mark.extended
def test_identify_without_dead_zone_or_limit_finds_neither() -> None:
    for seed in range(2):
        found = identify(recorded(SLOW, NOISE, seed))
        assert found.model.dead_zone == 0.0
        assert found.model.limit == math.inf
        assert found.uncertainty.dead_zone == found.uncertainty.limit == math.inf


def test_one_manual_step_is_enough_for_gain_time_constant_and_dead_time() -> None:
    record = answered([(2.0, 0.5)], Model(13.1, 0.4, 0.1), 6.0)
    assert record.inputs.tolist() == [0.0, 0.5]
    found = identify(record)
    assert errors_of(Model(13.1, 0.4, 0.1, 1.0, 1.0), found.model)[:3].max() < 1e-5
    reading = read_step(record)
    assert reading is not None
    assert reading.gain == pytest.approx(13.1, rel=0.01)
    assert reading.time_constant == pytest.approx(0.5, rel=0.02)


@pytest.mark.extended
def test_uncertainty_grows_with_correlated_residuals() -> None:
    clean = identify(recorded(SLOW, 0.02, outputs=1000))
    record = recorded(SLOW, outputs=1000)
    hum = 0.02 * math.sqrt(2.0) * record.span * numpy.sin(0.2 * numpy.arange(1000))
    hummed = identify(record._replace(outputs=record.outputs + hum))
    assert hummed.residual == pytest.approx(clean.residual, rel=0.1)
    assert hummed.uncertainty.gain > 3.0 * clean.uncertainty.gain


@pytest.mark.parametrize(
    "changes, model, duration, why",
    [
        ([(0.0, 0.5)], SLOW, 9.0, "the input never changes: it is 0.5 throughout"),
        ([(0.0, 0.0), (3.0, 0.1)], Model(2.0, 1.0, 0.0, 0.2), 9.0, "the output never changes: it"),
        ([(0.0, 0.0), (1.0, 1.0)], Model(2.0, 50.0), 2.0, "lasts 2 s, and the plant is slower"),
        ([(0.0, 0.0), (1.0, 1.0)], Model(2.0, 1e-6), 9.0, "s apart, and the plant is faster"),
        (
            [(0.0, 0.0), (20.0, 1.0)],
            SLOW,
            9.0,
            "the input changes only outside the time of the outputs",
        ),
        (
            [(0.0, 0.1), (3.0, -0.1), (6.0, 0.0)],
            Model(2.0, 1.0, 0.0, 0.2),
            9.0,
            "is 0 throughout, while the input goes from -0.1 to 0.1",
        ),
        (
            [(10.0 + 0.1 * number, float(number)) for number in range(5)],
            SLOW,
            9.0,
            "the input changes only outside the time of the outputs",
        ),
    ],
)
def test_identify_unusable_record_raises(
    changes: list, model: Model, duration: float, why: str
) -> None:
    with pytest.raises(IdentificationError, match=why):
        identify(answered(changes, model, duration))


def test_identify_much_noise_explains_its_share() -> None:
    record = answered([(0.0, 0.0), (3.0, 1.0), (6.0, 0.0)], SLOW, 9.0, 0.2, outputs=500)
    share = 1.0 - (0.2 * 2.0) ** 2 / float(numpy.var(record.outputs))
    assert 0.6 < share < 0.9
    assert identify(record).explained == pytest.approx(share, abs=0.05)


@pytest.mark.extended
def test_identify_unrelated_output_raises() -> None:
    record = recorded(SLOW)
    noise = numpy.random.RandomState(1).normal(0.0, 1.0, len(record.times))
    with pytest.raises(IdentificationError, match="a first-order plant explains"):
        identify(record._replace(outputs=noise))


def test_identify_gain_hidden_by_noise_raises() -> None:
    """The plant coasts to rest, which shows its time constant; the gain is negative."""
    times = numpy.linspace(0.0, 10.0, 300)
    step = -0.02 * (1.0 - numpy.exp(-(times - 6.0).clip(0.0)))
    noise = numpy.random.RandomState(1).normal(0.0, 0.1, len(times))
    record = record_of([0.0, 6.0], [0.0, 1.0], times, 3.0 * numpy.exp(-times) + step + noise)
    with pytest.raises(
        IdentificationError,
        match="^by it K would be known not at all and T within . %: "
        "there is too little in it, or too much noise$",
    ):
        identify(record)


def test_uncertainty_of_an_error_is_a_share_or_unknown() -> None:
    shares = [fit._within(share) for share in (0.034, 0.6, 0.99, 1.0, math.inf)]
    assert shares == ["within 3 %", "within 60 %", "within 99 %", "not at all", "not at all"]


def test_record_of_few_outputs_raises() -> None:
    with pytest.raises(IdentificationError, match="it has 3 outputs; 20 are the least"):
        record_of([0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 2.0], [0.0, 1.0, 2.0])
    with pytest.raises(IdentificationError, match="the input is not in it"):
        record_of([], [], numpy.arange(30.0), numpy.arange(30.0))
    with pytest.raises(IdentificationError, match="all outputs have the same time: 5 s"):
        record_of([1.0, 2.0], [0.0, 1.0], numpy.full(30, 5.0), numpy.arange(30.0))


#: Causes of differences, and the model, the reading and the residual in which they are seen.
CAUSES: List[Tuple[List[str], Dict[str, float], Dict[str, float], float]] = [
    (["they agree"], {}, {"gain": 2.05, "time_constant": 1.02}, 0.0),
    (["they agree"], {"limit": 1.0, "dead_time": 0.5}, {"gain": 1.95, "time_constant": 0.98}, 0.9),
    (["the plant is not quite of first order"], {}, {"gain": 2.1}, 0.0),
    (["the plant is not quite of first order"], {}, {"gain": 1.9}, 0.0),
    (["the plant is not quite of first order"], {}, {"gain": 2.0, "time_constant": 0.9}, 0.0),
    # On the edge nothing is named.
    (
        ["the plant is not quite of first order"],
        {"limit": 2.0, "dead_time": 0.02},
        {"duration": 5.02},
        0.04,
    ),
    (
        ["the output meets its limit of 1.9, which is read as if it were steady"],
        {"limit": 1.9},
        {},
        0.0,
    ),
    (
        ["the output meets its limit of 1.9, which is read as if it were steady"],
        {"limit": 1.9},
        {"before": -1.0, "after": 0.0},
        0.0,
    ),
    (
        ["an input of 0.1 is in the dead zone, and acts as 0"],
        {"dead_zone": 0.2},
        {"before": 0.1},
        0.0,
    ),
    (
        [
            "an input of 0.1 is in the dead zone, and acts as 0",
            "an input of -0.2 is in the dead zone, and acts as 0",
        ],
        {"dead_zone": 0.2},
        {"before": 0.1, "after": -0.2},
        0.0,
    ),
    (
        [
            "the friction takes 0.05 of the input, which is read into K",
            "the dead time of 0.05 s is read as a part of T",
            "with noise, the first output beyond 63.2 % is too early",
        ],
        {"friction": 0.05, "dead_time": 0.05},
        {},
        0.05,
    ),
    (["the input was recorded late, and T is read from then on"], {"dead_time": -0.03}, {}, 0.0),
    (["the step holds for 4.0 T: the output is not steady yet"], {}, {"duration": 4.0}, 0.0),
    (
        [
            "the dead time of 3 s is read as a part of T",
            "the step holds for 0.0 T: the output is not steady yet",
        ],
        {"dead_time": 3.0},
        {"duration": 2.0},
        0.0,
    ),
    (
        ["the step holds for 2.0 T: the output is not steady yet"],
        {"time_constant": 4.5, "dead_time": 0.09},
        {"duration": 9.09},
        0.0,
    ),
]


@pytest.mark.parametrize("causes, model, read, residual", CAUSES)
def test_step_reading_differences_are_explained(
    causes: List[str], model: Dict[str, float], read: Dict[str, float], residual: float
) -> None:
    record = answered([(0.0, 0.0), (1.0, 1.0)], SLOW, 10.0, outputs=1001)
    found = PLAIN._replace(model=SLOW._replace(**model), residual=residual)
    reading = StepReading(1.0, 0.0, 1.0, 9.0, 2.2, 1.1)._replace(**read)
    assert why_they_differ(record, found, reading) == causes


def test_step_reading_of_few_outputs_is_explained() -> None:
    record = answered([(0.0, 0.0), (1.0, 1.0)], SLOW, 10.0, outputs=401)
    causes = ["the outputs are 0.025 s apart, which limits the reading of T"]
    reading = StepReading(1.0, 0.0, 1.0, 9.0, 2.2, 1.1)
    assert why_they_differ(record, PLAIN._replace(model=SLOW, residual=0.0), reading) == causes


@pytest.mark.parametrize("before, after", [(1.0, 3.0), (3.0, 1.0), (1.0, -1.0)])
def test_read_step_finds_gain_and_time_constant_of_each_direction(
    before: float, after: float
) -> None:
    plant = Model(-2.0, 0.5, 0.1, offset=20.0)
    record = answered(
        [(0.0, before), (6.0, after), (13.0, after - 0.5)], plant, 14.0, outputs=14001
    )
    reading = read_step(record)
    assert reading is not None
    assert reading[:4] == pytest.approx((6.0, before, after, 7.0))
    assert reading[4:] == pytest.approx((-2.0, 0.6), rel=2e-3)


def test_read_step_needs_an_output_before_and_at_the_end() -> None:
    times = numpy.arange(21.0)
    outputs = -numpy.expm1(-0.5 * (times - 10.0).clip(0.0))
    record = Record(numpy.array([0.0, 10.0]), numpy.array([0.0, 1.0]), times, outputs)
    steady = -math.expm1(-4.5)
    assert read_step(record) == pytest.approx((10.0, 0.0, 1.0, 10.0, steady, 2.0))
    for part in (slice(20), slice(10, 21)):
        assert read_step(record._replace(times=times[part], outputs=outputs[part])) is None


@pytest.mark.parametrize("hold, time", [(2.9, 12.9), (3.1, 10.0)])
def test_read_step_takes_the_largest_of_the_long_steps(hold: float, time: float) -> None:
    record = answered([(0.0, 0.0), (10.0, 1.0), (10.0 + hold, 0.5)], SLOW, 20.0 + hold)
    reading = read_step(record)
    assert reading is not None and reading.time == pytest.approx(time)


def test_read_step_ignores_a_larger_but_short_step() -> None:
    record = answered([(0.0, 0.0), (1.0, 1.0), (1.1, 0.0), (2.0, 0.5)], SLOW, 9.0)
    reading = read_step(record)
    assert reading is not None and (reading.before, reading.after) == (0.0, 0.5)
    # A step in the dead zone has no gain.
    # Nor is one read if the outputs before it are missing.
    late = answered([(0.0, 0.0), (1.0, 1.0)], SLOW, 9.0)
    kept = late.times >= 1.0
    late = late._replace(times=late.times[kept], outputs=late.outputs[kept])
    assert read_step(late) is None
    changes = [(0.0, 0.0), (1.0, 0.1), (6.0, 1.0), (6.5, 0.0)]
    assert read_step(answered(changes, Model(2.0, 1.0, 0.0, 0.2), 7.0)) is None


@pytest.mark.parametrize(
    "found, reading, text",
    [
        (
            FOUND,
            StepReading(2.0, 0.25, 0.5, 4.0, 12.0, 0.45),
            """\
6 s, 2000 outputs, 1 changes of the input
            least squares               63.2 % reading
K           10 ± 1.1                    12
T           0.5 ± 0.12 s                0.45 s
dead time   0.1 ± 0.013 s
dead zone   0.2 ± 0.014
limit       9 ± 0.15
offset      20 ± 1.6
friction    0.05 ± 0.017
residual    0.655 rms, 10 % of the outputs' range
± does not hold in 95 of 100: the record has only 12 independent outputs
± counts 12 independent outputs: the residual is autocorrelated
left out    3 values that are not finite
The reading is of the step from 0.25 to 0.5 at 2 s:
- the friction takes 0.05 of the input, which is read into K
- the dead time of 0.1 s is read as a part of T
- with noise, the first output beyond 63.2 % is too early""",
        ),
        (
            PLAIN,
            None,
            """\
6 s, 2000 outputs, 1 changes of the input
            least squares               63.2 % reading
K           10 ± 1.1
T           0.5 ± 0.12 s
dead time   -0.2 ± 0.013 s
dead zone   not found
limit       not met
offset      not found
friction    not found
residual    0.655 rms, 10 % of the outputs' range
± holds in 95 of 100: the residual is noise, whatever the input
No step in it is followed by enough outputs for a 63.2 % reading.
The output begins before its input, which was recorded late by 0.2 s or more: the dead time is \
unknown.""",
        ),
    ],
)
def test_report_states_each_figure(
    found: Identification, reading: Optional[StepReading], text: str
) -> None:
    record = RECORD._replace(left_out=0) if reading is None else RECORD
    assert as_text(record, found, reading) == text


def test_model_file_states_each_value() -> None:
    assert as_yaml(FOUND, "a\nrecord") == (
        "# Identified from a record.\n"
        "# +- does not hold in 95 of 100: the record has only 12 independent outputs.\n"
        "# +- counts 12 independent outputs: the residual is autocorrelated.\n"
        "# offset 20 +- 1.6: the output without an input, not in this model.\n"
        "# friction 0.05 +- 0.017: the part of the input that friction takes, not in this model.\n"
        "system_param_K: 10.0  # +- 1.1\n"
        "system_param_T: 0.5  # +- 0.12\n"
        "system_dead_time: 0.1  # +- 0.013\n"
        "system_min_input: 0.2  # +- 0.014\n"
        "system_max_speed: 9.0  # +- 0.15\n"
    )
    assert as_yaml(PLAIN, "b").splitlines()[4:] == [
        "system_dead_time: 0.0  # +- 0.013",
        "system_min_input: 0.0  # not met",
        "system_max_speed: 1000000000.0  # not met",
    ]


@pytest.mark.parametrize(
    "found, names, titles",
    [
        (
            FOUND,
            ["record", "model", "offset 20"],
            ["output", "residual: ± does not hold in 95 of 100", "input (friction 0.05)"],
        ),
        (PLAIN, ["record", "model"], ["output", "residual", "input"]),
    ],
)
def test_picture_has_record_and_model_above_residual_and_input(
    found: Identification,
    names: List[str],
    titles: List[str],
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    drawn = mock.Mock(return_value="picture")
    monkeypatch.setattr("pid_control.identification.report.as_svg", drawn)
    times = [0.0, 1.0, 2.5]
    record = Record(numpy.array([0.5, 1.0]), numpy.array([0.3, 0.7]), numpy.array(times), VALUES)
    assert as_picture(record, found._replace(fitted=VALUES - 0.5)) == "picture"
    [output, residual, given] = drawn.call_args[0][0]
    assert [panel.title for panel in (output, residual, given)] == titles
    assert [panel.height for panel in (output, residual, given)] == [160.0, 80.0, 80.0]
    assert [(curve.name, curve.times, curve.values) for curve in output.curves] == [
        ("record", times, [1.0, 2.0, 4.0]),
        ("model", times, [0.5, 1.5, 3.5]),
        ("offset 20", [0.0, 2.5], [20.0, 20.0]),
    ][: len(names)]
    assert [(curve.times, curve.values) for curve in residual.curves] == [(times, [0.5] * 3)]
    # The last input holds until the end.
    assert [tuple(curve) for curve in given.curves] == [
        ("", output.curves[-1].colour if found is FOUND else "#d55e00", *HELD, True)
    ]
    assert len({curve.colour for curve in output.curves}) == len(names)
    assert residual.curves[0].colour == output.curves[0].colour


def test_report_has_each_doubt_of_the_uncertainty() -> None:
    record = answered([(2.0, 0.5)], Model(13.1, 0.4, 0.1), 6.0)
    wide = Model(1.1, 0.12, 0.013)
    for test, doubts in (
        (ResidualTest(False, False, True, False, 12.0), 3),
        (ResidualTest(False, False, True, True, 99.0), 2),
        (ResidualTest(False, False, False, True, 99.0), 1),
        (ResidualTest(True, True, False, True, 99.0), 0),
    ):
        found = Identification(Model(10.0, 0.5), wide, record.outputs, 0.1, 0.9, test)
        text = as_text(record, found, None)
        assert text.count("± does not hold in 95 of 100: ") == doubts
        assert ("± holds in 95 of 100" in text) is not bool(doubts)
        assert ("± counts 99 independent outputs" in text) is (doubts in (1, 2))
        assert "No step in it is followed by enough outputs" in text


def test_report_has_each_value_with_its_uncertainty() -> None:
    record = recorded(Model(13.1, 0.04, 0.01, 0.1, 9.0), 0.01)
    found = identify(record)
    text = as_text(record, found, read_step(record))
    for name in ("K ", "T ", "dead time", "dead zone", "limit"):
        (line,) = [line for line in text.splitlines() if line.startswith(name)]
        assert "±" in line
    assert "% of the outputs' range" in text
    root = xml.etree.ElementTree.fromstring(as_picture(record, found))
    lines = root.findall(".//{http://www.w3.org/2000/svg}polyline")
    assert len(lines) == 4
    assert all(line.get("points") for line in lines)


def test_input_that_was_recorded_late_leaves_gain_and_time_constant_as_they_are() -> None:
    record = answered([(0.0, 0.0), (2.0, 0.5)], Model(13.1, 0.04), 8.0, 0.001, outputs=8000)
    late = record._replace(changed_at=record.changed_at + numpy.array([0.0, 0.15]))
    found = identify(late)
    assert found.model.gain == pytest.approx(13.1, rel=0.01)
    assert found.model.time_constant == pytest.approx(0.04, rel=0.03)
    assert found.model.dead_time == pytest.approx(-0.15, abs=0.002)
    assert "recorded late by 0.15 s or more" in as_text(late, found, read_step(late))
    assert "system_dead_time: 0.0 " in as_yaml(found, "a record")
    # A negative dead time within its uncertainty does not indicate that.
    model = found.model._replace(dead_time=-0.9 * found.uncertainty.dead_time)
    near_0 = found._replace(model=model)
    assert "recorded late by" not in as_text(late, near_0, read_step(late))
