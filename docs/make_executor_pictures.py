#!/usr/bin/env python3
"""Run demos of executors_demo and draw the timelines of the page about executors.

    ./ci/exec docs/make_executor_pictures.py

It starts a master of its own and writes docs/images/executor_groups.svg and
docs/images/executor_service.svg. Run it on a quiet machine.
"""

import os
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import Dict, List

import rospy
from std_srvs.srv import Trigger

from nodekit.testing.processes import Master

IMAGES = Path(__file__).resolve().parent / "images"
#: A picture's runs by their titles: the program and its parameters.
GROUPS = {
    "two_mutex": ["two_mutex", "_timer1_sleep:=2.5"],
    "mutex_reentrant": ["mutex_reentrant", "_timer1_sleep:=2.5"],
}
SERVICE = {
    "slow_service": ["slow_service"],
    "slow_service, exclusive": ["slow_service", "_exclusive:=true", "slow_service:=exclusive"],
    "slow_service, single": ["slow_service", "_executor:=single", "slow_service:=single"],
}
#: How long demos run, s.
GROUPS_S, SERVICE_S = 8.0, 10.0


class Recording:
    """Demos that run at the same time, and what they print.

    :param folder: where it is kept
    :param runs: what to run, by title
    """

    def __init__(self, folder: Path, runs: Dict[str, List[str]]) -> None:
        self._logs = [folder / f"{title}.log" for title in runs]
        self._processes = []
        for number, (log, command) in enumerate(zip(self._logs, runs.values())):
            with log.open("w") as file:
                words = ["rosrun", "executors_demo", *command, f"__name:={command[0]}{number}"]
                self._processes.append(subprocess.Popen(words, stdout=file))

    def draw(self, picture: str) -> None:
        """End the demos and draw what they did.

        :param picture: name of the picture
        """
        for process in self._processes:
            process.terminate()
            process.wait()
        command = ["rosrun", "executors_demo", "timeline", "-o", str(IMAGES / picture)]
        subprocess.run(command + [str(log) for log in self._logs], check=True)


def record_groups(folder: Path) -> None:
    """Let timers sleep."""
    recording = Recording(folder, GROUPS)
    time.sleep(GROUPS_S)
    recording.draw("executor_groups.svg")


def record_service(folder: Path) -> None:
    """Call each service three times at once."""
    recording = Recording(folder, SERVICE)
    names = ("slow_service", "exclusive", "single")
    for name in names:
        rospy.wait_for_service(name)
    for name in names * 3:
        call = rospy.ServiceProxy(name, Trigger)
        threading.Thread(target=call, daemon=True).start()
    time.sleep(SERVICE_S)
    recording.draw("executor_service.svg")


def main() -> None:
    """Record and draw, on a master of its own."""
    master = Master()
    os.environ["ROS_MASTER_URI"] = master.uri
    try:
        rospy.init_node("recorder")
        with tempfile.TemporaryDirectory() as folder:
            record_groups(Path(folder))
            record_service(Path(folder))
    finally:
        master.kill()


if __name__ == "__main__":
    main()
