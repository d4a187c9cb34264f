"""Command ``rosrun pid_control tune``: gains of a controller for an identified model."""

import argparse
import sys
from typing import List, NoReturn

import rospy

from pid_control.commands.arguments import number, svg_path, yaml_path
from pid_control.identification.model_file import ModelError, read_model
from pid_control.output_files import write_file
from pid_control.programs.deferred_signals import exit_on_signals
from pid_control.tuning.closed_loop import Response, as_picture, as_table, respond
from nodekit.package_version import ShowVersion
from pid_control.tuning.rules import METHODS, SIMC, as_yaml, gains_of

#: Exit status besides 0.
_WRONG = 2


def main() -> None:
    """Print the gains by each method, write those of one, and exit with 0 or 2."""
    arguments = _parser().parse_args(rospy.myargv()[1:])
    exit_on_signals()
    if not arguments.least <= 0.0 < arguments.largest:
        _fail("--least must be at most 0, and --largest above it")
    if arguments.method != SIMC and arguments.gains is None:
        _fail("--method: only valid with --gains")
    try:
        with open(arguments.model, encoding="utf-8") as file:
            model = read_model(file.read())
        found = gains_of(model, arguments.period, arguments.wanted)
        responses = [
            respond(model, found[method], arguments.period, arguments.least, arguments.largest)
            for method in METHODS
        ]
        print(as_table(responses), flush=True)
        if arguments.gains is not None:
            chosen = found[arguments.method]
            text = as_yaml(chosen, arguments.model, arguments.least, arguments.largest)
            write_file(arguments.gains, text)
        if arguments.picture is not None:
            write_file(arguments.picture, as_picture(responses))
        if arguments.judge:
            _judge(responses, arguments.least, arguments.largest)
    except (ModelError, UnicodeDecodeError) as error:
        _fail(f"{arguments.model}: {error}")
    except OSError as error:
        _fail(f"{error.filename or arguments.model}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C


def _fail(why: str) -> NoReturn:
    print(f"tune: {why}", file=sys.stderr)
    sys.exit(_WRONG)


def _judge(responses: List[Response], least: float, largest: float) -> None:
    # Imported late: only this needs a master and processes.
    from pid_control.runner.gains_judgement import judge_gains

    several = [response.gains for response in responses]
    for gains, said in judge_gains(several, least=least, largest=largest):
        print(f"\n{gains.method}:\n{said}", flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tune",
        description="Compute the gains of a controller for a model, by several tuning rules.",
        epilog="Exit status: 0; 2 for an error in the command or the model.",
    )
    parser.add_argument("--version", action=ShowVersion, package="pid_control")
    parser.add_argument("model", metavar="MODEL.yaml", help="a model file written by identify")
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=SIMC,
        help="method whose gains are written (%(default)s)",
    )
    parser.add_argument(
        "--gains", metavar="FILE.yaml", type=yaml_path, help="write the gains for controller.py"
    )
    parser.add_argument(
        "--picture", metavar="FILE.svg", type=svg_path, help="draw the step responses"
    )
    parser.add_argument(
        "--period",
        metavar="S",
        type=_seconds,
        default=0.01,
        help="period of the controller [s] (%(default)g)",
    )
    parser.add_argument(
        "--wanted",
        metavar="S",
        type=_seconds,
        help="desired time constant of the closed loop, for simc and lambda [s]",
    )
    for name, default, text in (("--least", -1.0, "least"), ("--largest", 1.0, "largest")):
        parser.add_argument(
            name,
            metavar="U",
            type=number,
            default=default,
            help=f"{text} output of the controller (%(default)g)",
        )
    parser.add_argument(
        "--judge",
        action="store_true",
        help="run the judge on the gains of each method, with the course's motor; takes minutes",
    )
    return parser


def _seconds(text: str) -> float:
    value = number(text)
    if not 1e-4 <= value <= 1e3:
        raise argparse.ArgumentTypeError(f"{text!r} must be from 0.0001 to 1000 s")
    return value
