"""Command line of the oscilloscope.

Options are read from the command line only. As parameters they would outlive the scope on the
master, and one of them could open the next scope to the network unasked.
"""

import argparse
import ipaddress
import json
import math
import os
import re
from typing import Any, Dict, List, NamedTuple, Optional, Sequence

from rosgraph.names import get_ros_namespace, ns_join

from topic_scope.formulas.names import expand, is_formula
from topic_scope.messages.fields import FieldError
from topic_scope.protocol.overlay_request import FARTHEST_S
from nodekit.package_version import ShowVersion
from topic_scope.protocol.checks import RequestError, check_count, fields_of

#: Addresses that denote all interfaces of a machine.
_ALL = ("", "0.0.0.0", "::")

DEFAULT_ADDRESS, DEFAULT_PORT = "127.0.0.1", 8080
#: Most plots of a page.
PLOTS = 8
#: Number of ports to try with --next-port.
PORTS = 100


class OverlayOption(NamedTuple):
    """Bag to overlay.

    :param path: the file
    :param name: prefix of its topics
    :param offset: shift to later times [s]
    """

    path: str
    name: str
    offset: float = 0.0


class Options(NamedTuple):
    """Options of the command line.

    :param fields: names of the fields to show at start
    :param address: address to listen on
    :param port: port to listen on
    :param next_port: whether to use the next free port if this one is taken
    :param history: how long to keep samples [s]
    :param window: time span to show at start [s]
    :param open_browser: whether to open the page in a browser, if there is one
    :param setup: saved set-up to show at start; None for none
    :param bag: the bag to show in place of the graph; None for the graph
    :param over: the bags to overlay
    """

    fields: Sequence[str]
    address: str
    port: int
    next_port: bool
    history: float
    window: float
    open_browser: bool
    setup: Optional[Dict[str, Any]] = None
    bag: Optional[str] = None
    over: Sequence[OverlayOption] = ()

    @property
    def ports(self) -> Sequence[int]:
        """Acceptable ports, the requested port first."""
        return range(self.port, min(self.port + PORTS, 65536) if self.next_port else self.port + 1)

    @property
    def is_local(self) -> bool:
        """Whether only this machine can connect."""
        return is_loopback(self.address)

    @property
    def url(self) -> str:
        """Address of the page, as seen from this machine."""
        is_here = self.is_local or self.address in _ALL
        name = "localhost" if is_here else self.address
        shown = f"[{name}]" if ":" in name else name
        return f"http://{shown}:{self.port}"


def is_loopback(address: str) -> bool:
    """Return whether an address is reachable from this machine only."""
    if address == "localhost":
        return True
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


def parse(arguments: Sequence[str]) -> Options:
    """Parse a command line.

    :param arguments: without the name of the program; ``_port:=8081`` is equivalent to
        ``--port 8081``, likewise for all options with a value; ``__ns:=lab``, or else the
        environment's ``ROS_NAMESPACE``, is the namespace of relative field names
    :raises SystemExit: if the arguments are invalid, with status 2
    """
    parser = _parser()
    read = parser.parse_intermixed_args(_as_options(arguments))
    namespace = get_ros_namespace(argv=arguments)
    plots: Dict[str, int] = {}  # by name of the field
    for number, group in enumerate([read.fields, *read.below], 1):
        for word in _words(group):
            try:
                is_whole = is_formula(word) or word.startswith('"')
                for name in expand(word if is_whole else ns_join(namespace, word)):
                    plots.setdefault(name, number)
            except FieldError as error:
                parser.error(str(error))
    try:
        check_count(len(plots))
    except RequestError as error:
        parser.error(str(error))
    if len(read.below) >= PLOTS:
        parser.error(f"too many --below ({len(read.below)}); there are at most {PLOTS} plots")
    names = [one.name for one in read.over]
    for name in names:
        if names.count(name) > 1:
            parser.error(f"two bags are named {name}; rename one: --over FILE.bag:NAME")
    if len(read.offset) > len(names):
        parser.error(f"{len(read.offset)} --offset for {len(names)} --over; give one for each")
    offsets = read.offset + [0.0] * len(names)
    return Options(
        tuple(plots),
        read.address,
        read.port,
        read.next_port,
        read.history,
        read.window,
        read.open_browser,
        _with_plots(read.setup, plots),
        read.bag,
        tuple(one._replace(offset=by) for one, by in zip(read.over, offsets)),
    )


