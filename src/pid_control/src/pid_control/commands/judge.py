"""The command ``rosrun pid_control judge [OPTION…] PACKAGE NAME [ARGUMENT…]``."""

import argparse
import os
import sys
from typing import List, NoReturn, Optional, Sequence, Tuple

from pid_control.files import check_writable, write_file
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.verdicts.judgement import NOT_JUDGED, STATUS, Judgement
from pid_control.verdicts.limits import Limits, LimitsError, merged, read_limits
from pid_control.judging.picture import as_svg
from pid_control.judging.record import Record
from pid_control.verdicts.reports import as_csv, as_junit, as_sentences, as_table
from pid_control.judging.scenarios import BY_NAME, MOTOR, Scenario
from pid_control.runner.default_limits import default_limits
from pid_control.programs.deferred_signals import exit_on_signals
from pid_control.runner.outcome import JudgingError

#: Default and largest time limit of a judgement [s].
_TIME_LIMIT_S = 120.0
_LONGEST_S = 3600.0
#: Default name of the controller in each package of a class.
_NAME = "controller.py"
_TOPICS = ("set_point", "motor_output", "motor_input")
#: Arguments that rostest and roslaunch add to a command line.
_XML, _ADDED = "--gtest_output=xml:", ("__name:=", "__log:=")
#: Upper bound for --full-speed [rad/s].
_FASTEST = 1e6


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        self.exit(STATUS[NOT_JUDGED], f"judge: {message}\n")


def main() -> None:
    """Judge a controller or a class, and exit with 0, 1, or 125 if not judged."""
    words, xml = _without_rostest(sys.argv[1:])
    del sys.argv[1:]  # rospy must not apply the controller's remappings to this process
    arguments = _parser().parse_args(words)
    exit_on_signals()
    try:
        limits = _limits(arguments.limits)
        for path in (arguments.picture, arguments.csv):
            if path is not None:
                check_writable(path)
        if arguments.class_folder is not None:
            status = _judge_class(arguments)
        else:
            judgement, records = _judge_or_not(arguments, limits)
            _report(judgement, records, arguments, xml)
            status = judgement.status
    except OSError as error:
        print(f"judge: {error.filename or 'the file'}: {error.strerror}", file=sys.stderr)
        status = STATUS[NOT_JUDGED]
    sys.exit(status)


def _judge_or_not(arguments: argparse.Namespace, limits: Limits) -> Tuple[Judgement, List[Record]]:
    """Judge one controller; an error is a judgement too."""
    try:
        return _judge(arguments, limits)
    except JudgingError as error:
        return Judgement(NOT_JUDGED, [], [], str(error)), []


def _without_rostest(words: Sequence[str]) -> Tuple[List[str], Optional[str]]:
    """Remove rostest's arguments; return the others, and the path of its result file, if any."""
    files = [word[len(_XML) :] for word in words if word.startswith(_XML)]
    if not files:
        return list(words), None
    return [word for word in words if not word.startswith((_XML, *_ADDED))], files[-1]


def _parser() -> argparse.ArgumentParser:
    scenarios = "\n".join(f"  {one.name:9}{one.about}" for one in BY_NAME.values())
    parser = _Parser(
        prog="judge",
        description="Judge an unchanged controller of the course's motor, on a private master with"
        " a simulated clock, or with a real plant.",
        epilog=f"scenarios:\n{scenarios}\n\nexit status: 0 passed, 1 failed, 125 not judged",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
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
        help="launch file whose parameters the program gets; one of its package by default",
    )
    for topic in _TOPICS:
        parser.add_argument(
            "--" + topic.replace("_", "-"),
            metavar="PACKAGE/TYPE/FIELD",
            help=f"type of {topic}, and its field, if not those of its package or of the course",
        )
    parser.add_argument("--workspace", metavar="DIR", help="the controller's built workspace")
    parser.add_argument("--limits", metavar="FILE", help="YAML file of limits")
    parser.add_argument(
        "--only", metavar="NAME,…", type=_scenarios, help="run these scenarios only"
    )
    parser.add_argument(
        "--real-time", action="store_true", help="use the machine's clock, not a simulated one"
    )
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
    parser.add_argument(
        "--time-limit",
        metavar="S",
        type=_seconds,
        default=_TIME_LIMIT_S,
        help=f"time limit [s]; {_TIME_LIMIT_S:g} by default",
    )
    parser.add_argument(
        "--picture", metavar="FILE.svg", type=_svg_path, help="draw all scenarios in this file"
    )
    parser.add_argument("--csv", metavar="FILE", help="write all figures to this file")
    parser.add_argument(
        "--class",
        dest="class_folder",
        metavar="DIR",
        help="judge each package in a folder, and write class.csv and class.html",
    )
    parser.add_argument(
        "--roster",
        metavar="FILE.csv",
        help="for --class: rows of a folder or archive, and its student",
    )
    parser.add_argument(
        "--output",
        metavar="DIR",
        default=".",
        help="folder for the files of --class; the current one by default",
    )
    return parser


