"""Tables of the scenarios for a signal generator and process node, and of their metrics."""

from typing import Dict, NamedTuple, Tuple


class Metric(NamedTuple):
    """A metric of a coursework.

    :ivar label: text for reports
    :ivar unit: unit of the figure
    :ivar is_least: True if the limit is a minimum, not a maximum
    """

    label: str
    unit: str = ""
    is_least: bool = False


#: Description of each scenario.
SCENARIOS = {
    "launch": "a launch file starts both nodes",
    "signal": "the generator's messages",
    "process": "the process node's output, compared with its input",
    "restart": "the generator stops, and starts again",
    "parameters": "each parameter is changed",
    "yaml": "the numbers of the YAML files are changed, in a copy",
    "namespace": "both nodes run in a namespace",
}
#: Metrics of each scenario.
METRICS: Dict[str, Dict[str, Metric]] = {
    "launch": {"missing_nodes": Metric("nodes that no launch file starts")},
    "signal": {
        "rate": Metric("messages per second", "Hz", True),
        "distortion": Metric("difference from a sine, RMS per amplitude"),
        "not_finite": Metric("NaN or infinite values"),
        "amplitude": Metric("amplitude"),
        "frequency": Metric("angular frequency", "rad/s"),
        "amplitude_error": Metric("difference from the amplitude's parameter"),
        "frequency_error": Metric("difference from the frequency's parameter"),
        "field_error": Metric("difference from the message's own fields"),
    },
    "process": {
        "rate": Metric("messages per second", "Hz", True),
        "distortion": Metric("difference from the shape, RMS per amplitude"),
        "not_finite": Metric("NaN or infinite values"),
        "gain": Metric("amplitude, per that of the signal"),
        "gain_change": Metric("change of the amplitude", "", True),
        "phase_shift": Metric("phase shift", "rad"),
        "shift": Metric("magnitude of the phase shift", "rad", True),
        "offset": Metric("offset"),
        "below_zero": Metric("depth below zero, per amplitude"),
        "gain_error": Metric("difference from the amplitude's parameter"),
        "shift_error": Metric("difference from the phase's parameter", "rad"),
    },
    "restart": {
        "free_running": Metric("output without a signal"),
        "change": Metric("change of the output after the restart"),
    },
    "parameters": {
        "of_generator": Metric("parameters that change the signal", "", True),
        "of_process": Metric("parameters that change the output", "", True),
        "unread": Metric("parameters without effect"),
    },
    "yaml": {"unused": Metric("YAML files without effect")},
    "namespace": {"outside": Metric("topics outside the namespace")},
}
#: Names of the metrics of each scenario.
SCENARIO_METRICS: Dict[str, Tuple[str, ...]] = {
    scenario: tuple(metrics) for scenario, metrics in METRICS.items()
}
