"""Message classes of the loop's topics, of the course or of a student, and their value fields."""

from typing import Any, Dict, NamedTuple, Optional, Tuple

from pid_control.msg import motor_input, motor_output, set_point
from pid_control.programs.package_messages import MessageTypeError, class_of

#: The loop's topics, and the course's message of each.
COURSE_CLASSES = {"set_point": set_point, "motor_output": motor_output, "motor_input": motor_input}
_FLOATS = ("float32", "float64")
#: Names of fields that hold a time, not the value.
_TIMES = ("time", "time_x", "stamp", "t", "tm")


class LoopMessage(NamedTuple):
    """Message of a topic of the loop.

    :ivar topic: name of the topic
    :ivar message_class: class of its messages
    :ivar field: name of the field with the value
    """

    topic: str
    message_class: Any
    field: str

    @property
    def is_of_course(self) -> bool:
        """True if the type has the definition of the course."""
        return bool(self.message_class._md5sum == COURSE_CLASSES[self.topic]._md5sum)

    def value(self, message: Any) -> float:
        """Return the value of a message."""
        return float(getattr(message, self.field))

    def filled(self, value: float, time: float, status: str = "") -> Any:
        """Return a message with a value, and with time and status if it has such fields.

        :param value: the value
        :param time: for a field called time that is a float [s]
        :param status: for a field called status that is a string
        """
        message = self.message_class()
        types = _types(self.message_class)
        for name in _TIMES:
            if types.get(name) in _FLOATS:
                setattr(message, name, time)
        if types.get("status") == "string":
            message.status = status
        setattr(message, self.field, value)
        return message


def loop_message(topic: str, message_class: Any, field: Optional[str] = None) -> LoopMessage:
    """Return the message of a topic.

    :param topic: name of the topic
    :param message_class: class of its messages
    :param field: name of the field with the value; by default the first float that is not a time
    :raises MessageTypeError: if the class has no such field
    """
    types = _types(message_class)
    floats = [name for name, field_type in types.items() if field_type in _FLOATS]
    values = [name for name in floats if name not in _TIMES] or floats
    chosen = field or (values[0] if values else "")
    if chosen not in floats:
        fields = ", ".join(f"{field_type} {name}" for name, field_type in types.items()) or "none"
        wanted = f"float field {field}" if field else "float field"
        raise MessageTypeError(
            f"{topic}: {message_class._type} has no {wanted}; its fields are: {fields}"
        )
    return LoopMessage(topic, message_class, chosen)


def course_messages() -> Dict[str, LoopMessage]:
    """Return the messages of the course by topic."""
    return {topic: loop_message(topic, one) for topic, one in COURSE_CLASSES.items()}


def given_message(topic: str, text: str, own: Dict[str, Any]) -> LoopMessage:
    """Return the message that an option names.

    :param topic: name of the topic
    :param text: ``PACKAGE/TYPE`` or ``PACKAGE/TYPE/FIELD``
    :param own: classes of the student's package by type
    :raises MessageTypeError: if there is no such type or field
    """
    parts = text.split("/")
    if len(parts) not in (2, 3):
        raise MessageTypeError(f"{topic}: must be PACKAGE/TYPE/FIELD ({text})")
    msg_type = "/".join(parts[:2])
    return loop_message(
        topic, class_of(topic, msg_type, own), parts[2] if len(parts) == 3 else None
    )


def _types(message_class: Any) -> Dict[str, str]:
    slots: Tuple[str, ...] = tuple(message_class.__slots__)
    return dict(zip(slots, message_class._slot_types))
