"""Text of ``bridge --help``, which works without an environment with ROS 2."""

import textwrap

from nodekit import describe, format_value
from ros2_bridge.rules.settings import BridgeParameters

_HEAD = """\
usage: bridge [--print-pairs [FILE] | --draft-mapping ROS1_TYPE ROS2_TYPE] [_PARAMETER:=VALUE ...]

Bridge topics, services, actions, parameters and managed nodes between ROS 1 and ROS 2,
until Ctrl-C.

options:
  -h, --help     print this help and exit
  --print-pairs [FILE]
                 print the bridged types (the others, with the reason, on standard error) and exit;
                 FILE contains mapping rules, as for mappings_file:=
  --draft-mapping ROS1_TYPE ROS2_TYPE
                 print a mapping rule for two types, such as a/Arm b/msg/Arm, in which fields
                 without a counterpart are left out, and exit

parameters, such as _direction:=to_ros2; while the bridge runs, rosparam and dynamic_reconfigure
change those that are not read at startup:
"""
_TAIL = """
environment variables:
  ROS_DOMAIN_ID                  the ROS 2 domain; default: 0
  ROS_AUTOMATIC_DISCOVERY_RANGE  default: LOCALHOST; SUBNET for nodes of other machines
  ROS2_BRIDGE_ENVIRONMENT        the Python environment with ROS 2, if it is not in the default
                                 folder of make_environment or ./ci/ros2
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
