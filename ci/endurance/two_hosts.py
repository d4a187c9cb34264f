"""Launch on two hosts, pull the cable between them, look from one into the other.

Called by ci/two-hosts.
"""

import argparse
import sys
from typing import List

from . import run_cable, run_closed
from .hosts import Hosts
from .runs import Run, carry_out, parser_of

RUNS: List[Run[Hosts]] = [
    Run("cable", "cw1_two_hosts.launch, and the cable pulled for a while", run_cable.run),
    Run(
        "closed", "what another host can reach of nodes that were not to be reached", run_closed.run
    ),
]


def main() -> int:
    """Run what is asked for, and report.

    :returns: exit status: 0 if every bound was kept
    """
    options = arguments()
    return carry_out(
        "ci/two-hosts", RUNS, options, lambda directory: Hosts(directory, options.outage)
    )


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = parser_of("ci/two-hosts", RUNS)
    parser.add_argument("--outage", type=float, default=20.0)
    options = parser.parse_args()
    if options.outage <= 0.0:
        parser.error("--outage: more than 0")
    return options


if __name__ == "__main__":
    sys.exit(main())
