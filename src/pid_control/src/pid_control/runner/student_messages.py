"""Messages of a student's own package, generated for Python if necessary."""

import contextlib
import os
from typing import Any, Dict, List, NamedTuple

import rospkg

from pid_control.programs.package_messages import (
    check_legal,
    definitions,
    generate,
    package_name,
)
from pid_control.programs.program_command import ProgramCommand
from pid_control.runner.loop_messages import (
    COURSE_CLASSES,
    LoopMessage,
    course_messages,
    loop_message,
)

#: Package with the course's messages, in a student's workspace too.
_COURSE = "pid_control"


class StudentMessages(NamedTuple):
    """Messages of a student's package.

    :ivar command: the controller's command, with an environment that has the messages
    :ivar classes: classes by type, ``PACKAGE/TYPE``
    :ivar by_topic: message of each topic of the loop, the course's if the package has none
    """

    command: ProgramCommand
    classes: Dict[str, Any]
    by_topic: Dict[str, LoopMessage]


def read_messages(command: ProgramCommand, scratch: str) -> StudentMessages:
    """Read the messages of a controller's package.

    :param command: the controller's command
    :param scratch: folder for generated Python modules
    :raises MessageTypeError: if the message of a topic has no float field, or the name of the
        package is illegal
    """
    texts = definitions(command.package)
    name = package_name(command.package) if texts else ""
    if not texts or not name or _is_own(command.package):
        return StudentMessages(command, {}, course_messages())
    check_legal(name)
    notes: List[str] = []
    if name == _COURSE:
        for topic, course_class in COURSE_CLASSES.items():
            if not texts.get(topic, "").strip():
                texts[topic] = str(course_class._full_text)
                notes.append(f"{topic}.msg is empty or missing; the judge's is used")
    classes = generate(name, texts, scratch)
    if not classes:
        note = f"the messages of {name} cannot be generated"
        return StudentMessages(_with_notes(command, [note]), {}, course_messages())
    by_topic = course_messages()
    for topic in by_topic:
        msg_type = f"{name}/{topic}"
        if msg_type in classes:
            by_topic[topic] = loop_message(topic, classes[msg_type])
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
        f"{message.topic} is {own._type} with {_fields(own)}, in the course"
        f" {_fields(course)}; the field {message.field} is used"
    )


def _fields(message_class: Any) -> str:
    pairs = zip(message_class._slot_types, message_class.__slots__)
    return "(" + ", ".join(f"{field_type} {name}" for field_type, name in pairs) + ")"


def _with_notes(command: ProgramCommand, notes: List[str]) -> ProgramCommand:
    return command._replace(notes=[*command.notes, *notes])


def _is_own(package: str) -> bool:
    """Return True for the package of this judge."""
    with contextlib.suppress(rospkg.ResourceNotFound):
        own = rospkg.RosPack().get_path(_COURSE)
        here = os.path.realpath(__file__)
        return os.path.realpath(package) == os.path.realpath(own) and here.startswith(
            os.path.realpath(own) + os.sep
        )
    return False
