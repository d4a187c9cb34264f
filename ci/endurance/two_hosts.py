"""Launch on two hosts, pull the cable between them, look from one into the other.

Called by ci/two-hosts.
"""

import sys
from typing import Callable, Dict, List

from . import names, run_cable, run_closed
from .checks import Check
from .hosts import Hosts
from .runs import carry_out, make_parser


def main() -> int:
    """Carry out the selected runs.

    :returns: exit status: 0 if every bound was kept
    """
    parser = make_parser("ci/two-hosts", names.TWO_HOSTS)
    parser.add_argument("--outage", type=float, default=20.0)
    options = parser.parse_args()
    if options.outage <= 0.0:
        parser.error("--outage: more than 0")
    runs: Dict[str, Callable[[Hosts], List[Check]]] = {
        "cable": run_cable.run,
        "closed": run_closed.run,
    }
    return carry_out(options, names.TWO_HOSTS, runs, lambda where: Hosts(where, options.outage))


if __name__ == "__main__":
    sys.exit(main())
