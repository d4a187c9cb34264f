"""Command ``rosrun pid_control identify``: model of a motor from a record or a live system."""

import argparse
import math
import sys
from typing import NoReturn

import rosbag
import rospy

from nodekit import Node, run
from pid_control.commands.arguments import number, svg_path, yaml_path
from pid_control.identification.fit import identify
from pid_control.identification.model_file import as_yaml
from pid_control.identification.record import IdentificationError, Record
from pid_control.identification.report import as_picture, as_text
from pid_control.identification.step_reading import read_step
from pid_control.output_files import check_writable, write_file
from pid_control.recording.bag_record import read_record
from pid_control.recording.fields import FieldError
from nodekit.package_version import ShowVersion
from pid_control.recording.live_experiment import DriveError, DriveSettings, LiveExperiment

#: Exit statuses besides 0.
_NOT_USABLE, _WRONG = 1, 2
_LONGEST_S = 3600.0


def main() -> None:
    """Identify a plant, from a bag or running, and exit with 0, 1 or 2."""
    parser = _parser()
    arguments = parser.parse_args(rospy.myargv()[1:])
    live = arguments.bag is None
    for name in ("start", "end") if live else ("least", "largest", "seconds"):
        if getattr(arguments, name) != parser.get_default(name):
            _fail(f"--{name}: only valid {'with' if live else 'without'} a bag", _WRONG)
    if not arguments.least <= 0.0 < arguments.largest:
        _fail("--least must be at most 0, and --largest above it", _WRONG)
    try:
        _check_files(arguments)
        if arguments.bag is None:
            run("identify", lambda node: _experiment(node, arguments))
        else:
            _from_bag(arguments)
    except (DriveError, FieldError) as error:
        _fail(error, _WRONG)
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C


def _fail(why: object, status: int) -> NoReturn:
    print(f"identify: {why}", file=sys.stderr)
    sys.exit(status)


def _check_files(arguments: argparse.Namespace) -> None:
    """Exit if an output file cannot be written, before the plant is driven for nothing."""
    try:
        for path in (arguments.model, arguments.picture):
            if path is not None:
                check_writable(path)
    except OSError as error:
        _fail(f"{error.filename}: {error.strerror}", _WRONG)


def _experiment(node: Node, arguments: argparse.Namespace) -> LiveExperiment:
    drive = DriveSettings(
        arguments.input, arguments.output, arguments.least, arguments.largest, arguments.seconds
    )
    origin = f"{arguments.output} over {arguments.input}"
    return LiveExperiment(node, drive, lambda record: _report(record, origin, arguments))


def _from_bag(arguments: argparse.Namespace) -> None:
    try:
        record = read_record(
            arguments.bag, arguments.input, arguments.output, arguments.start, arguments.end
        )
        origin = f"{arguments.output} over {arguments.input} in {arguments.bag}"
        _report(record, origin, arguments)
    except IdentificationError as error:
        _fail(f"{arguments.bag}: record not usable: {error}", _NOT_USABLE)
    except (FieldError, rosbag.ROSBagException) as error:
        _fail(f"{arguments.bag}: {error}", _WRONG)
    except OSError as error:
        _fail(f"{error.filename or arguments.bag}: {error.strerror or error}", _WRONG)


def _report(record: Record, origin: str, arguments: argparse.Namespace) -> None:
    found = identify(record)
    print(as_text(record, found, read_step(record)), flush=True)
    if arguments.model is not None:
        write_file(arguments.model, as_yaml(found, origin))
    if arguments.picture is not None:
        write_file(arguments.picture, as_picture(record, found))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="identify",
        description="Identify a plant: gain K, time constant T, dead time, dead zone, limit, "
        "offset and Coulomb friction.",
        epilog="Without a bag the running plant is driven, and stopped at the end. Exit status: 0; "
        "1 if the record is not usable or incomplete; 2 for an error in the command.",
    )
    parser.add_argument("--version", action=ShowVersion, package="pid_control")
    parser.add_argument("bag", metavar="FILE.bag", nargs="?", help="a bag with both topics")
    parser.add_argument(
        "--input",
        metavar="FIELD",
        default="motor_input/input",
        help="the plant's input, as topic/field (%(default)s)",
    )
    parser.add_argument(
        "--output",
        metavar="FIELD",
        default="motor_output/output",
        help="the plant's output, as topic/field (%(default)s)",
    )
    parser.add_argument("--model", metavar="FILE.yaml", type=yaml_path, help="write the model")
    parser.add_argument("--picture", metavar="FILE.svg", type=svg_path, help="draw the fit")
    live = parser.add_argument_group("a running plant")
    live.add_argument(
        "--least", metavar="U", type=number, default=0.0, help="least input (%(default)g)"
    )
    live.add_argument(
        "--largest", metavar="U", type=number, default=1.0, help="largest input (%(default)g)"
    )
    live.add_argument(
        "--seconds",
        metavar="S",
        type=_seconds,
        default=10.0,
        help="duration [s]; at least 50 time constants are useful (%(default)g)",
    )
    part = parser.add_argument_group("a bag")
    for name, default, text in (("--start", 0.0, "before"), ("--end", math.inf, "after")):
        part.add_argument(
            name,
            metavar="S",
            type=number,
            default=default,
            help=f"skip messages {text} this time from the start of the bag [s]",
        )
    return parser


def _seconds(text: str) -> float:
    value = number(text)
    if not 1.0 <= value <= _LONGEST_S:
        raise argparse.ArgumentTypeError(f"{text!r} must be from 1 to {_LONGEST_S:g} s")
    return value
