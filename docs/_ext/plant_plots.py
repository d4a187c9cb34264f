"""The directive ``{plant-response} step`` (or ``sine``): what the first-order plant answers.

The plant of the package itself computes it, with the course's values, exactly and by forward Euler;
the analytic solution next to them is that to an input that is not sampled.
"""

import math
from pathlib import Path
from typing import Any, Callable, Dict, List

import matplotlib
from docutils import nodes
from first_order_sys_sim.first_order_plant import METHODS
from first_order_sys_sim.sampled_plant import SampledPlant
from first_order_sys_sim.system_parameters import SystemParameters
from sphinx.util.docutils import SphinxDirective

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

#: Where the plots are kept, below the folder of the pages.
FOLDER = "_generated"
COLOURS = dict(zip(METHODS, ("#2166ac", "#d6604d")))
OMEGA, AMPLITUDE = 2.0 * math.pi, 0.5
VALUES = SystemParameters(system_min_input=0.0)
GAIN, TAU = VALUES.system_param_K, VALUES.system_param_T
RATE, SAMPLE_TIME = VALUES.system_node_rate, VALUES.system_sample_time

Signal = Callable[[float], float]


def step(time: float) -> float:
    """Return a step of the input at time 0."""
    return AMPLITUDE


def step_response(time: float) -> float:
    """Return the analytic answer to it, from rest."""
    return -GAIN * AMPLITUDE * math.expm1(-time / TAU)


def sine(time: float) -> float:
    """Return a sine that begins at time 0."""
    return AMPLITUDE * math.sin(OMEGA * time)


def sine_response(time: float) -> float:
    """Return the analytic answer to it, from rest."""
    ratio = OMEGA * TAU
    swing = math.sin(OMEGA * time) - ratio * math.cos(OMEGA * time)
    return GAIN * AMPLITUDE / (1.0 + ratio**2) * (swing + ratio * math.exp(-time / TAU))


RESPONSES: Dict[str, Any] = {
    "step": (step, step_response, 0.3),
    "sine": (sine, sine_response, 1.2),
}


def simulate(method: str, signal: Signal, times: List[float]) -> List[float]:
    """Return what the node publishes at these times, in the order of time.

    :param method: one of METHODS
    :param signal: the input, sampled by the plant
    :param times: s; the plant also computes the samples in between
    """
    plant = SampledPlant(VALUES.plant._replace(method=method), SAMPLE_TIME)
    outputs = []
    for time in times:
        outputs.append(plant.output(time))
        plant.set_input(time, signal(time))
    return outputs


def draw(name: str, path: Path) -> None:
    """Plot one response and how far each method is off.

    :param name: one of RESPONSES
    :param path: the file to write
    """
    signal, analytic, seconds = RESPONSES[name]
    times = [number / RATE for number in range(round(seconds * RATE) + 1)]
    fine = [seconds * number / 500 for number in range(501)]
    plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 8})
    figure, (above, below) = plt.subplots(2, figsize=(7.0, 4.2), sharex=True)
    above.plot(fine, [analytic(time) for time in fine], color="#777777", label="analytic")
    for method, marker in zip(METHODS, (".", "x")):
        outputs = simulate(method, signal, times)
        above.plot(times, outputs, marker, color=COLOURS[method], markersize=4, label=method)
        at_samples = list(zip(times, outputs))[:: round(SAMPLE_TIME * RATE)]
        errors = [100.0 * (y - analytic(t)) / (GAIN * AMPLITUDE) for t, y in at_samples]
        worst = max(map(abs, errors))
        label = f"{method}: at most {worst if worst > 1e-9 else 0:.3g} %"
        below.plot([t for t, _ in at_samples], errors, ".-", color=COLOURS[method], label=label)
    above.set_ylabel("output")
    below.set_ylabel("error at the samples,\n% of K u")
    below.set_xlabel("time, s")
    below.set_xlim(0.0, seconds)
    for axes in (above, below):
        axes.spines["top"].set_visible(False)
        axes.spines["right"].set_visible(False)
        axes.grid(color="#dddddd", linewidth=0.5)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncol=3, frameon=False)
    figure.tight_layout()
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


class PlantResponse(SphinxDirective):
    """A plot of one response."""

    required_arguments = 1

    def run(self) -> List[nodes.Node]:
        name = self.arguments[0]
        if name not in RESPONSES:
            raise self.error(f"no response {name!r}; there are {', '.join(RESPONSES)}")
        picture = f"{FOLDER}/plant_{name}.svg"
        draw(name, Path(self.env.srcdir, picture))
        alt = f"{name} response: analytic, exact and by forward Euler"
        return [nodes.image(uri="/" + picture, alt=alt)]


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("plant-response", PlantResponse)
    return {"parallel_read_safe": True}
