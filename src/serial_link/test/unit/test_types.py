"""The types that a board names, and bytes that are no message of them."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from std_msgs.msg import Bool, Float32MultiArray, Header, String, UInt8MultiArray
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from serial_link.endpoints.types import (
    MalformedMessage,
    TypeRefused,
    decode,
    encode,
    md5sums_of,
    message_class,
    service_class,
)
from serial_link.negotiation.payloads import SERVICE_CLIENT, SERVICE_SERVER, TopicInfo


def test_class_is_found_if_md5sum_matches() -> None:
    assert message_class("std_msgs/Bool", Bool._md5sum) is Bool
    assert message_class("std_msgs/Bool", "*") is Bool
    sums = SetBool._request_class._md5sum, SetBool._response_class._md5sum
    assert service_class("std_srvs/SetBool", *sums) is SetBool


def test_transforms_of_rosserials_library_are_those_of_tf2() -> None:
    assert message_class("tf/tfMessage", "94810edda583a504dfda3829e70d7eec") is TFMessage
    with pytest.raises(TypeRefused, match="differs on the board"):
        message_class("tf/tfMessage", "0" * 32)


@pytest.mark.parametrize("name", ["no_such_msgs/Bool", "std_msgs/NoSuch", "std_msgs"])
def test_missing_type_is_rejected_with_message(name: str) -> None:
    with pytest.raises(
        TypeRefused, match=f"{name} not found: is {name.partition('/')[0]} built and sourced"
    ):
        message_class(name, "0" * 32)
    with pytest.raises(TypeRefused, match="not found"):
        service_class(name, "0" * 32, "0" * 32)


def test_different_type_is_rejected_with_both_md5sums() -> None:
    with pytest.raises(TypeRefused, match=f"std_msgs/Bool differs .*{'0' * 32}.*{Bool._md5sum}"):
        message_class("std_msgs/Bool", "0" * 32)
    request, response = Trigger._request_class._md5sum, Trigger._response_class._md5sum
    with pytest.raises(TypeRefused, match="the request of std_srvs/Trigger differs"):
        service_class("std_srvs/Trigger", "0" * 32, response)
    with pytest.raises(TypeRefused, match="the response of std_srvs/Trigger differs"):
        service_class("std_srvs/Trigger", request, "0" * 32)


def test_service_md5sums_are_from_board_view() -> None:
    sent, heard = (TopicInfo(125, "a", "b/C", text * 32, 512) for text in "sh")
    assert md5sums_of(sent, heard, SERVICE_SERVER, SERVICE_SERVER) == ("h" * 32, "s" * 32)
    assert md5sums_of(sent, heard, SERVICE_CLIENT, SERVICE_SERVER) == ("s" * 32, "h" * 32)


@given(st.text(st.characters(blacklist_categories=["Cs"])), st.lists(st.floats(width=32)))
def test_messages_survive_round_trip(text: str, numbers: "list[float]") -> None:
    for message in (String(text), Float32MultiArray(data=numbers), Header(frame_id=text)):
        payload = encode(message)
        assert encode(decode(type(message), payload)) == payload


@given(st.binary(max_size=60))
def test_any_bytes_are_decoded_or_rejected(payload: bytes) -> None:
    for data_class in (Bool, String, Header, UInt8MultiArray, Float32MultiArray):
        try:
            decode(data_class, payload)
        except MalformedMessage:
            pass


@given(st.text(min_size=1), st.data())
def test_message_of_wrong_length_is_rejected(text: str, data: st.DataObject) -> None:
    payload = encode(String(text.encode("utf-8", "replace").decode()))
    cut = data.draw(st.integers(0, len(payload) - 1))
    for wrong in (payload[:cut], payload + b"\0"):
        with pytest.raises(MalformedMessage):
            decode(String, wrong)


def test_message_that_encodes_differently_is_accepted() -> None:
    assert decode(Bool, b"\2").data
    assert decode(String, struct.pack("<I", 2) + b"\xb0C").data == "\ufffdC"
