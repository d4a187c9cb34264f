"""Message and service classes of the types that a board names."""

import io
from typing import Any, Tuple

import genpy
import roslib.message


#: Types that a workspace may lack, by a type of the same definition: rosserial's library announces
#: the first.
_SAME = {"tf/tfMessage": "tf2_msgs/TFMessage"}


class TypeRefused(ValueError):
    """A type that this workspace does not have, or has in another form; the text says so."""


class Malformed(ValueError):
    """Bytes that are no message of their type, though their sums held."""


def message_class(datatype: str, md5sum: str) -> Any:
    """Return the class of a message.

    :param datatype: ``package/Name``
    :param md5sum: what the board has of it; ``*`` for any
    :raises TypeRefused: if it is unknown, or has another md5sum
    """
    found = _found(roslib.message.get_message_class, _SAME.get(datatype, datatype))
    _compare(datatype, md5sum, found)
    return found


def service_class(datatype: str, request_md5sum: str, response_md5sum: str) -> Any:
    """Return the class of a service.

    :param datatype: ``package/Name``
    :param request_md5sum: what the board has of its request
    :param response_md5sum: and of its response
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
    :raises Malformed: if these are not exactly one
    """
    try:
        message = data_class().deserialize(payload)
        encoded = encode(message)
        if encoded != payload and not _is_whole(data_class, payload, encoded):
            raise Malformed("not as long as it says")
    except (genpy.DeserializationError, genpy.SerializationError, UnicodeError) as error:
        raise Malformed(str(error)) from None
    return message


def _is_whole(data_class: Any, payload: bytes, encoded: bytes) -> bool:
    """Tell whether bytes that come back otherwise are a message all the same.

    They are where a truth value is neither 0 nor 1, or a text is not UTF-8. But genpy also reads a
    text that is shorter than it says, and leaves bytes over: so one byte more must make no
    difference, and one less must.

    :param encoded: the message that was read from the bytes, as bytes again
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
    :raises genpy.SerializationError: if a field holds what does not fit
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
        raise TypeRefused(f"{datatype} is not known here: is {package} built and sourced?")
    return found


def _compare(what: str, md5sum: str, found: Any) -> None:
    if md5sum not in (found._md5sum, "*"):
        raise TypeRefused(
            f"{what} is another one on the board (md5sum {md5sum}) than here "
            f"({found._md5sum}): make its header for the sketch again"
        )


def md5sums_of(sent: Any, heard: Any, kind: int, server: int) -> Tuple[str, str]:
    """Return the md5sums of a service's request and response.

    :param sent: what the board has told of what it sends
    :param heard: and of what it receives
    :param kind: whether it offers the service or calls it
    :param server: the kind that offers it
    """
    return (heard.md5sum, sent.md5sum) if kind == server else (sent.md5sum, heard.md5sum)
