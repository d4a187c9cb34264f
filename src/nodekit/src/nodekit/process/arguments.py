"""Checks of a node's command line and environment, before rospy reads them.

rospy reacts to malformed arguments with a traceback, or waits forever.
"""

import re
import xmlrpc.client
from typing import Callable, Collection, List, Mapping, Sequence
from urllib.parse import urlsplit

import rosgraph
from rospy.client import load_command_line_node_params

from nodekit.master import scheme_hint
from nodekit.node import name_rules

_VALUE = (
    "must have one YAML value after :=, of a type that the parameter server accepts "
    "(true, a whole number of 32 bits, 2.5, 'text', or a list or mapping of these)"
)
_URI = "must be the URI of a ROS master, such as http://localhost:11311"

#: A remapping, such as ``rate:=2``, or an assignment without a colon, such as ``_rate=2``.
_MISSPELT = re.compile(
    r"(?P<given>(?:~?(?=\w+:)|_(?=\w+=))(?P<name>[A-Za-z]\w*)):?=(?P<value>.*)", re.DOTALL
)


#: A number that YAML 1.1 reads in base 60, such as 1:30.
_BASE_60 = re.compile(r"[-+]?[1-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?")


class ArgumentError(ValueError):
    """Error of a malformed argument or variable; the text has its name and the rule."""


def check(name: str, environ: Mapping[str, str], argv: Sequence[str]) -> None:
    """Check names, private parameters and the master's address.

    :param name: name of the node, without its namespace
    :param environ: variables of the environment
    :param argv: arguments of the command line
    :raises IllegalName: if ROS does not allow the node's name or its namespace
    :raises ArgumentError: if anything else is malformed
    """
    name_rules.check_namespace(environ, argv)
    name_rules.check_base_name(name)
    _check_master_uri(environ, argv)
    for argument in argv:
        _check_parameter(argument)


def misspelt_settings(
    argv: Sequence[str], declared: Collection[str], is_used: Callable[[str], bool]
) -> List[str]:
    """Return a warning for each ignored argument that names a parameter of the node.

    :param argv: arguments of the command line
    :param declared: names of the node's parameters
    :param is_used: returns whether the node has a topic or service of a name, which an argument
        remaps then
    """
    warnings = []
    for argument in argv:
        found = _MISSPELT.fullmatch(argument)
        if found and found["name"] in declared:
            given, name = found["given"], found["name"]
            if given.startswith("_") or not is_used(given):
                meant = f"_{name}:={found['value']}"
                warnings.append(f"argument {argument}: sets nothing; did you mean {meant}?")
    return warnings


def surprising_values(argv: Sequence[str]) -> List[str]:
    """Return a warning for each private parameter with a value that YAML reads unexpectedly.

    :param argv: arguments of the command line
    """
    warnings = []
    for argument in argv:
        name, is_given, text = argument.partition(":=")
        if is_given and re.match("_[^_]", name) and _BASE_60.fullmatch(text):
            (value,) = load_command_line_node_params([argument]).values()
            decimal = ""
            if text.count(":") == 1 and "." not in text:
                decimal = f"write {name}:={text.replace(':', '.')} for a decimal number, or "
            warnings.append(
                f"argument {argument}: YAML reads {text} in base 60, as {value!r}; {decimal}write"
                f" \"{name}:='{text}'\" for text"
            )
    return warnings


def _check_parameter(argument: str) -> None:
    """Check an argument if it sets a private parameter, such as ``_rate:=5``."""
    try:
        for value in load_command_line_node_params([argument]).values():
            # Write and read: the XML parser rejects characters that the writer accepts.
            xmlrpc.client.loads(xmlrpc.client.dumps((value,)))
    except Exception:  # of any type: YAML and XML-RPC have many
        raise ArgumentError(f"argument '{argument}': {_VALUE}") from None


def _check_master_uri(environ: Mapping[str, str], argv: Sequence[str]) -> None:
    source, uri = "ROS_MASTER_URI", ""
    try:
        given = [argument for argument in argv if argument.startswith("__master:=")]
        if given:
            source, _, uri = given[0].partition(":=")
        else:
            uri = rosgraph.get_master_uri(environ, argv)
        parts = urlsplit(uri)
        is_valid = parts.scheme == "http" and parts.hostname and parts.port != 0
    except ValueError:  # an invalid port
        is_valid = False
    if not is_valid:
        raise ArgumentError(f"{source} '{uri}': {_URI}{scheme_hint(uri)}")
