"""Generator of a message's or service's C++ header, compatible with rosserial's library.

As in rosserial's ros_lib (github.com/ros-drivers/rosserial), but not copied from it: a
class in the package's namespace that derives from ros::Msg, a pointer and a length for an array, a
pointer for a string, the include guards of its generator, and a member ``st_NAME``, an element of
the array NAME. A float64 is a double if the board's double has 8 bytes, else a float.
"""

import ast
from typing import Callable, Dict, Iterable, Iterator, List, NamedTuple, Tuple

from nodekit.message_definitions import TIMES, Constant, Field
from serial_link.headers.wire_header import WIRE_PATH

_NUMBERS: Dict[str, str] = {
    "bool": "bool",
    "byte": "int8_t",
    "char": "uint8_t",
    "float32": "float",
    "float64": "serial_link::float64",
    **{f"int{bits}": f"int{bits}_t" for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": f"uint{bits}_t" for bits in (8, 16, 32, 64)},
}
_OF_ROS = {"time": "ros::Time", "duration": "ros::Duration"}
#: Keywords and alternative tokens of C++11; fields of this name get an underscore appended.
_WORDS = frozenset(
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t "
    "class compl const const_cast constexpr continue decltype default delete do double "
    "dynamic_cast else enum explicit export extern false float for friend goto if inline int long "
    "mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public "
    "register reinterpret_cast return short signed sizeof static static_assert static_cast struct "
    "switch template this thread_local throw true try typedef typeid typename union unsigned using "
    "virtual void volatile wchar_t while xor xor_eq".split()
)


class CppClass(NamedTuple):
    """Parts of a C++ class.

    :param name: of the class
    :param datatype: ROS type, such as ``std_msgs/Header``
    :param md5sum: of the definition
    :param constants: of the definition
    :param fields: of the definition, in order
    """

    name: str
    datatype: str
    md5sum: str
    constants: Tuple[Constant, ...]
    fields: Tuple[Field, ...]


def header(package: str, name: str, classes: List[CppClass], service: bool = False) -> str:
    """Return the C++ header of a message, or of a service.

    :param package: of the message or service
    :param name: of the message or service
    :param classes: one for a message, two for a service
    :param service: whether it is a service
    """
    opening, closing = _service_guards(package, name) if service else _guard(package, name)
    lines = [
        f"// {package}/{name}. Made by serial_link's make_headers.",
        *opening,
        "",
        *_includes(classes),
        "",
        f"namespace {package} {{",
        "",
    ]
    for one in classes:
        lines += [*_class(one), ""]
    if service:
        lines += [f"class {name} {{", " public:"]
        lines += [f"  typedef {name}{part} {part};" for part in ("Request", "Response")]
        lines += ["};", ""]
    return "\n".join([*lines, f"}}  // namespace {package}", "", *closing, ""])


def _guard(package: str, name: str) -> Tuple[List[str], List[str]]:
    guard = f"_ROS_{package}_{name}_h"
    return [f"#ifndef {guard}", f"#define {guard}"], ["#endif"]


def _service_guards(package: str, name: str) -> Tuple[List[str], List[str]]:
    """Return the include guards of a service.

    rosserial's guard lacks the package, so services of the same name in two packages would exclude
    each other. rosserial defines it without a value, this header as 1: only the former excludes it.
    """
    own, of_rosserial = f"SERIAL_LINK_{package}_{name}_SRV_H", f"_ROS_SERVICE_{name}_h"
    opening = [
        f"#ifndef {own}",
        f"#define {own}",
        f"#if !defined({of_rosserial}) || {of_rosserial} + 0",
        f"#define {of_rosserial} 1",
    ]
    return opening, ["#endif", "#endif"]


def member(name: str) -> str:
    """Return the name of a field or constant in C++."""
    return name + "_" if name in _WORDS else name


def _includes(classes: Iterable[CppClass]) -> List[str]:
    bases = {field.base for one in classes for field in one.fields}
    own = [base for base in TIMES if base in bases]
    others = sorted(base for base in bases if "/" in base)
    library = ["ros/msg.h", *(f"ros/{base}.h" for base in own)]
    made = ["../" + path for path in [WIRE_PATH, *(f"{base}.h" for base in others)]]
    return [f'#include "{path}"' for path in [*library, *made]]


def _class(one: CppClass) -> Iterator[str]:
    yield f"class {one.name} : public ros::Msg {{"
    yield " public:"
    for constant in one.constants:
        yield f"  {_constant(constant)}"
    for field in one.fields:
        yield from _members(field)
    yield ""
    yield from _constructor(one)
    yield ""
    yield "  virtual int serialize(unsigned char *outbuffer) const {"
    yield "    int offset = 0;"
    for field in one.fields:
        yield from _serialise(field)
    yield "    return offset;"
    yield "  }"
    yield ""
    yield "  virtual int deserialize(unsigned char *inbuffer) {"
    yield "    int offset = 0;"
    for field in one.fields:
        yield from _deserialise(field)
    yield "    return offset;"
    yield "  }"
    yield ""
    yield f'  virtual const char *getType() {{ return "{one.datatype}"; }}'
    yield f'  virtual const char *getMD5() {{ return "{one.md5sum}"; }}'
    yield "};"


def _constant(constant: Constant) -> str:
    name = member(constant.name)
    if constant.base == "string":
        text = constant.value.replace("\\", "\\\\").replace('"', '\\"')
        return f'static const char *{name}() {{ return "{text}"; }}'
    if constant.base.startswith("float"):
        return f"static constexpr {_NUMBERS[constant.base]} {name} = {float(constant.value)!r};"
    is_bool = constant.base == "bool"  # the values are read as by genmsg
    number = int(bool(ast.literal_eval(constant.value))) if is_bool else int(constant.value)
    return f"static constexpr {_NUMBERS[constant.base]} {name} = {number};"


def cpp_type(field: Field) -> str:
    """Return the C++ type of a field, or of an element of an array.

    :param field: of the definition
    """
    if field.base == "string":  # as rosserial's generator has it, for sketches that set an array
        return "char *" if field.is_array else "const char *"
    return _NUMBERS.get(field.base) or _OF_ROS.get(field.base) or field.base.replace("/", "::")


def _members(field: Field) -> Iterator[str]:
    name = member(field.name)
    yield f"  typedef {cpp_type(field)} _{field.name}_type;"
    if not field.is_array:
        yield f"  _{field.name}_type {name};"
    elif field.length is not None:
        yield f"  _{field.name}_type {name}[{field.length}];"
    else:
        yield f"  uint32_t {field.name}_length;"
        yield f"  size_t {field.name}_room;"
        yield f"  _{field.name}_type st_{field.name};"
        yield f"  _{field.name}_type *{name};"


def _constructor(one: CppClass) -> Iterator[str]:
    # Braces: a field may have the name of a macro of Arduino.h with parentheses, such as max(a, b).
    initial = []
    for field in one.fields:
        name = member(field.name)
        if field.is_array and field.length is None:
            counts = [f"{field.name}_length{{0}}", f"{field.name}_room{{0}}"]
            initial += [*counts, f"st_{field.name}{{}}", f"{name}{{NULL}}"]
        elif field.base == "string" and not field.is_array:
            initial.append(f'{name}{{""}}')
        else:
            initial.append(f"{name}{{}}")
    yield f"  {one.name}()" + (" : " + ", ".join(initial) if initial else "") + " {}"


def _serialise(field: Field) -> Iterator[str]:
    if field.is_array and field.length is None:
        yield f"    offset += serial_link::put(outbuffer + offset, {_count(field)});"
    yield from _each(field, _put, "outbuffer + offset")


def _deserialise(field: Field) -> Iterator[str]:
    if field.is_array and field.length is None:
        parts = f"{_count(field)}, this->{field.name}_room, this->{member(field.name)}"
        yield f"    offset += serial_link::get_length(inbuffer + offset, {parts});"
    yield from _each(field, _get, "inbuffer + offset")


def _count(field: Field) -> str:
    return f"this->{field.name}_length" if field.length is None else str(field.length)


def _each(field: Field, lines: Callable[[str, str, str], List[str]], buffer: str) -> Iterator[str]:
    """Yield the lines for a field; for an array, those for an element in a loop."""
    name = f"this->{member(field.name)}"
    if not field.is_array:
        yield from ("    " + line for line in lines(field.base, name, buffer))
        return
    yield f"    for (uint32_t i = 0; i < {_count(field)}; i++) {{"
    yield from ("      " + line for line in lines(field.base, name + "[i]", buffer))
    yield "    }"


def _put(base: str, what: str, out: str) -> List[str]:
    if "/" in base:
        return [f"offset += {what}.serialize({out});"]
    if base in TIMES:
        return [f"offset += serial_link::put({out}, {what}.{part});" for part in ("sec", "nsec")]
    function = {"string": "put_text", "float64": "put64"}.get(base, "put")
    return [f"offset += serial_link::{function}({out}, {what});"]


def _get(base: str, what: str, source: str) -> List[str]:
    if "/" in base:
        return [f"offset += {what}.deserialize({source});"]
    if base in TIMES:
        return [f"offset += serial_link::get({source}, {what}.{part});" for part in ("sec", "nsec")]
    function = {"string": "get_text", "float64": "get64"}.get(base, "get")
    return [f"offset += serial_link::{function}({source}, {what});"]