def _with_plots(setup: Optional[Dict[str, Any]], plots: Dict[str, int]) -> Optional[Dict[str, Any]]:
    """Return a set-up with the fields in their plots, in the form that a page saves."""
    lower = {name: plot for name, plot in plots.items() if plot > 1}
    if not lower:
        return setup
    traces = dict((setup or {}).get("traces", {}))
    traces.update({name: {**traces.get(name, {}), "plot": plot} for name, plot in lower.items()})
    return {**(setup or {}), "traces": traces}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="scope.py",
        description="An oscilloscope in the browser for any numeric field on the ROS graph.",
    )
    parser.add_argument("--version", action=ShowVersion, package="topic_scope")
    parser.add_argument(
        "fields",
        nargs="*",
        metavar="FIELD",
        help="fields to show at start: /topic/field, /topic/x:y, /topic/array[3], a topic for all"
        " of its fields, or '=/topic/x - 2*/other/y' for a formula; any other field can be"
        " chosen on the page",
    )
    parser.add_argument(
        "--below",
        nargs="+",
        action="append",
        default=[],
        metavar="FIELD",
        help="show these in a separate plot below the others; may be repeated",
    )
    parser.add_argument(
        "--port", type=_port, default=DEFAULT_PORT, help="port to listen on (%(default)s)"
    )
    parser.add_argument(
        "--next-port",
        action="store_true",
        help="if that port is taken, use the next free one",
    )
    parser.add_argument(
        "--address",
        default=DEFAULT_ADDRESS,
        help="address to listen on (%(default)s); with any but a loopback address, others on the"
        " network can watch, but cannot set or call anything",
    )
    parser.add_argument(
        "--history",
        type=_seconds,
        default=60.0,
        metavar="S",
        help="how long samples are kept, in s (%(default)s)",
    )
    parser.add_argument(
        "--window",
        type=_seconds,
        default=10.0,
        metavar="S",
        help="time span to show at start, in s (%(default)s)",
    )
    parser.add_argument(
        "--setup",
        type=_setup,
        metavar="FILE",
        help="set-up saved on the page: traces, axes, trigger, cursors",
    )
    parser.add_argument("--bag", metavar="FILE", help="show a bag; needs no master")
    parser.add_argument(
        "--over",
        type=_over,
        action="append",
        default=[],
        metavar="FILE[:NAME]",
        help="overlay a bag: its /signal/x is /NAME/signal/x, by default with the"
        " name of the file; may be repeated",
    )
    parser.add_argument(
        "--offset",
        type=_offset,
        action="append",
        default=[],
        metavar="S",
        help="shift of the bag, in s; one for each --over, in their order",
    )
    parser.add_argument(
        "--open-browser", action="store_true", help="open the page in a browser, if there is one"
    )
    return parser


def _as_options(arguments: Sequence[str]) -> List[str]:
    words = []
    for argument in arguments:
        match = re.match(r"_(port|address|history|window|setup|bag|over|offset):=(.*)\Z", argument)
        if match:
            words += ["--" + match.group(1), match.group(2)]
        elif ":=" not in argument:  # remappings are for rospy
            words.append(argument)
    return words


def _words(group: Sequence[str]) -> List[str]:
    """Return the names in some arguments; a launch file passes several names in one argument.

    Quoted and bracketed text may contain spaces.
    """
    words: List[str] = []
    for argument in group:
        found = re.findall(r'(?:"[^"]*"|\[[^]]*\]|\S)+', argument)
        words += [argument] if is_formula(argument) else found
    return words


def _port(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"refused {text!r}: must be a number from 1 to 65535")
    return int(text)


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.1 <= seconds <= 3600.0:
        raise argparse.ArgumentTypeError("must be a number of seconds from 0.1 to 3600")
    return seconds


def _over(text: str) -> OverlayOption:
    path, colon, name = text.rpartition(":")
    if not colon or "/" in name or os.path.exists(text):
        path, name = text, _name_of(text)
    if not re.match(r"[A-Za-z]\w*\Z", name, re.ASCII):
        raise argparse.ArgumentTypeError(
            f"{name!r} is not a valid bag name; use a letter, then letters, digits and _"
        )
    return OverlayOption(path, name)


def _name_of(path: str) -> str:
    """Return the name of a file as a topic name: rosbag starts file names with the date."""
    stem, ending = os.path.splitext(os.path.basename(path.rstrip("/")))
    is_bag = ending in (".bag", ".mcap", ".db3")
    name = re.sub(r"\W", "_", stem if is_bag else stem + ending, flags=re.ASCII)
    return name if re.match("[A-Za-z]", name) else f"bag_{name}"


def _offset(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not abs(seconds) <= FARTHEST_S:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time in s")
    return seconds


def _setup(path: str) -> Dict[str, Any]:
    try:
        with open(path, encoding="utf-8") as file:
            setup = json.load(file)
        fields_of(setup.get("fields", []))
        for chosen in setup.get("traces", {}).values():
            chosen.items()
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{path}: {error.strerror}") from None
    except (ValueError, AttributeError, RecursionError) as error:
        raise argparse.ArgumentTypeError(f"{path} is not a set-up of the scope: {error}") from None
    return dict(setup)
