"""The headers that make_headers writes, compiled, against genpy."""

import io
import pathlib
import random
import re
import struct
import subprocess
from typing import Any, Dict, List, NamedTuple, Tuple
from unittest import mock

import genpy
import numpy
import pytest
from header_command import LIBRARIES, command
import roslib.message
from hypothesis import example, given
from hypothesis import strategies as st
from std_msgs.msg import Float64MultiArray, UInt16MultiArray

from nodekit.message_definitions import (
    SIZES,
    TIMES,
    Constant,
    Field,
    constant_in,
    fields_of,
    parts_of,
)
from serial_link.commands import make_headers
from serial_link.endpoints.types import TypeRefused
from serial_link.headers.cpp_class import CppClass, header, member
from serial_link.headers.wire_header import WIRE_HEADER, WIRE_PATH

HERE = pathlib.Path(__file__).resolve().parents[1]
SOURCES = HERE.parents[1]
#: Every package here that has messages or services, and those of ROS that robots use.
PACKAGES = sorted(
    {path.parents[1].name for kind in ("msg", "srv") for path in SOURCES.glob(f"*/{kind}/*.{kind}")}
    | {"std_msgs", "geometry_msgs", "sensor_msgs"}
)
#: Makes the headers treat this machine as a board with a 4-byte double.
SMALL_DOUBLE = ("-U__SIZEOF_DOUBLE__", "-D__SIZEOF_DOUBLE__=4")
#: Suffixes of the classes of a service.
ENDS = ("", "Request", "Response")
#: Messages of each type that are sent through the board's class.
ROUNDS = 5


def fields(generated: Any) -> Tuple[Field, ...]:
    """Return the fields of a class of genpy's."""
    return fields_of(
        generated._type, parts_of(generated._type, generated._full_text)[generated._type]
    )


def drawn(draw: random.Random, base: str) -> Any:
    """Return a random value; a 64-bit float is representable in 32 bits, as on a board."""
    if base == "string":
        return "".join(draw.choice('aé€ %\\"') for _ in range(draw.randrange(6)))
    if base == "bool":
        return draw.random() < 0.5
    if base in ("float32", "float64"):
        special = [0.0, -0.0, float("inf"), -float("inf"), 1e-42, -1e-45, 3.4028234e38, 1.0]
        value = draw.choice(special) if draw.random() < 0.3 else draw.uniform(-1e6, 1e6)
        return struct.unpack("<f", struct.pack("<f", value))[0]
    if base in TIMES:
        least, kind = (0, genpy.Time) if base == "time" else (-(2**31), genpy.Duration)
        return kind(draw.randrange(least, 2**31), draw.randrange(10**9))
    if base in SIZES:
        bits, signed = 8 * SIZES[base], not base.startswith(("u", "char"))
        return (
            draw.randrange(-(2 ** (bits - 1)), 2 ** (bits - 1))
            if signed
            else draw.getrandbits(bits)
        )
    return filled(draw, roslib.message.get_message_class(base))


def filled(draw: random.Random, generated: Any) -> Any:
    """Return a message with random content."""
    message = generated()
    for field in fields(generated):
        if field.is_array:
            length = draw.randrange(4) if field.length is None else field.length
            value: Any = [drawn(draw, field.base) for _ in range(length)]
            if field.base in ("uint8", "char"):
                value = bytes(value)
        else:
            value = drawn(draw, field.base)
        setattr(message, field.name, value)
    return message


