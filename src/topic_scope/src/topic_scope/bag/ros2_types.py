"""Conversion of ROS 2 types and messages to ROS 1."""

from typing import Any, Callable, Dict, List, Tuple

#: ROS 1 names of ROS 2 types.
_NAMES = {
    "builtin_interfaces/msg/Time": "time",
    "builtin_interfaces/msg/Duration": "duration",
    "byte": "uint8",
    "char": "uint8",
}
#: Most characters of a library's error text.
_LONGEST = 120
_HEADER, _EMPTY = "std_msgs/msg/Header", "structure_needs_at_least_one_member"


class TypeProblem(ValueError):
    """Unreadable type; the text states the reason."""


class Ros2Type:
    """ROS 2 type, by its definition in a recording.

    :param name: e.g. ``std_msgs/msg/Float64``
    :param language: of the definition: a name of rosbags' ``MessageDefinitionFormat``
    :param text: the definition; empty for the standard definition
    :param distribution: name of the ROS 2 distribution
    :raises TypeProblem: if the definition is malformed or missing, or is of a service's calls

    :ivar name: name of the type in ROS 1, e.g. ``std_msgs/Float64``
    :ivar definition: in ROS 1's format, followed by the definitions of the types that it uses
    """

    def __init__(self, name: str, language: str, text: str, distribution: str) -> None:
        from rosbags.typesys import get_types_from_idl, get_types_from_msg

        if "/srv/" in name:  # its definition is that of the service
            raise TypeProblem("calls of a service cannot be shown")
        self._ros2_name = name
        try:
            if language == "NONE" or not text:
                self._store = _standard_store(distribution)
            else:
                parse: Callable[..., Any] = get_types_from_msg
                parsed = get_types_from_idl(text) if language == "IDL" else parse(text, name)
                self._store = _store("EMPTY")
                self._store.register(parsed)
            self.definition = _definition(name, self._store.fielddefs)
            self._store.get_msgdef(name)
        except TypeProblem:
            raise
        except Exception as error:  # the library's parser may raise anything for invalid text
            raise TypeProblem(_short(error)) from error
        self.name = _ros1_name(name)

    def to_ros1(self, message: bytes) -> bytes:
        """Return a message in ROS 1 serialization.

        :param message: serialized by ROS 2, in CDR
        :raises TypeProblem: if it does not fit the definition
        """
        try:
            return bytes(self._store.cdr_to_ros1(message, self._ros2_name))
        except Exception as error:  # the library may raise anything for invalid bytes
            raise TypeProblem(_short(error)) from error


def _short(error: Exception) -> str:
    """Return the text of an error in one short line: it may quote a whole definition."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _store(name: str) -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores[name])


def _standard_store(distribution: str) -> Any:
    """Return the standard types of a ROS 2 distribution."""
    from rosbags.typesys import Stores

    known = {one.name for one in Stores}
    named = f"ROS2_{distribution.upper()}"
    return _store(named if named in known else "ROS2_HUMBLE")


def _ros1_name(name: str) -> str:
    return f"{name.partition('/')[0]}/{name.rpartition('/')[2]}"


def _definition(name: str, types: Dict[str, Any]) -> str:
    """Return the ROS 1 definition of a type, with the types that it uses."""
    names, parts = [name], []
    for one in names:  # grows during the loop
        if one not in types:
            raise TypeProblem(f"the recording has no definition of {one}")
        constants, fields = types[one]
        lines = ["uint32 seq"] if one == _HEADER else []
        declared: List[str] = []
        for field, description in fields:
            if field != _EMPTY:
                base, used, array = _named(description)
                lines.append(f"{base}{array} {field.rstrip('_')}")
                declared.append(base + array)
                names += [used] if used and used not in names else []
        # rosbags drops the position of constants: put them before the only possible field.
        for constant, declared_base, value in reversed(constants):
            base = _NAMES.get(declared_base, declared_base)
            if declared.count(base) == 1:
                place = [line.split(" ")[0] for line in lines].index(base)
                lines.insert(place, f"{base} {constant}={value}")
        head = "" if one == name else f"{'=' * 80}\nMSG: {_ros1_name(one)}\n"
        parts.append(head + "".join(line + "\n" for line in lines))
    return "".join(parts)


def _named(description: Any) -> Tuple[str, str, str]:
    """Return the ROS 1 type of a field, its ROS 2 name if it is a message, and its array brackets.

    :param description: as in rosbags' field definitions
    """
    from rosbags.interfaces import Nodetype

    kind, rest = description
    array = ""
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        array = f"[{rest[1]}]" if kind == Nodetype.ARRAY else "[]"
        kind, rest = rest[0]
    name = rest if kind == Nodetype.NAME else rest[0]
    if name in _NAMES:
        return _NAMES[name], "", array
    return (_ros1_name(name), name, array) if kind == Nodetype.NAME else (name, "", array)
