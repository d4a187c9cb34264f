"""Base of the commands judge and judge_signals: options, limits, batch runs, and reports."""

import argparse
import io
import os
import sys
from typing import Callable, Dict, List, NoReturn, Optional, Sequence, Tuple

from pid_control.commands.arguments import svg_path
from pid_control.output_files import check_writable, write_file
from pid_control.programs.deferred_signals import exit_on_signals
from pid_control.runner.default_limits import default_limits
from pid_control.runner.judging_errors import JudgingError
from pid_control.verdicts.judgement import NOT_JUDGED, STATUS, Judgement
from pid_control.verdicts.limits import Figures, Limits, LimitsError, merged, read_limits
from pid_control.verdicts.reports import as_csv, as_junit, as_sentences, as_table

#: Default and largest time limit of a judgement [s].
_TIME_LIMIT_S, _LONGEST_S = 120.0, 3600.0
#: Default folder for the files of a class run.
_HERE = "."
#: Arguments that rostest and roslaunch add to a command line.
_XML, _ADDED = "--gtest_output=xml:", ("__name:=", "__log:=")


class Parser(argparse.ArgumentParser):
    """Parser of a command that judges; exits with the status of NOT_JUDGED on a wrong option."""

    def error(self, message: str) -> NoReturn:
        """Print the usage and a message, and exit."""
        self.print_usage(sys.stderr)
        self.exit(STATUS[NOT_JUDGED], f"{self.prog}: {message}\n")


def add_options(parser: argparse.ArgumentParser, scenarios: Callable[[str], Sequence[str]]) -> None:
    """Add the options that all commands have.

    :param parser: the parser
    :param scenarios: parses names of scenarios
    """
    parser.add_argument("--limits", metavar="FILE", help="YAML file of limits")
    parser.add_argument("--only", metavar="NAME,…", type=scenarios, help="run these scenarios only")
    parser.add_argument(
        "--real-time", action="store_true", help="use the machine's clock, not a simulated one"
    )
    parser.add_argument(
        "--time-limit",
        metavar="S",
        type=_seconds,
        default=_TIME_LIMIT_S,
        help=f"time limit [s]; {_TIME_LIMIT_S:g} by default",
    )
    parser.add_argument(
        "--picture", metavar="FILE.svg", type=svg_path, help="draw all scenarios in this file"
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
        default=_HERE,
        help="folder for the files of --class; the current one by default",
    )


def chosen_scenarios(text: str, known: Sequence[str]) -> List[str]:
    """Parse names of scenarios; return them in their order.

    :param text: names, with commas in between
    :param known: names of all scenarios
    :raises argparse.ArgumentTypeError: for an unknown name
    """
    names = text.split(",")
    for name in names:
        if name not in known:
            allowed = ", ".join(known)
            raise argparse.ArgumentTypeError(f"unknown scenario {name!r}; choose from {allowed}")
    return [name for name in known if name in names]


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 1.0 <= seconds <= _LONGEST_S:
        raise argparse.ArgumentTypeError(f"{text!r} must be from 1 to {_LONGEST_S:g} s")
    return seconds


def _without_rostest(words: Sequence[str]) -> Tuple[List[str], Optional[str]]:
    """Remove rostest's arguments; return the others, and the path of its result file, if any."""
    files = [word[len(_XML) :] for word in words if word.startswith(_XML)]
    if not files:
        return list(words), None
    return [word for word in words if not word.startswith((_XML, *_ADDED))], files[-1]


