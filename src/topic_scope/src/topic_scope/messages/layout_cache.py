"""Cache of message layouts by type."""

from typing import Any, Dict, Mapping, Optional, Tuple

import roslib.message

from topic_scope.messages.message_layout import DefinitionError, MessageLayout, layout_of, parse


class Layouts:
    """Layouts of types, each looked up once."""

    def __init__(self) -> None:
        self._installed: Dict[str, Optional[MessageLayout]] = {}
        self._received: Dict[Tuple[str, str], Optional[MessageLayout]] = {}
        self._problems: Dict[str, str] = {}

    def installed(self, datatype: str) -> Optional[MessageLayout]:
        """Return the layout of a type.

        :param datatype: e.g. ``std_msgs/Float32``
        :returns: its layout; None if its package is not installed and no message has been received
        """
        if datatype not in self._installed:
            message_class: Any = None
            try:
                message_class = roslib.message.get_message_class(datatype)
                layout = layout_of(message_class) if message_class else None
            except (DefinitionError, ValueError, ImportError):
                layout = None
            self._installed[datatype] = layout
        return self._installed[datatype]

    def received(self, header: Mapping[str, str]) -> Optional[MessageLayout]:
        """Return the layout of the messages of a connection.

        :param header: connection header of the publisher
        :returns: their layout; None if their definition is malformed
        """
        key = (header.get("type", ""), header.get("md5sum", ""))
        if key not in self._received:
            try:
                layout: Optional[MessageLayout] = parse(
                    key[0], header.get("message_definition", "")
                )
            except DefinitionError as error:
                layout = None
                self._problems[key[0]] = f"its definition cannot be read: {error}"
            self._received[key] = layout
            if self._installed.get(key[0]) is None:
                self._installed[key[0]] = layout
        return self._received[key]

    def reject(self, header: Mapping[str, str], problem: str) -> None:
        """Mark the messages of a connection as unreadable.

        :param header: connection header of the publisher
        :param problem: the reason
        """
        self._received[(header.get("type", ""), header.get("md5sum", ""))] = None
        self._installed[header.get("type", "")] = None
        self._problems[header.get("type", "")] = problem

    def problem(self, datatype: str) -> Optional[str]:
        """Return why the layout of a type is unknown; None if no problem was reported."""
        return self._problems.get(datatype)
