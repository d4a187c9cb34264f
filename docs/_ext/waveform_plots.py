"""The directive ``{waveform} RATE SECONDS``: a plot of a signal, and the command that sets it.

Its body is the settings, YAML as for ``rosparam set``. The library itself computes the samples, so
the plot shows what the signal generator publishes.
"""

from pathlib import Path
from typing import Any, Dict, List

import matplotlib
import yaml
from basic_comms.signals.signal_parameters import WAVEFORMS, SignalParameters
from basic_comms.signals.signal_source import SignalSource
from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

#: Where the plots are kept, below the folder of the pages.
FOLDER = "_generated"


class WaveformPlot(SphinxDirective):
    """The command that chooses a signal, and a plot of it."""

    required_arguments = 2
    has_content = True

    def run(self) -> List[nodes.Node]:
        rate, seconds = map(float, self.arguments)
        settings: Dict[str, Any] = yaml.safe_load("\n".join(self.content))
        waveform = settings["waveform"]
        self.env.metadata[self.env.docname].setdefault("waveforms", []).append(waveform)
        command = 'rosparam set /signal_generator "{%s}"' % ", ".join(self.content)
        if "file" in settings:  # on the page below the folder that holds docs
            command = command.replace(settings["file"], "$PWD/docs/" + settings["file"])
            settings["file"] = str(Path(self.env.srcdir, settings["file"]))
        picture = f"{FOLDER}/{waveform}.svg"
        draw(SignalParameters(**settings), rate, seconds, Path(self.env.srcdir, picture))
        shown = nodes.literal_block(command, command, language="sh")
        return [shown, nodes.image(uri="/" + picture, alt="plot of the waveform " + waveform)]


def draw(settings: SignalParameters, rate: float, seconds: float, path: Path) -> None:
    """Plot a signal as the signal generator publishes it.

    :param settings: what it looks like
    :param rate: how many samples a second, Hz
    :param seconds: for how long, s
    :param path: the file to write
    """
    source = SignalSource()
    times = [index / rate for index in range(int(seconds * rate) + 1)]
    values = [source.sample(time, settings).value for time in times]
    plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 8})
    figure, axes = plt.subplots(figsize=(7.0, 1.7))
    style = ".-" if rate <= 30.0 else "-"
    axes.plot(times, values, style, color="#2166ac", linewidth=1.2, markersize=4)
    axes.set_xlim(0.0, seconds)
    axes.set_ylim(-2.3, 2.3)
    axes.set_xlabel("time_x, s")
    axes.set_ylabel("signal_y")
    axes.spines["top"].set_visible(False)
    axes.spines["right"].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.5)
    figure.tight_layout()
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def check_all_shown(app: Any, env: Any) -> None:
    """Warn of a waveform without a plot."""
    shown = {name for page in env.metadata.values() for name in page.get("waveforms", [])}
    for name in WAVEFORMS:
        if name not in shown:
            logging.getLogger(__name__).warning("no page shows the waveform %s", name)


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("waveform", WaveformPlot)
    app.connect("env-check-consistency", check_all_shown)
    return {"parallel_read_safe": True}
