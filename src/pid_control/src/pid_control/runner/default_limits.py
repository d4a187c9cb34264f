"""Default limits that decide whether a submission passes, from pid_control's folder config."""

import pathlib

from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.verdicts.limits import Figures, Limits, read_limits


def default_limits(
    file_name: str = "judge_limits.yaml", figures: Figures = SCENARIO_METRICS
) -> Limits:
    """Return the limits of a file of the folder config, from the source or the installation.

    The file is found relative to this module, not by package name: a student's package of the same
    name may come first in ROS_PACKAGE_PATH.

    :param file_name: name of the file
    :param figures: names of the figures of each scenario
    """
    above = pathlib.Path(__file__).resolve().parents
    places = (above[3], above[3].parent.parent / "share" / "pid_control")
    files = [place / "config" / file_name for place in places]
    file = next((file for file in files if file.is_file()), files[-1])
    return read_limits(file.read_text(encoding="utf-8"), figures)