def _scenarios(text: str) -> List[Scenario]:
    names = text.split(",")
    for name in names:
        if name not in BY_NAME:
            allowed = ", ".join(BY_NAME)
            raise argparse.ArgumentTypeError(f"unknown scenario {name!r}; choose from {allowed}")
    return [one for one in BY_NAME.values() if one.name in names]


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 1.0 <= seconds <= _LONGEST_S:
        raise argparse.ArgumentTypeError(f"{text!r} must be from 1 to {_LONGEST_S:g} s")
    return seconds


def _svg_path(text: str) -> str:
    if not text.lower().endswith(".svg"):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .svg")
    return text


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not 0.0 < speed <= _FASTEST:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0 and at most {_FASTEST:g} rad/s")
    return speed


def _limits(path: Optional[str]) -> Limits:
    """Return the limits of a file, or the default ones."""
    limits = default_limits()
    if path is None:
        return limits
    try:
        with open(path, encoding="utf-8") as file:
            return merged(limits, read_limits(file.read(), SCENARIO_METRICS))
    except (LimitsError, UnicodeDecodeError) as error:
        print(f"judge: {path}: {error}", file=sys.stderr)
        sys.exit(STATUS[NOT_JUDGED])


def _judge(arguments: argparse.Namespace, limits: Limits) -> Tuple[Judgement, List[Record]]:
    from pid_control.programs.program_command import CommandError, find_controller
    from pid_control.runner.session import Session

    if arguments.roster is not None:
        raise JudgingError("--roster: only valid with --class")
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
    told = {topic: text for topic, text in types.items() if text is not None}
    session = Session(command, arguments.only, limits, arguments.time_limit, told)
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
    from pid_control.programs.submissions import RosterError, read_roster
    from pid_control.programs.wanted import ProgramWanted

    for name in ("node", "workspace", "launch", "picture", "csv"):
        if getattr(arguments, name):
            _parser().error(f"--{name}: not valid with --class")
    if not os.path.isdir(arguments.class_folder):
        _parser().error(f"--class: not a folder ({arguments.class_folder})")
    options = ["--time-limit", str(arguments.time_limit)]
    if arguments.limits is not None:
        options += ["--limits", os.path.abspath(arguments.limits)]
    if arguments.only is not None:
        options += ["--only", ",".join(scenario.name for scenario in arguments.only)]
    if arguments.real_time:
        options.append("--real-time")
    if arguments.real_plant:
        options.append("--real-plant")
    if arguments.full_speed is not None:
        options += ["--full-speed", str(arguments.full_speed)]
    for topic in _TOPICS:
        if getattr(arguments, topic) is not None:
            options += ["--" + topic.replace("_", "-"), getattr(arguments, topic)]
    try:
        roster = read_roster(arguments.roster) if arguments.roster is not None else {}
    except (RosterError, UnicodeDecodeError) as error:
        _parser().error(f"--roster: {arguments.roster}: {error}")
    output = os.path.abspath(arguments.output)
    folder, limit = arguments.class_folder, arguments.time_limit
    name, *rest = arguments.words or [_NAME]
    wanted = ProgramWanted(name, rest, SCENARIO_METRICS)
    return Batch(folder, wanted, options, output, limit, roster).run()


def _report(
    judgement: Judgement,
    records: Sequence[Record],
    arguments: argparse.Namespace,
    xml: Optional[str],
) -> None:
    if judgement.findings:
        print(as_table(judgement), end="\n\n")
    print(as_sentences(judgement))
    name = " ".join(arguments.words)
    if arguments.picture is not None:
        title = f"{name}: {judgement.verdict}"
        failed = [failure.scenario for failure in judgement.failures]
        write_file(arguments.picture, as_svg(records, title, failed))
    if arguments.csv is not None:
        write_file(arguments.csv, as_csv([(name, judgement)], SCENARIO_METRICS))
    if xml is not None:
        write_file(xml, as_junit(judgement, name))
