"""The layouts of the messages on the graph, by type."""

from typing import Any, Dict, Mapping, Optional, Tuple

import roslib.message

from topic_scope.messages.definitions import DefinitionError, Record, layout_of, parse


class Layouts:
    """Looks each type up once."""

    def __init__(self) -> None:
        self._installed: Dict[str, Optional[Record]] = {}
        self._received: Dict[Tuple[str, str], Optional[Record]] = {}
        self._problems: Dict[str, str] = {}

    def installed(self, datatype: str) -> Optional[Record]:
        """Return the layout of a type.

        :param datatype: e.g. ``std_msgs/Float32``
        :returns: its layout; None if its package is not installed, nor a message has come yet
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

    def received(self, header: Mapping[str, str]) -> Optional[Record]:
        """Return the layout of the messages of a connection.

        :param header: what the publisher has said of them
        :returns: their layout, None if its definition is malformed
        """
        key = (header.get("type", ""), header.get("md5sum", ""))
        if key not in self._received:
            try:
                layout: Optional[Record] = parse(key[0], header.get("message_definition", ""))
            except DefinitionError as error:
                layout = None
                self._problems[key[0]] = f"its definition cannot be read: {error}"
            self._received[key] = layout
            if self._installed.get(key[0]) is None:
                self._installed[key[0]] = layout
        return self._received[key]

    def reject(self, header: Mapping[str, str], problem: str) -> None:
        """Have the messages of a connection count as unreadable.

        :param header: what the publisher has said of them
        :param problem: why, in words
        """
        self._received[(header.get("type", ""), header.get("md5sum", ""))] = None
        self._installed[header.get("type", "")] = None
        self._problems[header.get("type", "")] = problem

    def problem(self, datatype: str) -> Optional[str]:
        """Return why the layout of a type is not known, in words; None where nothing has come."""
        return self._problems.get(datatype)
