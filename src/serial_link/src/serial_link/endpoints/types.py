"""Message and service classes for the type names that a board announces."""

import io
from typing import Any, Tuple

import genpy
import roslib.message


#: Types that a workspace may lack, with a type of the same definition: rosserial's library uses
#: the first.
_SAME = {"tf/tfMessage": "tf2_msgs/TFMessage"}


class TypeRefused(ValueError):
    """A type that is not installed, or has another md5sum; the text gives the reason."""


class MalformedMessage(ValueError):
    """Bytes with valid checksums that are not a message of their type."""


def message_class(datatype: str, md5sum: str) -> Any:
    """Return the class of a message.

    :param datatype: ``package/Name``
    :param md5sum: of the board's header; ``*`` for any
    :raises TypeRefused: if it is unknown, or has another md5sum
    """
    found = _found(roslib.message.get_message_class, _SAME.get(datatype, datatype))
    _compare(datatype, md5sum, found)
    return found


def service_class(datatype: str, request_md5sum: str, response_md5sum: str) -> Any:
    """Return the class of a service.

    :param datatype: ``package/Name``
    :param request_md5sum: of its request, on the board
    :param response_md5sum: of its response, on the board
    :raises TypeRefused: if it is unknown, or has another md5sum
    """
    found = _found(roslib.message.get_service_class, datatype)
    _compare(f"the request of {datatype}", request_md5sum, found._request_class)
    _compare(f"the response of {datatype}", response_md5sum, found._response_class)
    return found


def decode(data_class: Any, payload: bytes) -> Any:
    """Return a message.

    :param data_class: its class
    :param payload: its bytes
    :raises MalformedMessage: if the bytes are not exactly one message
    """
    try:
        message = data_class().deserialize(payload)
        encoded = encode(message)
        if encoded != payload and not _is_whole(data_class, payload, encoded):
            raise MalformedMessage(f"{data_class._type}: wrong length ({len(payload)} bytes)")
    except (genpy.DeserializationError, genpy.SerializationError, UnicodeError) as error:
        raise MalformedMessage(str(error)) from None
    return message


def _is_whole(data_class: Any, payload: bytes, encoded: bytes) -> bool:
    """Return whether bytes that do not survive a round trip are still a valid message.

    A Boolean may be neither 0 nor 1, and a string may not be UTF-8. But genpy also accepts a string
    that is shorter than its length, and surplus bytes. So with one byte more the message must be
    the same, and with one byte less it must not.

    :param encoded: the decoded message, encoded again
    """
    if encode(data_class().deserialize(payload + b"\0")) != encoded:
        return False
    try:
        return encode(data_class().deserialize(payload[:-1])) != encoded
    except genpy.DeserializationError:
        return True


def encode(message: Any) -> bytes:
    """Return the bytes of a message.

    :param message: of any class
    :raises genpy.SerializationError: if a field has an invalid value
    """
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def _found(lookup: Any, datatype: str) -> Any:
    try:
        found = lookup(datatype)
    except (ImportError, AttributeError, ValueError):
        found = None
    if found is None:
        package = datatype.partition("/")[0]
        raise TypeRefused(f"{datatype} not found: is {package} built and sourced?")
    return found


def _compare(what: str, md5sum: str, found: Any) -> None:
    if md5sum not in (found._md5sum, "*"):
        raise TypeRefused(
            f"{what} differs on the board (md5sum {md5sum}) and here "
            f"({found._md5sum}): generate the sketch's headers again"
        )


def md5sums_of(sent: Any, received: Any, kind: int, server: int) -> Tuple[str, str]:
    """Return the md5sums of a service's request and response.

    :param sent: info of the messages that the board sends
    :param received: info of the messages that the board receives
    :param kind: whether the board offers the service or calls it
    :param server: the kind that offers it
    """
    return (received.md5sum, sent.md5sum) if kind == server else (sent.md5sum, received.md5sum)
