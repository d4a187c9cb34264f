"""Whether callbacks overlap in executors as the scenarios say, with nodekit and with rclpy."""

import json
import subprocess
import sys

from .context import Bench, Figures
from .peer_programs import SCRIPTS, WORKSPACE, rclpy_environment
from .scenarios import SCENARIOS
from .stacks import RCLPY

#: Longest time for all scenarios, s.
LIMIT = 60.0


def agreement(bench: Bench, subject: str) -> Figures:
    """Count the scenarios in which what is observed is as it should be."""
    if subject == RCLPY:
        python, script = str(bench.peers.rclpy), SCRIPTS / "ros2" / "overlap_node.py"
        environment = dict(rclpy_environment(), PYTHONPATH=str(WORKSPACE))
    else:
        python, script = sys.executable, SCRIPTS / "overlap_node.py"
        environment = bench.session.environment
    done = subprocess.run(
        [python, str(script)], env=environment, stdout=subprocess.PIPE, timeout=LIMIT, check=True
    )
    observed = json.loads(done.stdout.splitlines()[-1])
    agree = 0
    for name, scenario in SCENARIOS.items():
        if observed[name] == scenario.expected:
            agree += 1
        else:
            print(f"{subject}, {name}: {observed[name]}, not {scenario.expected}", file=sys.stderr)
    return {"agree": float(agree)}
