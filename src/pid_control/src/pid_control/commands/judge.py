"""Command ``rosrun pid_control judge``: judgement of a controller."""

import argparse
import os
import sys
from typing import Callable, List, Sequence, Tuple

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
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.judging.picture import as_svg
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, MOTOR
from pid_control.runner.judging_errors import JudgingError
from pid_control.verdicts.judgement import NOT_JUDGED, Judgement
from nodekit.package_version import ShowVersion
from pid_control.verdicts.limits import Limits

#: Default name of the controller in each package of a class.
_NAME = "controller.py"
_TOPICS = ("set_point", "motor_output", "motor_input")
#: Upper bound for --full-speed [rad/s].
_FASTEST = 1e6


def main() -> None:
    """Judge a controller or a class, and exit with 0, 1, or 125 if not judged."""
    command = JudgingCommand(
        _parser(), "judge_limits.yaml", SCENARIO_METRICS, "controller", _judge_or_not, _judge_class
    )
    sys.exit(command.run())


def _judge_or_not(
    arguments: argparse.Namespace, limits: Limits
) -> Tuple[Judgement, Callable[[Judgement], str]]:
    """Judge one controller; an error is a judgement too."""
    records: Sequence[Record] = []
    try:
        judgement, records = _judge(arguments, limits)
    except JudgingError as error:
        judgement = Judgement(NOT_JUDGED, [], [], str(error))

    def draw(judgement: Judgement) -> str:
        title = f"{' '.join(arguments.words)}: {judgement.verdict}"
        return as_svg(records, title, [failure.scenario for failure in judgement.failures])

    return judgement, draw


def _parser() -> Parser:
    scenarios = "\n".join(f"  {one.name:9}{one.about}" for one in BY_NAME.values())
    parser = Parser(
        prog="judge",
        description="Judge an unchanged controller of the course's motor, on a private master with"
        " a simulated clock, or with a real plant.",
        epilog=f"scenarios:\n{scenarios}\n\nexit status: 0 passed, 1 failed, 125 not judged",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=ShowVersion, package="pid_control")
    parser.add_argument(
        "words",
        metavar="PACKAGE NAME",
        nargs=argparse.REMAINDER,
        help="a program or launch file in a package, or its path, followed by its arguments; with"
        " --class, its name in each package, controller.py by default",
    )
    parser.add_argument("--node", metavar="NAME", help="the controller's node in a launch file")
    parser.add_argument(
        "--launch",
        metavar="FILE",
        help="launch file with the program's parameters; one of its package by default",
    )
    for topic in _TOPICS:
        parser.add_argument(
            "--" + topic.replace("_", "-"),
            metavar="PACKAGE/TYPE/FIELD",
            help=f"type of {topic}, and its field, if not those of its package or of the course",
        )
    parser.add_argument("--workspace", metavar="DIR", help="the controller's built workspace")
    add_options(parser, lambda text: chosen_scenarios(text, list(BY_NAME)))
    parser.add_argument(
        "--real-plant",
        action="store_true",
        help="use the motor on the current master, in real time",
    )
    parser.add_argument(
        "--full-speed",
        metavar="RAD/S",
        type=_speed,
        help=f"greatest speed of the real plant [rad/s]; {MOTOR.max_output:g} by default",
    )
    return parser


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not 0.0 < speed <= _FASTEST:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0 and at most {_FASTEST:g} rad/s")
    return speed


def _judge(arguments: argparse.Namespace, limits: Limits) -> Tuple[Judgement, List[Record]]:
    from pid_control.programs.program_command import CommandError, find_controller
    from pid_control.runner.session import Session

    check_single(arguments)
    if not arguments.words:
        raise JudgingError("controller missing; give a package and a name in it, or a path")
    if arguments.full_speed is not None and not arguments.real_plant:
        raise JudgingError("--full-speed: only valid with --real-plant")
    try:
        command = find_controller(
            arguments.words, arguments.node, arguments.workspace, arguments.launch
        )
    except CommandError as error:
        raise JudgingError(str(error)) from None
    print(f"judge: {command.name}", flush=True)
    types = {topic: getattr(arguments, topic) for topic in _TOPICS}
    given = {topic: text for topic, text in types.items() if text is not None}
    only = None if arguments.only is None else [BY_NAME[name] for name in arguments.only]
    session = Session(command, only, limits, arguments.time_limit, given)
    try:
        if arguments.real_plant:
            full_speed = arguments.full_speed or MOTOR.max_output
            return session.judge_with_real_plant(full_speed), session.records
        return session.judge_with_own_plant(arguments.real_time), session.records
    finally:
        for note in session.notes:
            print(f"note: {note}", flush=True)


def _judge_class(arguments: argparse.Namespace) -> int:
    from pid_control.programs.batch import Batch
    from pid_control.programs.program_finder import ProgramFinder

    parser = _parser()
    check_class(parser, arguments, ("node", "workspace", "launch", "picture", "csv"))
    options = class_options(arguments)
    if arguments.real_plant:
        options.append("--real-plant")
    if arguments.full_speed is not None:
        options += ["--full-speed", str(arguments.full_speed)]
    for topic in _TOPICS:
        if getattr(arguments, topic) is not None:
            options += ["--" + topic.replace("_", "-"), getattr(arguments, topic)]
    roster = roster_of(parser, arguments)
    output = os.path.abspath(arguments.output)
    folder, limit = arguments.class_folder, arguments.time_limit
    name, *rest = arguments.words or [_NAME]
    finder = ProgramFinder(name, rest, SCENARIO_METRICS)
    return Batch(folder, finder, options, output, limit, roster).run()
