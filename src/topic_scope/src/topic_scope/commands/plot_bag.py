"""Command ``rosrun topic_scope plot_bag.py``: plot or CSV file of fields in a bag."""

import argparse
import math
import os
import sys
from typing import Iterator, List, Optional, TextIO, Tuple

from tqdm import tqdm

from topic_scope.bag.opening import open_bag
from topic_scope.bag.recording import BagError, Recording
from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.bag.message_slices import Slice, first_messages, slices
from topic_scope.bag.series import Series, crossing, moved
from topic_scope.bag.column_reader import ColumnReader, write_csv
from topic_scope.bag.computed_csv import write_computed_csv
from nodekit.package_version import ShowVersion
from topic_scope.messages.fields import FieldError

#: Number of lines that :mod:`.plot` has styles and colours for.
LINES = 40
#: Exit status: part of the bag was left out; no file was written.
LEFT_OUT, FAILED = 1, 2
#: Number of messages from which on a progress bar is shown.
LONG = 20000
_BAR = "{percentage:3.0f} % |{bar}| {elapsed} < {remaining}"
_FORMATS = ("png", "svg", "pdf", "csv")


def main() -> None:
    """Plot fields of a bag, or write them to a CSV file; exit with 0, 1 or 2."""
    arguments = _parser().parse_args()
    if arguments.align and not _is_level(arguments.align[1]):
        _fail(f"--align: {arguments.align[1]!r} is not a level")
    if arguments.end is not None and arguments.start > arguments.end:
        start, end = arguments.start / 1e9, arguments.end / 1e9
        _fail(f"--start {start:g} is after --end {end:g}")
    if len(arguments.offset) > len(arguments.over):
        given = f"{len(arguments.offset)} --offset for {len(arguments.over)} --over"
        _fail(f"{given}; give one for each")
    try:
        left_out = _write(arguments)
        for text in left_out:
            print(f"plot_bag: {text}", file=sys.stderr)
        if left_out:
            sys.exit(LEFT_OUT)
    except (BagError, FieldError) as error:
        _fail(str(error))
    except ModuleNotFoundError as error:
        _fail(f"{error.name} is not installed: apt install python3-{error.name}")
    except OSError as error:
        _fail(f"{arguments.output}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C


def _is_level(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _fail(text: str) -> None:
    print(f"plot_bag: {text}", file=sys.stderr)
    sys.exit(FAILED)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="plot_bag",
        description="Plot numbers of a bag, or write them to a CSV file.",
        epilog="A field is /topic/field, /topic/x:y:z for several, /topic/array[3], a topic for "
        "all its numbers, or '=/topic/x - 2*/other/y' for a formula. Exit status: 1 "
        "if something was left out that cannot be read, 2 if nothing was written.",
    )
    parser.add_argument("--version", action=ShowVersion, package="topic_scope")
    parser.add_argument("bag", metavar="FILE.bag", help="bag to read")
    parser.add_argument("fields", metavar="FIELD", nargs="+", help="what to plot")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=_output,
        help="file to write: .png, .svg, .pdf or .csv",
    )
    parser.add_argument(
        "--start",
        metavar="S",
        type=_nanoseconds,
        default=0,
        help="start of the time range, in s from the start of the bag",
    )
    parser.add_argument(
        "--end",
        metavar="S",
        type=_nanoseconds,
        help="end of the time range, in s from the start of the bag",
    )
    parser.add_argument(
        "--over",
        metavar="OTHER.bag",
        action="append",
        default=[],
        help="overlay the same fields of another bag; may be repeated",
    )
    parser.add_argument(
        "--offset",
        metavar="S",
        type=_offset,
        action="append",
        default=[],
        help="shift of the other bag, s; one for each --over, in their order",
    )
    parser.add_argument(
        "--align",
        metavar=("FIELD", "LEVEL"),
        nargs=2,
        help="start the time of each bag where this field first rises through this level",
    )
    return parser


