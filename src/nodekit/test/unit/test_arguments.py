"""Tests of the validation of command line and environment before a node starts."""

import os
import re
import subprocess
import sys

import pytest

from nodekit.master import MasterClient, MasterUnreachable
from nodekit.node.name_rules import IllegalName
from nodekit.process.arguments import ArgumentError, check, misspelt_settings, surprising_values
from nodekit.testing.processes import Master, Process

URI = "http://localhost:11311"


@pytest.mark.parametrize(
    "argument",
    ["_rate:=5", "_on:=true", "_text:=a: b", "_x:=[1, {a: .nan}]", "_empty:=", "x:=y", "5"],
)
def test_valid_arguments_give_no_warning(argument):
    check("node", {}, ["node.py", argument])


@pytest.mark.parametrize(
    "argument",
    [
        '_amplitude:={a: [1"',
        "_amplitude:=99999999999",
        "_amplitude:=null",
        "_amplitude:=2020-01-01",
        "_amplitude:={1: 2}",
        '_amplitude:="\\x01"',
        "_amplitude:=1:=2",
    ],
)
def test_parameter_that_the_server_cannot_take_is_named(argument):
    sentence = re.escape(f"argument '{argument}': must have one YAML value")
    with pytest.raises(ArgumentError, match="^" + sentence):
        check("node", {}, ["node.py", "_rate:=5", argument])


@pytest.mark.parametrize("uri", [URI, URI + "/", "http://127.0.0.1", "http://[::1]:1/"])
def test_addresses_of_a_master(uri):
    check("node", {"ROS_MASTER_URI": uri}, [])
    check("node", {"ROS_MASTER_URI": "garbage"}, ["__master:=" + uri])


@pytest.mark.parametrize(
    "uri",
    ["garbage", "", "localhost:11311", "http://", "http://:11311", "http://a:b", "http://a:99999"]
    + ["https://a:11311", "http://a:0", "http://[::1"],
)
def test_invalid_address_is_named_with_its_source(uri):
    must_be = f"'{uri}': must be the URI of a ROS master, such as {URI}"
    with pytest.raises(ArgumentError, match=re.escape("ROS_MASTER_URI " + must_be)):
        check("node", {"ROS_MASTER_URI": uri}, [])
    with pytest.raises(ArgumentError, match=re.escape("__master " + must_be)):
        check("node", {"ROS_MASTER_URI": URI}, ["__master:=" + uri])


@pytest.mark.parametrize("uri", ["localhost:11311", "robot.lan:11311/", "192.0.2.1:1"])
def test_address_without_scheme_gets_the_corrected_one(uri):
    advice = re.escape(f"; it needs http:// in front: set it to http://{uri}") + "$"
    with pytest.raises(ArgumentError, match=advice):
        check("node", {"ROS_MASTER_URI": uri}, [])
    with pytest.raises(MasterUnreachable, match=advice):
        MasterClient("/node", master_uri=uri)


@pytest.mark.parametrize("uri", ["garbage", "", "http://", "https://a:11311", "a b:1", ":11311"])
def test_address_with_another_fault_gets_no_correction(uri):
    with pytest.raises(ArgumentError, match=re.escape(f"such as {URI}") + "$"):
        check("node", {"ROS_MASTER_URI": uri}, [])


@pytest.mark.parametrize(
    "argument, meant",
    [
        ("rate:=2", "_rate:=2"),
        ("~rate:=2", "_rate:=2"),
        ("_rate=2", "_rate:=2"),
        ("word:=a: b=c\nd", "_word:=a: b=c\nd"),
        ("word:=", "_word:="),
    ],
)
def test_misspelt_setting_gets_the_corrected_one(argument, meant):
    words = ["node.py", "_rate:=5", argument, "other:=a"]
    (warning,) = misspelt_settings(words, ["rate", "word"], lambda name: False)
    assert warning == f"argument {argument}: sets nothing; did you mean {meant}?"


