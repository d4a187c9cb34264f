"""Tests of the simulated closed loop."""

import math
import xml.etree.ElementTree
from unittest import mock

import pytest

from pid_control.controller.pid import PI, PID, P
from pid_control.identification.response import Model
from pid_control.tuning import closed_loop
from pid_control.tuning.closed_loop import as_picture, as_table, respond
from pid_control.tuning.rules import LAMBDA, METHODS, SIMC, Gains, gains_of

MODEL = Model(2.0, 1.0, 0.2)
PERIOD = 0.01


def test_lambda_makes_a_loop_of_that_time_constant() -> None:
    gains = gains_of(MODEL, PERIOD, 0.5)[LAMBDA]
    response = respond(MODEL, gains, PERIOD, -10.0, 10.0)
    # From 10 % to 90 % a first-order system takes ln 9 time constants.
    assert response.set_point == 10.0
    assert response.rise_time == pytest.approx(0.5 * math.log(9.0), rel=0.15)
    assert response.overshoot < 0.02
    assert response.settling_time < 4.0


def test_figures_of_a_loop_that_swings() -> None:
    strong = Gains(SIMC, "", PI, 6.0, 30.0)
    response = respond(MODEL, strong, PERIOD, -10.0, 10.0)
    peak = max(response.outputs)
    assert response.overshoot == pytest.approx(peak / 10.0 - 1.0) and peak > 10.5
    assert response.settling_time > 2.0


def test_respond_without_integral_does_not_reach_set_point() -> None:
    response = respond(MODEL, Gains(SIMC, "", P, 0.01, 0.0), PERIOD, -1.0, 1.0)
    assert math.isinf(response.settling_time)
    assert math.isinf(response.rise_time)
    assert response.overshoot == 0.0
    assert as_table([response]).endswith(" > 14.51")


@pytest.mark.parametrize("wanted", [5.0, 20.0])
def test_respond_slow_loop_runs_until_settled(wanted: float) -> None:
    found = gains_of(MODEL, PERIOD, wanted)
    for method in (SIMC, LAMBDA):
        response = respond(MODEL, found[method], PERIOD, -10.0, 10.0)
        # Within 2 % a first-order system is after ln 50 time constants.
        assert response.settling_time == pytest.approx(wanted * math.log(50.0), rel=0.15)
        assert response.rise_time == pytest.approx(wanted * math.log(9.0), rel=0.15)


