"""Text of ``bridge --help``, which works without an environment with ROS 2."""

import textwrap

from nodekit import describe, format_value
from ros2_bridge.rules.settings import BridgeParameters

_HEAD = """\
usage: bridge [--print-pairs] [_PARAMETER:=VALUE ...]

Bridge topics, services, actions, parameters and managed nodes between ROS 1 and ROS 2,
until Ctrl-C.

options:
  -h, --help     print this and end
  --print-pairs  print which types are bridged, on standard error which are not and why, and end

parameters, such as _direction:=to_ros2; while the bridge runs, rosparam and dynamic_reconfigure
change those that are not read at the start:
"""
_TAIL = """
environment variables:
  ROS_DOMAIN_ID                  the domain of ROS 2, 0 unless it is set
  ROS_AUTOMATIC_DISCOVERY_RANGE  LOCALHOST unless it is set: SUBNET for nodes of other machines
  ROS2_BRIDGE_ENVIRONMENT        the Python environment with ROS 2, where make_environment or
                                 ./ci/ros2 has not made it in its place
"""


def usage() -> str:
    """Return the help."""
    rows = []
    indent = " " * 25
    for entry in describe(BridgeParameters()):
        default = f"{format_value(entry['default'])} {entry['unit']}".strip()
        text = f"{entry['help']} (default: {default})"
        first = f"  _{entry['name']}".ljust(len(indent))
        rows.append(textwrap.fill(text, 100, initial_indent=first, subsequent_indent=indent))
    return _HEAD + "\n".join(rows) + "\n" + _TAIL
