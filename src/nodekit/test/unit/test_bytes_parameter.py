"""Tests of parameters of bytes: accepted forms, output, and rejected values."""

import xmlrpc.client
from typing import Any

import pytest
import yaml

from nodekit.commands.parameter_table import as_table
from nodekit.parameters.declaration import ParameterError, ParameterSet, StringParameter
from nodekit.parameters.parameter_types import BytesParameter, format_value, to_wire
from nodekit.parameters.reconciler import Observation, Reconciler
from nodekit.parameters.schema import as_yaml, describe, parameter_of


class Lock(ParameterSet):
    """A set with bytes in it."""

    key = BytesParameter(b"\x00\xff", max_length=4, help="what opens it")
    name = StringParameter("door", help="its name")


@pytest.mark.parametrize("raw", [b"", b"\x00abc"])
def test_bytes_are_taken_as_a_list_and_as_xml_rpc_delivers_them(raw: bytes) -> None:
    assert Lock.key.coerce(raw) == Lock.key.coerce(list(raw)) == Lock.key.coerce(tuple(raw)) == raw
    assert Lock.key.coerce(xmlrpc.client.Binary(raw)) == raw
    assert type(Lock.key.coerce(xmlrpc.client.Binary(raw))) is bytes


@pytest.mark.parametrize(
    "raw", [b"12345", [1, 2, 3, 4, 5], "abcd", [256], [-1], [1.0], [True], 5, None, {}, True]
)
def test_other_types_and_too_many_bytes_are_refused(raw: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        Lock(key=raw)
    said = "must be at most 4 bytes, as a list of numbers from 0 to 255"
    assert str(caught.value) == f"parameter key: refused {format_value(raw)}: {said}"


def test_thousand_elements_are_accepted_by_default() -> None:
    assert BytesParameter(b"", help="").coerce(bytes(1000)) == bytes(1000)
    with pytest.raises(ParameterError):
        BytesParameter(b"", help="").coerce(bytes(1001))


def test_binary_value_on_the_server_is_written_back_as_a_list() -> None:
    reconciler = Reconciler(Lock, ())
    held = {"key": to_wire(b"\x00\xff"), "name": "door"}
    reconciler.start(dict(held), 0.0)
    assert reconciler.step(Observation(dict(held)), 1.0).writes == {}
    decision = reconciler.step(Observation({**held, "key": xmlrpc.client.Binary(b"ac")}), 2.0)
    assert (decision.values.key, decision.writes) == (b"ac", {"key": [97, 99]})


def test_a_client_builds_the_same_parameter_from_the_description() -> None:
    entry = yaml.safe_load(as_yaml(describe(Lock())))[0]
    assert (entry["value"], entry["range"], entry["exact"]) == ([0, 255], "at most 4 bytes", True)
    parameter = parameter_of(entry)
    assert type(parameter) is BytesParameter and parameter.max_length == 4
    assert parameter.coerce(entry["default"]) == b"\x00\xff"


def test_a_table_shows_them_as_they_are_typed() -> None:
    row = as_table(describe(Lock()), 80).split("\n")[0]
    assert row.split() == "key = [0, 255] bytes at most 4 bytes what opens it".split()
