"""Draw mutants of the modules that connect packages to ROS; see whether their tests notice.

``wiring.py [OPTION…]``: see ci/mutants.
"""

import argparse
import pathlib
import shutil
import signal
import sys
import time
from typing import List, Sequence

from ..lint import code_rules
from . import pure_modules as mutants
from .draw import Mutant, drawn, mutants_of
from .judging import Judge
from .verdicts import Verdicts

#: What tests are made of is no wiring, and is tested by those of all packages.
FOR_TESTS = ("nodekit.testing",)
PLACE = code_rules.SOURCES.parent / "build" / "wiring"


def modules_of(packages: Sequence[str]) -> List[pathlib.Path]:
    """Return the modules that are not pure, as paths below src.

    :param packages: only theirs; those of all packages if there is none
    :raises mutants.Unfit: if a package has none
    """
    found = [
        path.relative_to(code_rules.SOURCES)
        for name, path in code_rules.modules()
        if path.parent.name != "scripts"
        if not code_rules.is_in(name, [*code_rules.PURE, *FOR_TESTS])
    ]
    for package in packages:
        if package not in {path.parts[0] for path in found}:
            raise mutants.Unfit(f"{package} is not a package with modules of wiring")
    return [path for path in found if not packages or path.parts[0] in packages]


def draw(packages: Sequence[str], count: int, seed: int) -> List[Mutant]:
    """Draw from all mutants of some packages."""
    found: List[Mutant] = []
    for module in modules_of(packages):
        found += mutants_of(str(module), (code_rules.SOURCES / module).read_text("utf-8"))
    return drawn(found, count, seed)


def judge(verdicts: Verdicts, minutes: float) -> None:
    """Judge what has not been judged, and clean up.

    :param minutes: after these no other mutant is begun
    :raises KeyboardInterrupt: at Ctrl-C
    :raises mutants.Unfit: if tests cannot be run
    """
    end = time.monotonic() + 60.0 * minutes
    mutants.copy_sources()
    judge = Judge(PLACE)
    try:
        waiting = verdicts.waiting()
        for number, mutant in enumerate(waiting, start=1):
            if time.monotonic() > end:
                break
            killer = judge.killer(mutant.module, mutant.text)
            verdicts.add(mutant, killer, judge.left_out())
            found = "killed" if killer else "SURVIVED"
            print(f"{number} of {len(waiting)} {found}: {mutant.described()}", flush=True)
    finally:
        judge.close()
        shutil.rmtree(str(mutants.COPY))


def options() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="ci/mutants --wiring")
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], metavar="PACKAGE")
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--again", action="store_true")
    return parser.parse_args()


def prepare(asked: argparse.Namespace) -> Verdicts:
    """Draw, and go on with what an earlier run has found, or forget it.

    :raises mutants.Unfit: if a package has nothing to draw from
    """
    found = draw(asked.only, asked.count, asked.seed)
    if not (asked.resume or asked.again):
        shutil.rmtree(str(PLACE), ignore_errors=True)
    PLACE.mkdir(parents=True, exist_ok=True)
    verdicts = Verdicts(PLACE, found)
    if asked.again:
        verdicts.forget_survivors()
    return verdicts


def main(asked: argparse.Namespace) -> int:
    """Draw, judge, and print the survivors and the figures.

    :returns: exit status
    """
    # A shell has what it starts in the background ignore Ctrl-C and Ctrl-\\, and so would nodes.
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    interrupted = False
    try:
        verdicts = prepare(asked)
        try:
            judge(verdicts, asked.minutes)
        except KeyboardInterrupt:
            interrupted = True
    except mutants.Unfit as error:
        print(f"ci/mutants: {error}", file=sys.stderr)
        return 125
    except KeyboardInterrupt:
        return 130
    print(verdicts.summary())
    if interrupted:
        return 130
    return 0 if verdicts.share() >= mutants.GOAL else 1


if __name__ == "__main__":
    sys.exit(main(options()))