@pytest.mark.parametrize(
    "argument",
    ["_rate:=2", "rate=2", "other:=2", "_other=2", "__rate:=2", "/rate:=2", "a/rate:=2", "used:=b"]
    + ["~used:=b", "rate", "_rate", "5", "--rate:=2", "__name:=rate", "a:=rate:=2"],
)
def test_argument_that_sets_or_remaps_gets_no_warning(argument):
    used = ["used", "~used"].__contains__
    assert misspelt_settings(["node.py", argument], ["rate", "used"], used) == []


@pytest.mark.parametrize("text, value", [("1:30", "90"), ("-1:30.5", "-90.5"), ("1:00:00", "3600")])
def test_number_in_base_60_is_warned_of_with_its_value(text, value):
    (warning,) = surprising_values(["node.py", f"_gain:={text}", "_rate:=5"])
    assert warning.startswith(f"argument _gain:={text}: YAML reads {text} in base 60, as {value}; ")


@pytest.mark.parametrize("text, has", [("1:30", True), ("1:30.5", False), ("1:00:00", False)])
def test_decimal_number_is_proposed_only_if_it_is_valid(text, has):
    (warning,) = surprising_values(["node.py", f"_gain:={text}"])
    assert ("for a decimal number" in warning) == has


@pytest.mark.parametrize(
    "argument", ["_gain:=1.30", "_gain:='1:30'", "_gain:=a:30", "gain:=1:30", "__log:=1:30", "1:30"]
)
def test_value_that_is_read_as_it_looks_gets_no_warning(argument):
    assert surprising_values(["node.py", argument]) == []


NODE = """
import nodekit
from std_msgs.msg import String
from std_srvs.srv import Trigger

class Settings(nodekit.ParameterSet):
    rate = nodekit.FloatParameter(1.0, help="a rate")
    topic = nodekit.StringParameter("a", help="a topic")
    service = nodekit.StringParameter("a", help="a service")
    last = nodekit.StringParameter("a", help="the last one")

class Some:
    def __init__(self, node):
        node.declare_parameters(Settings)
        node.create_publisher("topic", String)
        node.create_client("service", Trigger)

nodekit.run("some", Some)
"""


def test_node_warns_of_misspelt_settings_at_its_start(tmp_path):
    (tmp_path / "some_node.py").write_text(NODE)
    master = Master()
    arguments = ["topic:=b", "service:=c", "_rate=2", "last:=d"]
    node = Process(str(tmp_path / "some_node.py"), arguments, {"ROS_MASTER_URI": master.uri})
    try:
        node.wait_for_log("argument last:=d: sets nothing; did you mean _last:=d?")
        assert len(node.logged("sets nothing")) == 2
        assert node.logged("WARN", "argument _rate=2: sets nothing; did you mean _rate:=2?")
        assert node.interrupt() == 0
    finally:
        node.end()
        master.kill()


def test_invalid_names_are_rejected():
    for name, environ, argv in (
        ("a b", {}, []),
        ("node", {"ROS_NAMESPACE": "/a b"}, []),
        ("node", {}, ["__ns:=a b"]),
    ):
        with pytest.raises(IllegalName, match="a b"):
            check(name, environ, argv)


@pytest.mark.parametrize(
    "environment, arguments, sentence",
    [
        ({"ROS_MASTER_URI": "garbage"}, [], "ROS_MASTER_URI 'garbage': must be"),
        ({}, ["__name:=a b"], "node name 'a b': must be"),
        ({}, ["__ns:=~a"], "namespace: cannot turn [~a] into a global name: must be"),
        ({}, ['_x:={a: [1"'], "argument '_x:={a: [1\"': must have"),
    ],
)
def test_node_refuses_with_a_one_line_message(tmp_path, environment, arguments, sentence):
    (tmp_path / "some_node.py").write_text("import nodekit\ndef main(): nodekit.run('n', object)\n")
    program = "from nodekit.entry_point import main; main('some_node')"
    paths = [str(tmp_path), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, **environment, "PYTHONPATH": os.pathsep.join(paths)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert re.fullmatch(re.escape(sentence) + ".*\n", done.stderr), done.stderr