def encoded(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def leaves(value: Any) -> List[str]:
    """Return all that a message holds, in the order of its fields, as the program prints it."""
    if isinstance(value, genpy.Message):
        kinds = [(getattr(value, field.name), field.base) for field in fields(type(value))]
    else:
        return [str(value)]
    found: List[str] = []
    for part, base in kinds:
        elements = list(part) if isinstance(part, (list, tuple, bytes)) else [part]
        if isinstance(part, (list, tuple, bytes)):
            found.append(str(len(elements)))
        for element in elements:
            if "/" in base:
                found += leaves(element)
            elif base in TIMES:
                found += [str(element.secs), str(element.nsecs)]
            elif base == "string":
                found.append(element.encode().hex())
            elif base.startswith("float"):
                found.append(struct.pack("<f", element).hex())
            else:
                found.append(str(int(element)))
    return found


def printer(name: str, one: Tuple[Field, ...]) -> List[str]:
    """Return a C++ function that prints the content of a message, by field name."""
    lines = [f"void show({name} &it) {{", "  (void)it;"]
    for field in one:
        count = f"it.{field.name}_length" if field.length is None else f"{field.length}u"
        place = f"it.{member(field.name)}"
        if field.is_array:
            lines.append(f'  printf("%u ", (unsigned){count});')
            lines.append(f"  for (uint32_t i = 0; i < {count}; i++) show({place}[i]);")
        else:
            lines.append(f"  show({place});")
    return [*lines, "}"]


def constants(name: str, generated: Any) -> List[str]:
    """Return C++ code that compiles only if the constants of a message have their values."""
    found = []
    for line in parts_of(generated._type, generated._full_text)[generated._type].splitlines():
        constant = constant_in(line)
        if constant is not None and constant.base != "string":
            value = getattr(generated, constant.name)
            found.append(f'static_assert({name}::{member(constant.name)} == {int(value)}, "");')
    return found


class Answer(NamedTuple):
    """Return the output of the program for one message."""

    datatype: str
    md5sum: str
    was_read_whole: str
    content: str
    shown: List[str]


PROGRAM = """
#include <stdio.h>
void show(bool x) { printf("%d ", x); }
template <typename Whole> void show(Whole x) { printf("%lld ", (long long)x); }
void show(uint64_t x) { printf("%llu ", (unsigned long long)x); }
void show(float x) {
  for (int i = 0; i < 4; i++) printf("%02x", ((unsigned char *)&x)[i]);
  printf(" ");
}
void show(const char *x) {
  for (; *x; x++) printf("%02x", (unsigned char)*x);
  printf(" ");
}
void show(char *x) { show((const char *)x); }
void show(ros::Time &x) { printf("%u %u ", x.sec, x.nsec); }
void show(ros::Duration &x) { printf("%lld %d ", (long long)x.sec, x.nsec); }
"""
MAIN = """
template <typename Message> void pass(Message &message, unsigned char *in, int length) {
  static unsigned char out[1 << 16];
  int read = message.deserialize(in);
  int written = message.serialize(out);
  printf("%s %s %d ", message.getType(), message.getMD5(), read == length);
  for (int i = 0; i < written; i++) printf("%02x", out[i]);
  printf(" | ");
  show(message);
  printf("\\n");
}
int main() {
  static unsigned char in[1 << 16];
  int which, length;
  while (fread(&which, 4, 1, stdin) && fread(&length, 4, 1, stdin)) {
    if (fread(in, 1, length, stdin) != (size_t)length) return 1;
    switch (which) {
CASES
    }
  }
  return 0;
}
"""


def classes(headers: Dict[str, str]) -> List[Tuple[str, Any]]:
    """Return the C++ name and the class of genpy's of each message, those within others first."""
    found: Dict[str, Any] = {}

    def add(name: str, generated: Any) -> None:
        for field in fields(generated):
            if "/" in field.base:
                add(field.base.replace("/", "::"), roslib.message.get_message_class(field.base))
        found.setdefault(name, generated)

    for path in sorted(headers):
        datatype = path[: -len(".h")]
        message = roslib.message.get_message_class(datatype)
        service = roslib.message.get_service_class(datatype)
        name = datatype.replace("/", "::")
        if message is not None:
            add(name, message)
        if service is not None:
            add(name + "Request", service._request_class)
            add(name + "Response", service._response_class)
    return list(found.items())


class Board:
    """The compiled headers, in a program that decodes messages and prints their content.

    :param headers: by their paths
    :param folder: build folder
    """

    def __init__(self, headers: Dict[str, str], folder: pathlib.Path) -> None:
        self.paths = set(headers)
        self.known = classes(headers)
        make_headers.write(headers, folder / "headers")
        text = [f'#include "{path}"' for path in sorted(headers)] + [PROGRAM]
        for name, generated in self.known:
            text += [*printer(name, fields(generated)), *constants(name, generated)]
        cases = [
            f"      case {number}: {{ static {name} it; pass(it, in, length); break; }}"
            for number, (name, _) in enumerate(self.known)
        ]
        source, self._program = folder / "program.cpp", folder / "program"
        source.write_text("\n".join(text) + MAIN.replace("CASES", "\n".join(cases)))
        includes = [*LIBRARIES, f"-I{folder / 'headers'}"]
        includes += ["-include", "ros/time.h", "-include", "ros/duration.h"]
        command = ["g++", "-std=gnu++11", "-O0", "-Wall", "-Werror", *SMALL_DOUBLE, *includes]
        subprocess.check_call([*command, str(source), "-o", str(self._program)])

    def answers(self, sent: List[Tuple[int, bytes]]) -> List[Answer]:
        """Return its output for messages, each given as the index of its type and its bytes."""
        pieces = [struct.pack("<ii", number, len(payload)) + payload for number, payload in sent]
        said = subprocess.check_output([str(self._program)], input=b"".join(pieces)).decode()
        lines = [line.partition(" | ") for line in said.splitlines()]
        assert len(lines) == len(sent)
        return [Answer(*head.split(" ")[:4], shown.split(" ")[:-1]) for head, _, shown in lines]


@pytest.fixture(scope="module")
def board(tmp_path_factory: "pytest.TempPathFactory") -> Board:
    return Board(make_headers.build_headers(PACKAGES), tmp_path_factory.mktemp("board"))


def test_there_is_a_header_for_each_message_and_service(board: Board) -> None:
    files = [path for kind in ("msg", "srv") for path in SOURCES.glob(f"*/{kind}/*.{kind}")]
    assert {path.suffix for path in files} == {".msg", ".srv"}
    assert {f"{path.parents[1].name}/{path.stem}.h" for path in files} <= board.paths


def test_headers_and_genpy_decode_equally(board: Board) -> None:
    assert len(board.known) > 100
    draw = random.Random(1)
    numbers = list(range(len(board.known))) * ROUNDS
    sent = [(number, filled(draw, board.known[number][1])) for number in numbers]
    answers = board.answers([(number, encoded(message)) for number, message in sent])
    for (number, message), answer in zip(sent, answers):
        name, generated = board.known[number]
        assert answer.md5sum == generated._md5sum, name
        is_part = roslib.message.get_message_class(generated._type) is None  # of a service
        datatype = re.sub("Request$|Response$", "", name) if is_part else name
        assert answer.datatype.replace("/", "::") == datatype
        assert answer.was_read_whole == "1", name
        assert answer.content == encoded(message).hex(), name
        assert answer.shown == leaves(message), name


def test_array_of_more_than_255_elements_arrives_whole(board: Board) -> None:
    which = [name for name, _ in board.known].index("std_msgs::UInt16MultiArray")
    message = UInt16MultiArray(data=list(range(1000)))
    (answer,) = board.answers([(which, encoded(message))])
    assert (answer.content, answer.shown) == (encoded(message).hex(), leaves(message))


@example([1.0 + 3.0 * 2.0**-24, 3.4028235677973366e38])  # in the middle of two
@given(st.lists(st.one_of(st.floats(), st.floats(-1e-37, 1e-37)), min_size=1, max_size=200))
def test_of_64_bits_a_board_takes_the_nearest_of_32(board: Board, numbers: List[float]) -> None:
    names = [name for name, _ in board.known]
    which = names.index("std_msgs::Float64")
    answers = board.answers([(which, struct.pack("<d", number)) for number in numbers])
    with numpy.errstate(over="ignore"):
        nearest = [numpy.float32(number) for number in numbers]
    got = [struct.unpack("<f", bytes.fromhex(answer.shown[0]))[0] for answer in answers]
    assert repr([float(one) for one in nearest]) == repr(got)


DOUBLES = """
#include <stdio.h>
#include <stdlib.h>
static int allocations = 0;
static void *counted(void *memory, size_t size) { allocations++; return realloc(memory, size); }
#define realloc counted
#include "../std_msgs/Bool.h"
#include "../std_msgs/Float64MultiArray.h"
#include "../std_msgs/String.h"
int main() {
  static unsigned char in[1 << 16] = {2};
  std_msgs::Bool is_on;
  is_on.deserialize(in);
  std_msgs::String text;
  if (!is_on.data || *text.data) return 3;
  text.data = NULL;
  if (text.serialize(in) != 4) return 4;
  std_msgs::Float64MultiArray it;
  it.st_data = 0.5;
  int length = fread(in, 1, sizeof in, stdin);
  if (it.deserialize(in) != length || sizeof it.st_data != 8) return 1;
  double *room = it.data;
  in[8] = 1;  // number of elements
  it.deserialize(in);
  if (it.data_length != 1) return 5;
  in[8] = 5;
  it.deserialize(in);
  // Or the memory of a board would soon be full.
  if (it.data != room || allocations != 1) return 2;
  fwrite(it.data, 8, it.data_length, stdout);
  static unsigned char out[1 << 16];
  if (it.serialize(out) != length) return 7;
  fwrite(out + length - 40, 8, 5, stdout);
  unsigned char one[4] = {1}, two[4] = {2};
  static_assert(sizeof it.data_room == sizeof(size_t), "2 bytes on an AVR");
  uint32_t length_now;
  size_t capacity = 0;
  int *elements;
  serial_link::get_length(one, length_now, capacity, elements);
  elements[0] = 7;  // what an element owns is not lost when the array grows
  serial_link::get_length(two, length_now, capacity, elements);
  return elements[0] == 7 && elements[1] == 0 ? 0 : 6;
}
"""


def test_64_bits_are_kept_on_capable_board(tmp_path: pathlib.Path) -> None:
    make_headers.write(make_headers.build_headers(["std_msgs"]), tmp_path)
    (tmp_path / "test").mkdir()
    (tmp_path / "test" / "program.cpp").write_text(DOUBLES)
    command = ["g++", "-std=gnu++11", "-Wall", "-Werror", *LIBRARIES, "test/program.cpp"]
    subprocess.check_call(command, cwd=str(tmp_path))
    numbers = [0.1, -0.0, 1e300, 5e-324, 1.0 / 3.0]
    payload = encoded(Float64MultiArray(data=numbers))
    got = subprocess.check_output([str(tmp_path / "a.out")], input=payload)
    assert got == 2 * struct.pack("<5d", *numbers)


def test_headers_yield_to_rosserial_include_guards() -> None:
    one = CppClass("Odd", "odd/Odd", "0", (), ())
    assert "#ifndef _ROS_odd_Odd_h" in header("odd", "Odd", [one])
    service = header("odd", "Odd", [one], service=True)
    assert "#if !defined(_ROS_SERVICE_Odd_h) ||" in service
    assert "#define _ROS_SERVICE_Odd_h" in service


SERVICES = """
#define _ROS_SERVICE_Odd_h  // by a header of rosserial's: this one gives way
#include "first/Odd.h"
namespace first { class Odd {}; }
#include "first/Empty.h"
#include "second/Empty.h"
#include "second/Empty.h"
int main() {
  first::Empty::Request one;
  second::Empty::Request other;
  return sizeof one != sizeof other;
}
"""


def test_services_of_same_name_in_two_packages_coexist(tmp_path: pathlib.Path) -> None:
    headers = {WIRE_PATH: WIRE_HEADER}
    for package, name in (("first", "Empty"), ("second", "Empty"), ("first", "Odd")):
        parts = [CppClass(name + end, f"{package}/{name}", "0", (), ()) for end in ENDS[1:]]
        headers[f"{package}/{name}.h"] = header(package, name, parts, service=True)
    make_headers.write(headers, tmp_path)
    (tmp_path / "program.cpp").write_text(SERVICES)
    command = ["g++", "-std=gnu++11", "-Wall", "-Werror", "-I.", *LIBRARIES]
    subprocess.check_call([*command, "program.cpp", "-o", "program"], cwd=str(tmp_path))
    subprocess.check_call([str(tmp_path / "program")])


#: Keywords and alternative tokens of C++11.
KEYWORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t class
compl const const_cast constexpr continue decltype default delete do double dynamic_cast else enum
explicit export extern false float for friend goto if inline int long mutable namespace new noexcept
not not_eq nullptr operator or or_eq private protected public register reinterpret_cast return short
signed sizeof static static_assert static_cast struct switch template this thread_local throw true
try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq
""".split()


@pytest.mark.parametrize("kind", [(False, None), (True, 3), (True, None)])
def test_field_or_constant_may_have_the_name_of_a_keyword(
    kind: Any, tmp_path: pathlib.Path
) -> None:
    names = tuple(Field("bool", *kind, word) for word in KEYWORDS)
    constants = tuple(Constant("bool", word, "1") for word in KEYWORDS)
    parts = [
        CppClass("Odd", "odd/Odd", "0", (), names),
        CppClass("Constants", "odd/Odd", "0", constants, ()),
    ]
    text = header("odd", "Odd", parts)
    make_headers.write({WIRE_PATH: WIRE_HEADER, "odd/Odd.h": text}, tmp_path)
    (tmp_path / "program.cpp").write_text('#include "odd/Odd.h"\nodd::Odd it;\n')
    command = ["g++", "-std=gnu++11", "-fsyntax-only", "-Wall", "-Werror", "-I.", *LIBRARIES]
    subprocess.check_call([*command, "program.cpp"], cwd=str(tmp_path))
    assert all(f"{member(word)}" == f"{word}_" for word in KEYWORDS)


MACROS = """
#include <stdlib.h>
// As in Arduino.h.
#define max(a, b) ((a) > (b) ? (a) : (b))
#define degrees(rad) ((rad) * 57.3)
#include "odd/Odd.h"
int main() { return odd::Odd().max_length; }
"""


def test_field_may_have_the_name_of_a_macro_of_arduino(tmp_path: pathlib.Path) -> None:
    kinds = (Field("bool", True, None, "max"), Field("string", False, None, "degrees"))
    text = header("odd", "Odd", [CppClass("Odd", "odd/Odd", "0", (), kinds)])
    make_headers.write({WIRE_PATH: WIRE_HEADER, "odd/Odd.h": text}, tmp_path)
    (tmp_path / "program.cpp").write_text(MACROS)
    command = ["g++", "-std=gnu++11", "-fsyntax-only", "-Wall", "-Werror", "-I.", *LIBRARIES]
    subprocess.check_call([*command, "program.cpp"], cwd=str(tmp_path))


TEXTS = """
#include "odd/Odd.h"
int main() {
  static char one[] = "one", two[] = "two";
  static char *texts[] = {one, two};
  odd::Odd it, other;
  it.names = texts;
  it.names_length = 2;
  it.st_names = it.pair[0] = (char *)"literal";
  it.pair[1] = texts[1];
  it.text = "constant";
  static unsigned char buffer[100];
  int length = it.serialize(buffer);
  if (other.deserialize(buffer) != length || other.names_length != 2) return 1;
  *other.names[1] = 'T';  // it is in the buffer
  bool are_same = !strcmp(other.names[0], "one") && !strcmp(other.pair[0], "literal");
  return are_same && !strcmp(other.names[1], "Two") && !strcmp(other.text, "constant") ? 0 : 2;
}
"""


def test_texts_of_an_array_are_pointers_as_those_of_rosserial(tmp_path: pathlib.Path) -> None:
    kinds = [(True, None, "names"), (True, 2, "pair"), (False, None, "text")]
    texts = tuple(Field("string", *kind) for kind in kinds)
    text = header("odd", "Odd", [CppClass("Odd", "odd/Odd", "0", (), texts)])
    make_headers.write({WIRE_PATH: WIRE_HEADER, "odd/Odd.h": text}, tmp_path)
    (tmp_path / "program.cpp").write_text(TEXTS)
    command = ["g++", "-std=gnu++11", "-Wall", "-Werror", "-I.", *LIBRARIES]
    subprocess.check_call([*command, "program.cpp", "-o", "program"], cwd=str(tmp_path))
    subprocess.check_call([str(tmp_path / "program")])


@pytest.mark.parametrize(
    "base, value, expected",
    [
        ("string", 'say "hi" \\ #', 'static const char *IT() { return "say \\"hi\\" \\\\ #"; }'),
        ("bool", "True", "static constexpr bool IT = 1;"),
        ("bool", "2", "static constexpr bool IT = 1;"),
        ("bool", "False", "static constexpr bool IT = 0;"),
        ("bool", "0", "static constexpr bool IT = 0;"),
        ("int8", "-3", "static constexpr int8_t IT = -3;"),
        ("uint8", "007", "static constexpr uint8_t IT = 7;"),
        ("byte", "-3", "static constexpr int8_t IT = -3;"),
        ("char", "65", "static constexpr uint8_t IT = 65;"),
        ("uint64", str(2**63), f"static constexpr uint64_t IT = {2**63};"),
        ("float32", "2", "static constexpr float IT = 2.0;"),
        ("float64", "-1e-3", "static constexpr serial_link::float64 IT = -0.001;"),
    ],
)
def test_constants_have_the_type_and_value_of_the_definition(
    base: str, value: str, expected: str
) -> None:
    constant = Constant(base, "IT", value)
    text = header("odd", "Odd", [CppClass("Odd", "odd/Odd", "0", (constant,), ())])
    assert f"  {expected}" in text.splitlines()


def test_header_of_a_message_with_a_time_includes_that_of_the_library() -> None:
    one = CppClass("Odd", "odd/Odd", "0", (), (Field("time", False, None, "stamp"),))
    lines = header("odd", "Odd", [one]).splitlines()
    assert '#include "ros/time.h"' in lines and '#include "ros/duration.h"' not in lines


def test_command_writes_headers_for_sketch(tmp_path: pathlib.Path) -> None:
    done = command("pid_control", "robot_custom_interfaces", "--into", str(tmp_path / "made"))
    assert (done.returncode, done.stderr) == (0, "")
    paths = sorted(str(path.relative_to(tmp_path / "made")) for path in tmp_path.rglob("*.h"))
    assert done.stdout == f"{len(paths)} headers are in {tmp_path / 'made'}\n"
    # Nested types are included.
    assert paths == [
        "pid_control/motor_input.h",
        "pid_control/motor_output.h",
        "pid_control/set_point.h",
        "robot_custom_interfaces/RobotStatus.h",
        "serial_link/wire.h",
        "std_msgs/Header.h",
    ]


def test_headers_are_in_the_folder_of_the_help_by_default(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["make_headers", "std_msgs"])
    monkeypatch.setattr(make_headers, "build_headers", lambda packages: {"a/B.h": "text"})
    make_headers.main()
    assert (tmp_path / "ros_headers" / "a" / "B.h").read_text() == "text"


def test_misspelt_option_is_refused(
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["make_headers", "std_msgs", "--arduinos"])
    with pytest.raises(SystemExit):
        make_headers.main()
    assert "unrecognized arguments: --arduinos" in capsys.readouterr().err


def test_types_within_a_service_are_included() -> None:
    found: Dict[str, str] = {}
    make_headers._add_service(found, "lifecycle_msgs/GetState")
    assert set(found) == {"lifecycle_msgs/GetState.h", "lifecycle_msgs/State.h"}


def test_package_that_is_not_built_is_named(monkeypatch: "pytest.MonkeyPatch") -> None:
    refused = mock.Mock(side_effect=TypeRefused("is std_msgs built and sourced?"))
    monkeypatch.setattr(make_headers, "message_class", refused)
    with pytest.raises(make_headers.HeaderError, match="is std_msgs built and sourced"):
        make_headers.build_headers(["std_msgs"])


@pytest.mark.parametrize(
    "arguments, why",
    [
        (["missing"], "package missing not found"),
        (["nodekit"], "nodekit has neither messages nor services"),
        (["std_srvs", "--into", "/dev/null/x"], "cannot write /dev/null/x/serial_link: "),
        (["std_srvs", "--into", "x.zip"], "x.zip is a zip file: add --arduino"),
        (["std_srvs", "--arduino", "--into", "/dev/null/x.zip"], "cannot write /dev/null/x.zip: "),
    ],
)
def test_command_reports_why_it_fails(arguments: List[str], why: str) -> None:
    done = command(*arguments)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"make_headers: {why}")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "option, start, part",
    [
        ("--help", "usage: make_headers [-h]", "a library, ros_messages,"),
        ("--version", "make_headers of serial_link ", ""),
    ],
)
def test_help_has_the_name_of_the_library_and_the_version_that_of_the_package(
    option: str,
    start: str,
    part: str,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    monkeypatch.setattr("sys.argv", ["make_headers", option])
    with pytest.raises(SystemExit):
        make_headers.main()
    words = capsys.readouterr().out
    assert words.startswith(start) and part in words
