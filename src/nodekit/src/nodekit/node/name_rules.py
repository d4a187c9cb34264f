"""Validation of graph resource names (http://wiki.ros.org/Names), as strict as roscpp's.

rospy only warns, and ``rosgraph.names.is_legal_name`` accepts letters of any script. But the
master rejects blanks and colons, and programs in C++, rosout and ``rosbag record`` among them,
abort at the first name with a letter beyond ASCII.
"""

import re
from typing import Mapping, Sequence

from rosgraph.names import get_ros_namespace

_BASE = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_GLOBAL = re.compile(r"/|(/[A-Za-z0-9_]+)+/?")
_MUST_BE_BASE = "must be a letter (a-z, A-Z), then letters, digits and underscores"
#: The rule of :func:`is_legal_name`, in words.
LEGAL_NAME = "must be letters (a-z, A-Z), digits and underscores, separated by single slashes"


class IllegalName(ValueError):
    """Error of a name that ROS does not allow; the text has the name and the rule."""


def is_legal_name(name: str) -> bool:
    """Return whether a global name is legal.

    :param name: name of a node, topic, service, parameter or namespace
    """
    return _GLOBAL.fullmatch(name) is not None


def checked(name: str, what: str = "name") -> str:
    """Return a global name after a check.

    :param name: name of a node, topic, service, parameter or namespace
    :param what: subject of the name, for the error
    :raises IllegalName: if it is not legal
    """
    if not is_legal_name(name):
        raise IllegalName(f"{what} '{name}': {LEGAL_NAME}")
    return name


def check_base_name(name: str) -> None:
    """Check the name of a node without its namespace.

    :raises IllegalName: if it is not legal
    """
    if _BASE.fullmatch(name) is None:
        raise IllegalName(f"node name '{name}': {_MUST_BE_BASE}")


def check_namespace(environ: Mapping[str, str], argv: Sequence[str]) -> None:
    """Check the namespace of this process, from ``__ns`` or ``ROS_NAMESPACE``.

    Importing rospy raises an exception if it begins with a tilde.

    :param environ: variables of the environment
    :param argv: arguments of the command line
    :raises IllegalName: if it is not legal
    """
    try:
        namespace = get_ros_namespace(environ, argv)
    except ValueError as error:  # private
        raise IllegalName(f"namespace: {error}: {LEGAL_NAME}") from None
    checked(namespace, "namespace")