class JudgingCommand:
    """A command that judges.

    :param parser: its parser
    :param limits_file: name of the file with the default limits
    :param figures: names of the figures of each scenario
    :param subject: what it judges, such as a controller: heading in tables
    :param judge: judges one submission; returns the judgement and a function that draws it
    :param judge_class: judges a class, and returns the exit status
    """

    def __init__(
        self,
        parser: Parser,
        limits_file: str,
        figures: Figures,
        subject: str,
        judge: Callable[[argparse.Namespace, Limits], Tuple[Judgement, Callable[[Judgement], str]]],
        judge_class: Callable[[argparse.Namespace], int],
    ) -> None:
        self._parser, self._limits_file, self._figures = parser, limits_file, figures
        self._subject, self._judge, self._judge_class = subject, judge, judge_class

    def run(self) -> int:
        """Run the command; return the exit status."""
        words, xml = _without_rostest(sys.argv[1:])
        del sys.argv[1:]  # rospy must not apply a student's remappings to this process
        arguments = self._parser.parse_args(words)
        exit_on_signals()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                # A name of a file may be no UTF-8, as from an archive made on Windows.
                stream.reconfigure(errors="backslashreplace")
        try:
            limits = self._limits(arguments.limits)
            for path in (arguments.picture, arguments.csv):
                if path is not None:
                    check_writable(path)
            if arguments.class_folder is not None:
                return self._judge_class(arguments)
            judgement, draw = self._judge(arguments, limits)
            self._report(judgement, draw, arguments, xml)
            return judgement.status
        except OSError as error:
            name = self._parser.prog
            print(f"{name}: {error.filename or 'the file'}: {error.strerror}", file=sys.stderr)
            return STATUS[NOT_JUDGED]

    def _limits(self, path: Optional[str]) -> Limits:
        """Return the limits of a file, or the default ones."""
        limits = default_limits(self._limits_file, self._figures)
        if path is None:
            return limits
        try:
            with open(path, encoding="utf-8") as file:
                return merged(limits, read_limits(file.read(), self._figures))
        except (LimitsError, UnicodeDecodeError) as error:
            print(f"{self._parser.prog}: {path}: {error}", file=sys.stderr)
            sys.exit(STATUS[NOT_JUDGED])

    def _report(
        self,
        judgement: Judgement,
        draw: Callable[[Judgement], str],
        arguments: argparse.Namespace,
        xml: Optional[str],
    ) -> None:
        if judgement.findings:
            print(as_table(judgement), end="\n\n")
        print(as_sentences(judgement))
        name = " ".join(arguments.words)
        if arguments.picture is not None:
            write_file(arguments.picture, draw(judgement))
        if arguments.csv is not None:
            text = as_csv([(name, judgement)], self._figures, self._subject)
            write_file(arguments.csv, text)
        if xml is not None:
            write_file(xml, as_junit(judgement, name))


def check_class(parser: Parser, arguments: argparse.Namespace, invalid: Sequence[str]) -> None:
    """Check the options of a batch run; a wrong option ends the command.

    :param parser: the parser
    :param arguments: the options
    :param invalid: names of options that are for one judgement only
    """
    for name in invalid:
        if getattr(arguments, name):
            parser.error(f"--{name.replace('_', '-')}: not valid with --class")
    if not os.path.isdir(arguments.class_folder):
        parser.error(f"--class: not a folder ({arguments.class_folder})")


def check_single(arguments: argparse.Namespace) -> None:
    """Reject options of a class run in a single judgement.

    :param arguments: the options
    :raises JudgingError: if an option is only valid with ``--class``
    """
    for name, default in (("roster", None), ("output", _HERE)):
        if getattr(arguments, name) != default:
            raise JudgingError(f"--{name}: only valid with --class")


def class_options(arguments: argparse.Namespace) -> List[str]:
    """Return the options that each judgement of a class gets."""
    options = ["--time-limit", str(arguments.time_limit)]
    if arguments.limits is not None:
        options += ["--limits", os.path.abspath(arguments.limits)]
    if arguments.only is not None:
        options += ["--only", ",".join(arguments.only)]
    if arguments.real_time:
        options.append("--real-time")
    return options


def roster_of(parser: Parser, arguments: argparse.Namespace) -> Dict[str, str]:
    """Return the roster of a batch run; an invalid roster ends the command."""
    from pid_control.programs.submissions import RosterError, read_roster

    try:
        return read_roster(arguments.roster) if arguments.roster is not None else {}
    except (RosterError, UnicodeDecodeError) as error:
        parser.error(f"--roster: {arguments.roster}: {error}")
