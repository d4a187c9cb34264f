"""Run the nodes for long, and disturb them meanwhile. Called by ci/soak."""

import contextlib
import pathlib
import sys
from typing import Callable, Dict, Iterator, List

from ..benchmark.processes import Session
from . import (
    names,
    run_board,
    run_bridge,
    run_crowd,
    run_interrupt,
    run_judge,
    run_managed,
    run_record,
    run_respawn,
    run_scope,
    run_stalled,
)
from .checks import Check
from .context import Soak
from .runs import carry_out, make_parser

RUNS: Dict[str, Callable[[Soak], List[Check]]] = {
    "record": run_record.run,
    "respawn": run_respawn.run,
    "stalled": run_stalled.run,
    "interrupt": run_interrupt.run,
    "managed": run_managed.run,
    "judge": run_judge.run,
    "scope": run_scope.run,
    "board": run_board.run,
    "bridge": run_bridge.run,
    "crowd": run_crowd.run,
}


def main() -> int:
    """Carry out the selected runs.

    :returns: exit status: 0 if every bound was kept
    """
    parser = make_parser("ci/soak", names.SOAK)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--times", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.minutes <= 0.0 or options.times < 0:
        parser.error("--minutes and --times: more than 0")

    @contextlib.contextmanager
    def make_context(directory: pathlib.Path) -> Iterator[Soak]:
        with Session(directory) as session:
            yield Soak(session, 60.0 * options.minutes, options.times, options.seed)

    return carry_out(options, names.SOAK, RUNS, make_context)


if __name__ == "__main__":
    sys.exit(main())
