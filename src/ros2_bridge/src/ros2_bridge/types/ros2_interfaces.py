# Pure: knows no ROS.
"""Generator of ROS 2 interface definitions (twins) of a ROS 1 package's types.

ROS 2 requires type names in CamelCase and field names in lower case; time types have other names,
and string constants are quoted.
"""

import keyword
import re
from typing import Callable, Dict, List, Mapping, NamedTuple, Set

from nodekit.message_definitions import DefinitionError, constant_in, field_in

#: ROS 1 types with another name or package in ROS 2.
RENAMED = {
    "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
    "std_msgs/Time": "builtin_interfaces/Time",
    "std_msgs/Duration": "builtin_interfaces/Duration",
}

#: Dependencies of each package with an action.
OF_ACTIONS = {"action_msgs", "unique_identifier_msgs"}

#: Keywords of C and C++, for which ROS 2 cannot generate code, in addition to Python's.
#: Source: ISO/IEC 9899:2011 6.4.1 and 14882:2017 5.11, those in lower case.
RESERVED = frozenset(
    """alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const
    const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit
    export extern false float for friend goto if inline int long mutable namespace new noexcept not
    not_eq nullptr operator or or_eq private protected public register reinterpret_cast restrict
    return short signed sizeof static static_assert static_cast struct switch template this
    thread_local throw true try typedef typeid typename union unsigned using virtual void volatile
    wchar_t while xor xor_eq""".split()
)

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
    """ROS 2 package with the twins of a ROS 1 package's types.

    :param files: text by path within the package
    :param needs: its dependencies
    :param names: ROS 2 names of types by ROS 1 name, if they differ
    """

    files: Dict[str, str]
    needs: Set[str]
    names: Dict[str, str]


class Interfaces(NamedTuple):
    """The twins of several packages.

    :param packages: by name; only those with at least one twin
    :param left_out: the reason for each type without a twin, by a path such as ``pkg/msg/A.msg``
    """

    packages: Dict[str, TwinPackage]
    left_out: Dict[str, str]


class _Interface(NamedTuple):
    """The twin of one type.

    :param name: ROS 1 name, such as ``pkg/signal_msg``
    :param twin: ROS 2 name, such as ``pkg/SignalMsg``
    :param uses: ROS 2 names of the messages in its fields
    """

    name: str
    twin: str
    target: str
    text: str
    uses: Set[str]


def generate_interfaces(
    definitions: Mapping[str, Mapping[str, str]], is_available: Callable[[str], bool]
) -> Interfaces:
    """Generate the twins of the types of some packages, if possible in ROS 2.

    :param definitions: for each package, text by path within it, such as ``msg/signal_msg.msg``
    :param is_available: returns whether ROS 2 has a message, such as ``std_msgs/Header``, without
        these packages
    """
    twins: Dict[str, _Interface] = {}
    left_out: Dict[str, str] = {}
    for package, texts in sorted(definitions.items()):
        targets: Dict[str, str] = {}
        for path, text in sorted(texts.items()):
            try:
                twin = _interface(package, path, text)
            except DefinitionError as error:
                left_out[f"{package}/{path}"] = str(error)
                continue
            if targets.setdefault(twin.target, path) != path:
                first = f"{package}/{targets[twin.target]}"
                left_out[f"{package}/{path}"] = f"{first} is {twin.twin} in ROS 2 already"
                continue
            twins[f"{package}/{path}"] = twin
    _leave_out_users(twins, left_out, is_available)
    packages = {}
    for package in sorted({path.partition("/")[0] for path in twins}):
        packages[package] = _package(
            package, [twin for path, twin in twins.items() if path.partition("/")[0] == package]
        )
    return Interfaces(packages, left_out)


def _leave_out_users(
    twins: Dict[str, _Interface], left_out: Dict[str, str], is_available: Callable[[str], bool]
) -> None:
    """Remove the twins with fields of unavailable types, and the twins that use them."""
    while True:
        messages = {twin.twin for twin in twins.values() if twin.target.startswith("msg/")}
        lost = {}
        for path, twin in twins.items():
            missing = [use for use in sorted(twin.uses - messages) if not is_available(use)]
            if missing:
                lost[path] = f"it uses {missing[0]}, which ROS 2 does not have here"
        if not lost:
            return
        left_out.update(lost)
        for path in lost:
            del twins[path]


def _package(name: str, twins: List[_Interface]) -> TwinPackage:
    needs = {use.partition("/")[0] for twin in twins for use in twin.uses}
    if any(twin.target.startswith("action/") for twin in twins):
        needs |= OF_ACTIONS
    needs.discard(name)
    files = {twin.target: twin.text for twin in twins}
    interfaces = sorted(files)
    files["package.xml"] = _manifest(name, sorted(needs))
    files["CMakeLists.txt"] = _cmake(name, interfaces, sorted(needs))
    names = {twin.name: twin.twin for twin in twins if twin.name != twin.twin}
    return TwinPackage(files, needs, names)


def _interface(package: str, path: str, text: str) -> _Interface:
    folder, _, file = path.partition("/")
    base, _, suffix = file.partition(".")
    name = f"{package}/{base}"
    twin = twin_type(name)
    base = twin.rpartition("/")[2]
    if not twin.startswith(f"{package}/") or not _CAMEL.match(base):
        raise DefinitionError(f"{base} is not a valid name of a type in ROS 2")
    uses: Set[str] = set()
    lines = []
    known: Dict[str, str] = {}  # ROS 1 names of fields and constants, by ROS 2 name
    for line in text.splitlines():
        if line.strip() == "---":  # between the parts of a service or action
            known = {}
            lines.append("---")
        else:
            lines.append(_line(line, package, uses, known))
    return _Interface(
        name, twin, f"{folder}/{base}.{suffix}", "".join(line + "\n" for line in lines), uses
    )


def _line(line: str, package: str, uses: Set[str], known: Dict[str, str]) -> str:
    constant = constant_in(line)
    if constant is not None:
        value = constant.value
        if constant.base == "string":
            value = '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
        return (
            f"{constant.base} {_valid(constant.name, constant.name.upper(), _UPPER, known)}={value}"
        )
    field = field_in(line, package)
    if field is None:
        return line.rstrip()  # a comment, or empty
    base = twin_type(field.base)
    if "/" in base:
        uses.add(base)
    brackets = f"[{'' if field.length is None else field.length}]" if field.is_array else ""
    comment = line.partition("#")[2].rstrip()
    name = _valid(field.name, field.name.lower(), _LOWER, known)
    return f"{base}{brackets} {name}" + (f"  #{comment}" if comment else "")


def _valid(name: str, twin: str, pattern: "re.Pattern[str]", known: Dict[str, str]) -> str:
    """Return the ROS 2 name of a field or constant.

    :param name: ROS 1 name
    :param twin: the name in ROS 2's case
    :param known: the previous names; this one is added
    :raises DefinitionError: if it is invalid in ROS 2
    """
    if not pattern.match(twin) or twin in RESERVED or keyword.iskeyword(twin):
        raise DefinitionError(f"{name} is not a valid name of a field or constant in ROS 2")
    if twin in known:
        raise DefinitionError(f"{known[twin]} and {name} are both {twin} in ROS 2")
    known[twin] = name
    return twin


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