def test_respond_very_slow_plant_has_bounded_samples(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(closed_loop, "_MOST", 5000)
    slow = MODEL._replace(time_constant=1e5)
    response = respond(slow, gains_of(slow, PERIOD)[LAMBDA], PERIOD, -1.0, 1.0)
    assert len(response.times) == 5000
    assert as_table([response]).endswith(f" > {response.times[-1]:.4g}")


def test_set_point_is_within_reach_and_inputs_within_limits() -> None:
    limited = Model(-2.0, 1.0, 0.2, 0.1, 1.2)
    found = gains_of(limited, PERIOD)
    assert found
    for gains in found.values():
        response = respond(limited, gains, PERIOD, -0.5, 1.0)
        assert response.set_point == -0.6
        assert min(response.inputs) >= -0.5 and max(response.inputs) <= 1.0
        assert response.outputs[-1] == pytest.approx(-0.6, abs=0.1)


def test_respond_starts_with_the_proportional_term_that_acts_at_once() -> None:
    fast = Model(13.1, 0.04)
    response = respond(fast, Gains(SIMC, "", PI, 0.05, 0.5), PERIOD, -1.0, 1.0)
    assert response.inputs[0] == pytest.approx(0.05 * 6.55)
    expected = 13.1 * response.inputs[0] * -math.expm1(-PERIOD / 0.04)
    assert response.outputs[1] == pytest.approx(expected)
    late = respond(fast._replace(dead_time=0.004), Gains(SIMC, "", P, 0.05, 0.0), PERIOD, -1.0, 1.0)
    expected = 13.1 * late.inputs[0] * -math.expm1(-0.006 / 0.04)
    assert late.outputs[1] == pytest.approx(expected, rel=0.05)


def test_respond_filters_the_derivative() -> None:
    fast = Model(13.1, 0.04)
    plain = respond(fast, Gains(SIMC, "", PI, 0.05, 0.5), PERIOD, -1.0, 1.0)
    slow = Gains(SIMC, "", PID, 0.05, 0.5, 0.1, 1e9)
    assert respond(fast, slow, PERIOD, -1.0, 1.0).outputs == pytest.approx(plain.outputs)


def test_respond_input_in_the_dead_zone_does_not_move_the_plant() -> None:
    gains = Gains(SIMC, "", P, 0.01, 0.0)
    response = respond(MODEL._replace(dead_zone=0.1), gains, PERIOD, -1.0, 1.0)
    assert response.inputs[0] > 0.0 and set(response.outputs) == {0.0}


def test_table_and_picture_have_each_method() -> None:
    found = gains_of(MODEL, PERIOD)
    responses = [respond(MODEL, found[method], PERIOD, -1.0, 1.0) for method in METHODS]
    lines = as_table(responses).splitlines()
    assert [line.split()[0] for line in lines[1:]] == list(METHODS)
    picture = as_picture(responses)
    root = xml.etree.ElementTree.fromstring(picture)
    lines = root.iter("{http://www.w3.org/2000/svg}polyline")
    points = [(line.get("points") or "").split() for line in lines]
    assert len(points) == 1 + 2 * len(METHODS)
    # The inputs are held, and so drawn in steps.
    assert len(points[-1]) > len(points[len(METHODS)])
    for method in METHODS:
        assert method in picture


def test_figures_of_a_response() -> None:
    gains = Gains(SIMC, "", PI, 1.0, 1.0)
    outputs = [0.0, -0.2, -1.0, -1.8, -2.1, -2.03, -2.05, -2.039]
    times = [0.5 * number for number in range(8)]
    response = closed_loop.Response(gains, times, outputs, [0.0] * 8, -2.0)
    assert response.rise_time == 1.0  # from 10 % at 0.5 s to 90 % at 1.5 s
    assert response.overshoot == pytest.approx(0.05)
    assert response.settling_time == 3.0  # 2.05 is the last one more than 2 % away


def test_picture_has_the_outputs_above_the_inputs(monkeypatch: "pytest.MonkeyPatch") -> None:
    drawn = mock.Mock(return_value="picture")
    monkeypatch.setattr(closed_loop, "as_svg", drawn)
    one, other = (
        closed_loop.Response(Gains(name, "", PI, 1.0, 1.0), [0.0, 1.0], [2.0, 3.0], [4.0, 5.0], 6.0)
        for name in (SIMC, LAMBDA)
    )
    assert as_picture([one, other]) == "picture"
    [(outputs, inputs)] = drawn.call_args[0]
    assert (outputs.title, outputs.height, inputs.title, inputs.height) == (
        "output",
        160.0,
        "input",
        100.0,
    )
    times = [0.0, 1.0]
    colours = [curve.colour for curve in outputs.curves]
    assert len(set(colours)) == 3
    assert [tuple(curve) for curve in outputs.curves] == [
        ("set point", colours[0], times, [6.0, 6.0], False),
        (SIMC, colours[1], times, [2.0, 3.0], False),
        (LAMBDA, colours[2], times, [2.0, 3.0], False),
    ]
    assert [tuple(curve) for curve in inputs.curves] == [
        ("", colour, times, [4.0, 5.0], True) for colour in colours[1:]
    ]


def test_response_that_begins_within_the_band_is_settled_from_the_start() -> None:
    gains = Gains(SIMC, "", PI, 1.0, 1.0)
    response = closed_loop.Response(gains, [0.0, 1.0, 2.0], [2.0, 2.01, 2.0], [0.0] * 3, 2.0)
    assert (response.settling_time, response.rise_time) == (0.0, 0.0)
    assert response.overshoot == pytest.approx(0.005)


def test_picture_shows_the_set_point_for_the_longest_response() -> None:
    gains = Gains(SIMC, "", PI, 1.0, 1.0)
    short, long = (
        closed_loop.Response(gains, times, [1.0] * len(times), [0.0] * len(times), 1.0)
        for times in ([0.0, 1.0], [0.0, 1.0, 2.0])
    )
    set_point = as_picture([short, long]).split('points="')[1].split('"')[0]
    assert set_point.split()[-1].startswith("640.0,")
