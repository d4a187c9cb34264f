"""Lookup of a talker's message, and its default."""

import xmlrpc.client

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.message_scope import SCOPES, as_text, candidates, message_text

KEYS = candidates("/Group1/talker")
PRIVATE, LOCAL, GLOBAL = KEYS
EVERYWHERE = {PRIVATE: "private text", LOCAL: "local text", GLOBAL: "global text"}


def without(*keys):
    """Return the texts that are left when some are not set."""
    return {key: text for key, text in EVERYWHERE.items() if key not in keys}


@pytest.mark.parametrize(
    "node, expected",
    [
        ("/talker", ["/talker/Message", "/Message"]),
        ("/Group1/talker", ["/Group1/talker/Message", "/Group1/Message", "/Message"]),
        ("/a/b/c", ["/a/b/c/Message", "/a/b/Message", "/a/Message", "/Message"]),
    ],
)
def test_candidates_go_from_the_node_outwards(node, expected):
    assert candidates(node) == expected


def test_candidates_of_another_parameter():
    assert candidates("/talker", "Text") == ["/talker/Text", "/Text"]


@pytest.mark.parametrize("scope, key", [("private", PRIVATE), ("local", LOCAL), ("global", GLOBAL)])
def test_a_scope_looks_in_its_own_place_only(scope, key):
    assert message_text(EVERYWHERE, KEYS, scope) == EVERYWHERE[key]
    assert message_text(without(key), KEYS, scope) == "No Parameter Found"
    assert message_text({}, KEYS, scope) == "No Parameter Found"


def test_local_equals_global_without_namespace():
    keys = candidates("/talker")
    for scope in ("local", "global"):
        assert message_text({"/Message": "hi"}, keys, scope) == "hi"


def test_closest_goes_outwards_to_the_first_that_is_set():
    assert message_text(EVERYWHERE, KEYS, "closest") == "private text"
    assert message_text(without(PRIVATE), KEYS, "closest") == "local text"
    assert message_text(without(PRIVATE, LOCAL), KEYS, "closest") == "global text"
    assert message_text({}, KEYS, "closest") == "hello world"


@pytest.mark.parametrize("scope", SCOPES)
def test_an_empty_text_is_a_text(scope):
    found = {**EVERYWHERE, PRIVATE: "", LOCAL: "", GLOBAL: ""}
    assert message_text(found, KEYS, scope) == ""


@pytest.mark.parametrize("scope", SCOPES)
def test_unset_value_is_none(scope):
    nothing = dict.fromkeys(KEYS)
    assert message_text(nothing, KEYS, scope) == message_text({}, KEYS, scope)


@given(st.lists(st.text("abc", min_size=1, max_size=3), min_size=1, max_size=5), st.data())
def test_closest_is_the_first_candidate_that_is_set(names, data):
    keys = candidates("/" + "/".join(names))
    assert len(keys) == len(names) + 1
    depth = data.draw(st.integers(0, len(names)))
    assert message_text({key: key for key in keys[depth:]}, keys, "closest") == keys[depth]


@pytest.mark.parametrize(
    "raw, text",
    [
        ("hello", "hello"),
        ("", ""),
        (5, "5"),
        (2.5, "2.5"),
        (True, "True"),
        (xmlrpc.client.Binary("h\u00e9".encode()), "h\u00e9"),
        (xmlrpc.client.Binary(b"\xff"), "\ufffd"),
        ([1, 2], None),
        ([], None),
        ({"a": 1}, None),
        ({}, None),
    ],
)
def test_any_scalar_is_a_message(raw, text):
    assert as_text(raw) == text
