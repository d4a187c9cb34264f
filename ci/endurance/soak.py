"""Run the nodes for long and trouble them meanwhile. Called by ci/soak."""

import argparse
import contextlib
import pathlib
import sys
from typing import Iterator, List

from ..benchmark.processes import Session
from . import (
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
from .runs import Run, carry_out, parser_of
from .surroundings import Soak

RUNS: List[Run[Soak]] = [
    Run("record", "a signal of 1 kHz, its answers and a bag", run_record.run),
    Run("respawn", "kill -9 of each node, which is started again", run_respawn.run),
    Run("stalled", "a subscriber at 1 kHz that is stopped for a minute", run_stalled.run),
    Run("interrupt", "Ctrl-C at a random moment of a node's life", run_interrupt.run),
    Run("managed", "kill -9 and stops of managed nodes under their manager", run_managed.run),
    Run("judge", "controllers whose flaws are known, and a class with broken ones", run_judge.run),
    Run("scope", "ten traces of 1 kHz on the page of the oscilloscope", run_scope.run),
    Run("board", "a board behind a bad cable that is reset and unplugged", run_board.run),
    Run("bridge", "1 kHz through the bridge, then kill -9 of it and of each side", run_bridge.run),
    Run("crowd", "20 subscribers that come and go", run_crowd.run),
]


def main() -> int:
    """Run what is asked for, and report.

    :returns: exit status: 0 if every bound was kept
    """
    options = arguments()

    @contextlib.contextmanager
    def surroundings(directory: pathlib.Path) -> Iterator[Soak]:
        with Session(directory) as session:
            yield Soak(session, 60.0 * options.minutes, options.times, options.seed)

    return carry_out("ci/soak", RUNS, options, surroundings)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = parser_of("ci/soak", RUNS)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--times", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.minutes <= 0.0 or options.times < 0:
        parser.error("--minutes and --times: more than 0")
    return options


if __name__ == "__main__":
    sys.exit(main())
