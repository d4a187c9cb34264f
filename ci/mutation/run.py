"""Draw mutants, and check that tests detect them: ``run.py PYTHON [OPTION…]``, see ci/mutants."""

import argparse
import shutil
import signal
import sys

from ..tiers.workspace import WORKSPACE
from .evaluation import Evaluation
from .mutants import Unfit, draw, modules_of
from .results import Results

PLACE = WORKSPACE / "build" / "mutants"


def options() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="ci/mutants")
    parser.add_argument("tool", help=argparse.SUPPRESS)
    parser.add_argument("--wiring", action="store_true")
    parser.add_argument("--count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], metavar="PACKAGE")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("paths", nargs="*", metavar="PATH")
    return parser.parse_intermixed_args()


def main(asked: argparse.Namespace) -> int:
    """Draw, test, and print the survivors and the rates.

    :returns: exit status
    """
    # A shell makes its background jobs ignore Ctrl-C and Ctrl-\\, and nodes would inherit that.
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        modules = modules_of(asked.wiring, asked.only, asked.paths)
        count = asked.count or (sys.maxsize if asked.paths else 120)
        drawn = draw(asked.tool, modules, count, asked.seed)
        if not asked.resume:
            shutil.rmtree(str(PLACE), ignore_errors=True)
        PLACE.mkdir(parents=True, exist_ok=True)
        results = Results(PLACE, drawn)
        waiting = results.waiting()
        evaluation = Evaluation(PLACE, asked.wiring)
        try:
            for count, mutant in enumerate(waiting, start=1):
                killer = evaluation.killer(mutant.module, mutant.text)
                results.add(mutant, killer, evaluation.left_out())
                found = "killed" if killer else "SURVIVED"
                print(f"{count} of {len(waiting)} {found}: {mutant}", flush=True)
        finally:
            evaluation.close()
            print(results.summary())
    except Unfit as error:
        print(f"ci/mutants: {error}", file=sys.stderr)
        return 125
    except KeyboardInterrupt:
        return 130
    return 0 if results.is_good() else 1


if __name__ == "__main__":
    sys.exit(main(options()))
