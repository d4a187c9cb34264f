"""Messages of a student's own package, generated for Python if need be."""

import contextlib
import io
import os
import re
from typing import Any, Dict, List, NamedTuple
from xml.etree import ElementTree

import genmsg
import genpy.dynamic
import genpy.generate_initpy
import genpy.generator
import rospkg

from pid_control.runner.controller_command import ControllerCommand
from pid_control.runner.loop_messages import (
    COURSE_CLASSES,
    LoopMessage,
    MessageTypeError,
    course_messages,
    loop_message,
)

#: Package that the course's messages are in, in a student's workspace too.
_COURSE = "pid_control"
#: Legal name of a package that has messages: it becomes a folder, and a name in Python.
_LEGAL = re.compile("[A-Za-z][A-Za-z0-9_]*")
_INIT = "import pkgutil\n\n__path__ = pkgutil.extend_path(__path__, __name__)\n"


class StudentMessages(NamedTuple):
    """Messages of a student's package.

    :ivar command: the controller's command, with an environment that has the messages
    :ivar classes: classes by type, ``PACKAGE/TYPE``
    :ivar by_topic: message of each topic of the loop, the course's if the package has none
    """

    command: ControllerCommand
    classes: Dict[str, Any]
    by_topic: Dict[str, LoopMessage]


def read_messages(command: ControllerCommand, scratch: str) -> StudentMessages:
    """Read the messages of a controller's package.

    :param command: the controller's command
    :param scratch: folder for generated Python modules
    :raises MessageTypeError: if the message of a topic has no float field, or the name of the
        package is illegal
    """
    texts = _definitions(command.package)
    name = _name(command.package) if texts else ""
    if not texts or not name or _is_own(command.package):
        return StudentMessages(command, {}, course_messages())
    if not _LEGAL.fullmatch(name):
        raise MessageTypeError(
            "package.xml: <name> must be letters, digits and _, with a letter first"
            f" ({name[:80]!r})"
        )
    notes: List[str] = []
    if name == _COURSE:
        for topic, course_class in COURSE_CLASSES.items():
            if not texts.get(topic, "").strip():
                texts[topic] = str(course_class._full_text)
                notes.append(f"{topic}.msg is empty or missing; the judge's is used")
    classes = _generated(name, texts, scratch)
    if not classes:
        note = f"the messages of {name} cannot be generated"
        return StudentMessages(_with_notes(command, [note]), {}, course_messages())
    by_topic = course_messages()
    for topic in by_topic:
        kind = f"{name}/{topic}"
        if kind in classes:
            by_topic[topic] = loop_message(topic, classes[kind])
    notes += [describe(one) for one in by_topic.values() if not one.is_of_course]
    path = os.pathsep.join(filter(None, [scratch, command.environment.get("PYTHONPATH")]))
    environment = {**command.environment, "PYTHONPATH": path}
    return StudentMessages(
        _with_notes(command._replace(environment=environment), notes), classes, by_topic
    )


def describe(message: LoopMessage) -> str:
    """Return the text of a note on a message that is not the course's, with both definitions."""
    own, course = message.message_class, COURSE_CLASSES[message.topic]
    return (
        f"{message.topic} is {own._type} with {_fields(own)}, where the course has"
        f" {_fields(course)}; the field {message.field} is used"
    )


def _fields(message_class: Any) -> str:
    pairs = zip(message_class._slot_types, message_class.__slots__)
    return "(" + ", ".join(f"{kind} {name}" for kind, name in pairs) + ")"


def _with_notes(command: ControllerCommand, notes: List[str]) -> ControllerCommand:
    return command._replace(notes=[*command.notes, *notes])


def _definitions(package: str) -> Dict[str, str]:
    """Return the texts of a package's messages by name."""
    found: Dict[str, str] = {}
    folder = os.path.join(package, "msg")
    if package and os.path.isdir(folder):
        for name in sorted(os.listdir(folder)):
            if name.endswith(".msg"):
                with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
                    found[name[: -len(".msg")]] = file.read()
    return found


def _name(package: str) -> str:
    with contextlib.suppress(OSError, ElementTree.ParseError):
        return (
            ElementTree.parse(os.path.join(package, "package.xml")).findtext("name") or ""
        ).strip()
    return ""


def _is_own(package: str) -> bool:
    """Return True for the package of this judge."""
    with contextlib.suppress(rospkg.ResourceNotFound):
        own = rospkg.RosPack().get_path(_COURSE)
        here = os.path.realpath(__file__)
        return os.path.realpath(package) == os.path.realpath(own) and here.startswith(
            os.path.realpath(own) + os.sep
        )
    return False


def _generated(name: str, texts: Dict[str, str], scratch: str) -> Dict[str, Any]:
    """Generate Python modules, and return the classes by type; empty if that fails."""
    source, target = os.path.join(scratch, name, "definitions"), os.path.join(scratch, name, "msg")
    os.makedirs(source)
    paths = []
    for message, text in texts.items():
        paths.append(os.path.join(source, message + ".msg"))
        with open(paths[-1], "w", encoding="utf-8") as file:
            file.write(text)
    with open(os.path.join(scratch, name, "__init__.py"), "w", encoding="utf-8") as file:
        file.write(_INIT)
    places = rospkg.RosPack()
    search = {package: [os.path.join(places.get_path(package), "msg")] for package in places.list()}
    search[name] = [source]
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            status = genpy.generator.MsgGenerator().generate_messages(name, paths, target, search)
        if status != 0:
            return {}
        genpy.generate_initpy.write_modules(target)
        return {f"{name}/{message}": _class(f"{name}/{message}", search) for message in texts}
    except (genmsg.InvalidMsgSpec, genmsg.MsgGenerationException, OSError):
        return {}


def _class(kind: str, search: Dict[str, List[str]]) -> Any:
    context = genmsg.MsgContext.create_default()
    spec = genmsg.load_msg_by_type(context, kind, search)
    genmsg.load_depends(context, spec, search)
    text = genmsg.compute_full_text(context, spec)
    return genpy.dynamic.generate_dynamic(kind, text)[kind]
