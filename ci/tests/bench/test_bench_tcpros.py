"""Tests of how ci/bench's own node reads and writes TCPROS."""

import struct

import tcpros
from hypothesis import given
from hypothesis import strategies as st
from observers import wait_until

names = st.text("abcdefghij_", min_size=1, max_size=8)


@given(st.dictionaries(names, st.text("abc=/* \n", max_size=20), max_size=6))
def test_headers_come_back_as_they_were(fields):
    encoded = tcpros.encode_header(fields)
    assert struct.unpack_from("<I", encoded) == (len(encoded) - 4,)
    assert tcpros.decode_header(encoded[4:]) == fields


@given(st.lists(st.binary(max_size=20), max_size=10), st.integers(0, 30))
def test_messages_are_whole_wherever_the_stream_is_cut(messages, cut):
    stream = b"".join(struct.pack("<I", len(message)) + message for message in messages)
    found, rest = tcpros.split_messages(stream[:cut])
    more, end = tcpros.split_messages(rest + stream[cut:])
    assert found + more == messages
    assert end == b""


def test_a_port_that_comes_back_is_connected_to_anew(monkeypatch):
    connected = []
    monkeypatch.setattr(tcpros.Node, "_connect", lambda self, topic, uri: connected.append(uri))
    node = tcpros.Node("/node", "http://localhost:1")
    for uris in (["a"], ["a", "b"], ["b"], ["b", "a"]):
        node.publisherUpdate("/master", "/topic", uris)
    node.close()
    wait_until(lambda: len(connected) >= 3, 30.0, "connection")
    assert sorted(connected) == ["a", "a", "b"]
