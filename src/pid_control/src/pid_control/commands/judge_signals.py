"""Command ``rosrun pid_control judge_signals``: test of a signal generator and process node."""

import argparse
import os
import sys
from typing import Callable, List, Optional, Sequence, Tuple

from pid_control.commands.judging_command import (
    JudgingCommand,
    Parser,
    add_options,
    check_class,
    check_single,
    chosen_scenarios,
    class_options,
    roster_of,
)
from pid_control.runner.judging_errors import JudgingError
from pid_control.signal_judging.coursework_judgement import judge
from pid_control.signal_judging.coursework_picture import as_picture
from pid_control.signal_judging.evidence import GENERATOR, PROCESS, CourseworkEvidence
from pid_control.signal_judging.scenarios import SCENARIO_METRICS, SCENARIOS
from pid_control.verdicts.judgement import NOT_JUDGED, Judgement
from nodekit.package_version import ShowVersion
from pid_control.verdicts.limits import Limits

#: Options that name a channel, by the node that has it.
_CHANNELS = {GENERATOR: "signal", PROCESS: "proc_signal"}


def main() -> None:
    """Judge a coursework or a class, and exit with 0, 1, or 125 if not judged."""
    command = JudgingCommand(
        _parser(),
        "judge_signals_limits.yaml",
        SCENARIO_METRICS,
        "package",
        _judge_or_not,
        _judge_class,
    )
    sys.exit(command.run())


def _parser() -> Parser:
    scenarios = "\n".join(f"  {name:12}{about}" for name, about in SCENARIOS.items())
    parser = Parser(
        prog="judge_signals",
        description="Judge the first coursework: an unchanged signal generator and process node, on"
        " a private master with a simulated clock.",
        epilog=f"scenarios:\n{scenarios}\n\nexit status: 0 passed, 1 failed, 125 not judged",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=ShowVersion, package="pid_control")
    parser.add_argument(
        "words",
        metavar="PACKAGE",
        nargs=argparse.REMAINDER,
        help="a package, or its folder; a launch file of it, and its arguments, if several start"
        " both nodes; with --class, the launch file in each package",
    )
    parser.add_argument(
        "--nodes",
        metavar="PROGRAM,PROGRAM",
        type=_programs,
        help="the programs of the process node and the generator",
    )
    parser.add_argument(
        "--signal", metavar="TOPIC/FIELD", help="the generator's signal, if not found"
    )
    parser.add_argument(
        "--proc-signal", metavar="TOPIC/FIELD", help="the process node's output, if not found"
    )
    parser.add_argument("--workspace", metavar="DIR", help="the package's built workspace")
    add_options(parser, lambda text: chosen_scenarios(text, list(SCENARIOS)))
    return parser


def _programs(text: str) -> List[str]:
    names = text.split(",")
    if len(names) != 2 or not all(names):
        raise argparse.ArgumentTypeError(f"{text!r} must be two programs, with a comma in between")
    return names


def _judge_or_not(
    arguments: argparse.Namespace, limits: Limits
) -> Tuple[Judgement, Callable[[Judgement], str]]:
    """Judge one coursework; an error is a judgement too."""
    evidence: Optional[CourseworkEvidence] = None
    scenarios: Sequence[str] = arguments.only or list(SCENARIOS)
    try:
        evidence, reason = _evidence(arguments, scenarios)
        judgement = judge(evidence, limits, scenarios, reason)
    except JudgingError as error:
        judgement = Judgement(NOT_JUDGED, [], [], str(error))

    def draw(judgement: Judgement) -> str:
        title = f"{' '.join(arguments.words)}: {judgement.verdict}"
        return as_picture(evidence or CourseworkEvidence(), title)

    return judgement, draw


def _evidence(
    arguments: argparse.Namespace, scenarios: Sequence[str]
) -> Tuple[CourseworkEvidence, str]:
    """Run the trials of a coursework; return the evidence, and why some were not run.

    :raises JudgingError: if it cannot be judged
    """
    from pid_control.programs.package_messages import MessageTypeError
    from pid_control.programs.program_command import CommandError
    from pid_control.signal_runner.coursework_bench import CourseworkBench, find_request

    check_single(arguments)
    if not arguments.words:
        raise JudgingError("package missing; give its name or its folder")
    print(f"judge: {arguments.words[0]}", flush=True)
    options = {node: getattr(arguments, name) for node, name in _CHANNELS.items()}
    given = {node: text for node, text in options.items() if text is not None}
    try:
        request = find_request(arguments.words, scenarios, arguments.workspace)._replace(
            programs=arguments.nodes or [],
            real_time=arguments.real_time,
            time_limit=arguments.time_limit,
            given=given,
        )
    except CommandError as error:
        raise JudgingError(str(error)) from None
    bench = CourseworkBench()
    try:
        return bench.run(request)
    except (CommandError, MessageTypeError) as error:
        raise JudgingError(str(error)) from None
    finally:
        bench.close()
        for note in bench.notes:
            print(f"note: {note}", flush=True)


def _judge_class(arguments: argparse.Namespace) -> int:
    from pid_control.programs.batch import Batch
    from pid_control.signal_runner.coursework_finder import CourseworkFinder

    parser = _parser()
    check_class(parser, arguments, ("workspace", "picture", "csv"))
    options = class_options(arguments)
    if arguments.nodes:
        options += ["--nodes", ",".join(arguments.nodes)]
    for name in _CHANNELS.values():
        if getattr(arguments, name) is not None:
            options += ["--" + name.replace("_", "-"), getattr(arguments, name)]
    roster = roster_of(parser, arguments)
    finder = CourseworkFinder(arguments.words)
    output = os.path.abspath(arguments.output)
    folder, limit = arguments.class_folder, arguments.time_limit
    return Batch(folder, finder, options, output, limit, roster).run()