def _offset(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not -1e9 < seconds < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time in s")
    return seconds


def _output(text: str) -> str:
    if _format(text) not in _FORMATS:
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .png, .svg, .pdf or .csv")
    return text


def _format(path: str) -> str:
    return os.path.splitext(path)[1][1:].lower()


def _nanoseconds(text: str) -> int:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time in s from the start of the bag")
    return round(seconds * 1e9)


def _write(arguments: argparse.Namespace) -> List[str]:
    """Write the file atomically.

    :returns: descriptions of the parts that were left out
    """
    partial = arguments.output + ".part"
    try:
        if _format(arguments.output) == "csv":
            with open(partial, "w", newline="") as file:
                left_out = _write_numbers(file, arguments)
        else:
            left_out = _draw(partial, arguments)
        os.replace(partial, arguments.output)
        return list(dict.fromkeys(left_out))
    finally:
        if os.path.exists(partial):
            os.remove(partial)


def _write_numbers(file: TextIO, arguments: argparse.Namespace) -> List[str]:
    if arguments.over or arguments.align:
        raise FieldError("--over and --align do not apply to a .csv, which holds one bag")
    with open_bag(arguments.bag) as bag:
        lines, readers = chosen(bag, first_messages(bag), arguments.fields)
        messages = _in_range(bag, readers, arguments.start, arguments.end)
        if any(line.formula for line in lines):
            write_computed_csv(file, lines, readers, messages)
        else:
            write_csv(file, readers, messages)
        return _left_out(bag, readers)


def _draw(path: str, arguments: argparse.Namespace) -> List[str]:
    # Imported late: loading takes a second, and errors are reported before.
    from topic_scope.bag.plot import draw, save

    drawn: List[Series] = []
    left_out: List[str] = []
    for number, name in enumerate([arguments.bag, *arguments.over]):
        with open_bag(name) as bag:
            lines, missing = _series(bag, arguments.fields, arguments)
            by = arguments.offset[number - 1] if 0 < number <= len(arguments.offset) else 0.0
            if arguments.align:
                field, level = arguments.align[0], float(arguments.align[1])
                aligned, _ = _series(bag, [field], arguments)
                if len(aligned) > 1:
                    names = ", ".join(one.name for one in aligned)
                    raise FieldError(f"--align: {field} denotes {names}; name one of them")
                by -= crossing(aligned[0], level)
            left_out += missing
        called = "" if number == 0 else f" ({os.path.basename(name)})"
        drawn += [moved(one, by, one.name + called) for one in lines]
    if len(drawn) > LINES:
        raise FieldError(
            f"too many lines ({len(drawn)}, at most {LINES}); name fewer fields, or write a .csv"
        )
    save(draw(drawn), path, _format(arguments.output))
    for one in drawn:
        if one.correction:
            print(f"plot_bag: {one.name}: {one.correction}", file=sys.stderr)
    return left_out


def _series(
    bag: Recording, fields: List[str], arguments: argparse.Namespace
) -> Tuple[List[Series], List[str]]:
    """Return fields of a bag over time, in the requested range, and the parts left out."""
    lines, readers = chosen(bag, first_messages(bag), fields)
    messages = _in_range(bag, readers, arguments.start, arguments.end)
    return series_of(bag, lines, readers, messages), _left_out(bag, readers)


def _left_out(bag: Recording, readers: List[ColumnReader]) -> List[str]:
    """Return descriptions of the parts of a bag that were left out."""
    cut_off = [f"{one.column.name}: {one.cut_off}" for one in readers if one.cut_off]
    return [*bag.left_out, *bag.notes, *cut_off, *bag.lost]


def _in_range(
    bag: Recording, readers: List[ColumnReader], start: int, end: Optional[int]
) -> Iterator[List[Slice]]:
    """Read the messages of a time range, with a progress bar."""
    topics = sorted({reader.column.topic for reader in readers})
    until = bag.length if end is None else min(end, bag.length)
    # A bar for a short read only flickers, and in a log file it is useless.
    silent = None if bag.count(topics) >= LONG else True
    is_empty, at = True, start
    total = max(until - start, 0)
    with tqdm(total=total, bar_format=_BAR, disable=silent, leave=False) as done:
        for found in slices(bag, topics, start, end):
            yield found
            for one in found:
                is_empty = False
                last = int(one.times[-1])
                done.update(max(last - at, 0))
                at = max(last, at)
    if is_empty and bag.lost:
        raise BagError(bag.lost[0])
    if is_empty:
        text = "no message of %s in this time; the bag is %.3f s long"
        raise BagError(text % (", ".join(topics), bag.length / 1e9))
    for reader in readers:
        reader.check()
