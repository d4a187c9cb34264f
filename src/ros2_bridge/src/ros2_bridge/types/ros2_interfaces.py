# Pure: knows no ROS.
"""ROS 2 interface definitions (twins) of a ROS 1 package's types.

ROS 2 takes names of types in CamelCase only, and of fields in lower case; it has other names for
time, and the text of a constant stands between quotes.
"""

import re
from typing import Dict, List, Mapping, NamedTuple, Set

from nodekit.message_definitions import DefinitionError, constant_in, field_in

#: ROS 1's types that have another name, or another home, in ROS 2.
RENAMED = {
    "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
    "std_msgs/Time": "builtin_interfaces/Time",
    "std_msgs/Duration": "builtin_interfaces/Duration",
}

#: Packages that each package with an action needs.
OF_ACTIONS = {"action_msgs", "unique_identifier_msgs"}

_CAMEL = re.compile(r"[A-Z][A-Za-z0-9]*\Z")
_LOWER = re.compile(r"[a-z](_?[a-z0-9])*\Z")
_UPPER = re.compile(r"[A-Z](_?[A-Z0-9])*\Z")


def twin_type(datatype: str) -> str:
    """Return the ROS 2 type of a ROS 1 type, such as pkg/SignalMsg of pkg/signal_msg."""
    if datatype in RENAMED:
        return RENAMED[datatype]
    package, slash, base = datatype.rpartition("/")
    if slash and not _CAMEL.match(base):
        base = "".join(part[:1].upper() + part[1:] for part in base.split("_"))
    return package + slash + base


class TwinPackage(NamedTuple):
    """A ROS 2 package with the twins of a ROS 1 package's types.

    :param files: text by path within the package
    :param needs: packages whose types it uses
    :param names: its types whose names differ, ROS 2's by ROS 1's
    """

    files: Dict[str, str]
    needs: Set[str]
    names: Dict[str, str]


def generate_interfaces(package: str, definitions: Mapping[str, str]) -> TwinPackage:
    """Write the twins of a message package.

    :param package: its name
    :param definitions: text by path within it, such as ``msg/signal_msg.msg``
    :raises DefinitionError: if one of them is invalid, or ROS 2 cannot have it
    """
    files: Dict[str, str] = {}
    needs: Set[str] = set()
    names: Dict[str, str] = {}
    for path, text in sorted(definitions.items()):
        folder, _, file = path.partition("/")
        base, _, suffix = file.partition(".")
        twin = twin_type(f"{package}/{base}")
        if twin != f"{package}/{base}":
            names[f"{package}/{base}"] = twin
        if folder == "action":
            needs |= OF_ACTIONS
        target = f"{folder}/{twin.rpartition('/')[2]}.{suffix}"
        if target in files:
            raise DefinitionError(f"{package}/{path}: another type is {twin} in ROS 2 already")
        try:
            files[target] = _definition(text, package, needs)
        except DefinitionError as error:
            raise DefinitionError(f"{package}/{path}: {error}") from None
    needs.discard(package)
    interfaces = sorted(files)
    files["package.xml"] = _manifest(package, sorted(needs))
    files["CMakeLists.txt"] = _cmake(package, interfaces, sorted(needs))
    return TwinPackage(files, needs, names)


def _definition(text: str, package: str, needs: Set[str]) -> str:
    return "".join(_line(line, package, needs) + "\n" for line in text.splitlines())


def _line(line: str, package: str, needs: Set[str]) -> str:
    if line.strip() == "---":  # between the parts of a service or action
        return "---"
    constant = constant_in(line)
    if constant is not None:
        value = constant.value
        if constant.base == "string":
            value = '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
        return f"{constant.base} {_legal(constant.name.upper(), _UPPER)}={value}"
    field = field_in(line, package)
    if field is None:
        return line.rstrip()  # a comment, or nothing
    base = twin_type(field.base)
    if "/" in base:
        needs.add(base.partition("/")[0])
    brackets = f"[{'' if field.length is None else field.length}]" if field.is_array else ""
    comment = line.partition("#")[2].rstrip()
    name = _legal(field.name.lower(), _LOWER)
    return f"{base}{brackets} {name}" + (f"  #{comment}" if comment else "")


def _legal(name: str, pattern: "re.Pattern[str]") -> str:
    if not pattern.match(name):
        raise DefinitionError(f"{name} is not a legal name of a field or constant in ROS 2")
    return name


def _manifest(package: str, needs: List[str]) -> str:
    depends = "".join(f"  <depend>{name}</depend>\n" for name in needs)
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>0.1.0</version>
  <description>The ROS 2 twins of the types of the ROS 1 package of this name.</description>
  <maintainer email="maintainers@basic-comms.invalid">basic_comms maintainers</maintainer>
  <license>BSD-3-Clause</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
{depends}  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
</package>
"""


def _cmake(package: str, interfaces: List[str], needs: List[str]) -> str:
    finds = "".join(f"find_package({name} REQUIRED)\n" for name in needs)
    listed = "".join(f'  "{path}"\n' for path in interfaces)
    depends = f"  DEPENDENCIES {' '.join(needs)}" if needs else ""
    return f"""cmake_minimum_required(VERSION 3.8)
project({package})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{finds}rosidl_generate_interfaces(${{PROJECT_NAME}}
{listed}{depends})
ament_package()
"""
