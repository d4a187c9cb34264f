"""Every launch file loads under its documented arguments; nothing is started here."""

import os
import re
import subprocess
from typing import Any, Dict, List
from xml.dom import minidom

import pytest
from launch_loading import LAUNCH, listed_arguments, load, words_from_prefix
from roslaunch import RLException
from roslaunch.config import ROSLaunchConfig

GROUPS = ["/Group1/talker", "/Group1/listener", "/Group2/talker", "/Group2/listener"]

#: Arguments of ``roslaunch basic_comms``, and the resulting nodes.
COMMANDS: Dict[str, List[str]] = {
    "activity1.launch": GROUPS,
    "activity1.launch scope:=private": GROUPS,
    "activity2.launch": GROUPS,
    "activity2.launch scope:=global": GROUPS,
    "activity2.launch scope:=local": GROUPS,
    "activity2.launch scope:=private": GROUPS,
    "activity2.launch scope:=closest": GROUPS,
    "activity3.launch": GROUPS,
    "activity3.launch scope:=global": GROUPS,
    "activity4.launch": ["/Group1/signal_generator", "/Group1/process"],
    "signal_gen.launch": ["/signal_generator"],
    "signal_gen.launch amplitude:=1 frequency:=2e-1": ["/signal_generator"],
    "process.launch": ["/process"],
    "process.launch rate:=50 keep_positive:=false": ["/process"],
    "cw1.launch": ["/signal_generator", "/process"],
    "cw1.launch ns:=/": ["/signal_generator", "/process"],
    "cw1.launch ns:=": ["/signal_generator", "/process"],
    "cw1.launch ns:=robot": ["/robot/signal_generator", "/robot/process"],
    "cw1.launch ns:=/robot/arm": ["/robot/arm/signal_generator", "/robot/arm/process"],
    "cw1.launch __ns:=lab": ["/lab/signal_generator", "/lab/process"],
    "cw1.launch __ns:=lab ns:=robot": ["/lab/robot/signal_generator", "/lab/robot/process"],
    "cw1.launch record:=true": ["/signal_generator", "/process", "/record"],
    "cw1.launch record:=true ns:=robot": [
        "/robot/signal_generator",
        "/robot/process",
        "/robot/record",
    ],
    "cw1_two_hosts.launch": ["/signal_generator", "/process"],
    "cw1_two_hosts.launch host:=192.0.2.2 user:=me": ["/signal_generator", "/process"],
    "fleet.launch": ["/fleet"],
    "fleet.launch count:=32 prefix:=Robot": ["/fleet"],
    "groups.launch count:=0": [],
    "groups.launch prefix:=Robot": [
        "/Robot1/signal_generator",
        "/Robot1/process",
        "/Robot2/signal_generator",
        "/Robot2/process",
    ],
    "talker_listener.launch": ["/talker", "/listener"],
    "talker_listener.launch topic_name:=gossip rate:=1": ["/talker", "/listener"],
    "talker_listener.launch prefix:=": ["/talker", "/listener"],
    "talker_listener.launch prefix:=lab": ["/lab/talker", "/lab/listener"],
    "talker_listener.launch __ns:=a prefix:=b": ["/a/b/talker", "/a/b/listener"],
    "features/arg.launch text:=hello rate:=1": ["/arg_talker"],
    "features/delayed_start.launch": ["/listener", "/talker"],
    "features/delayed_start.launch delay:=0.5": ["/listener", "/talker"],
    "features/env.launch": ["/usual", "/short", "/own"],
    "features/group_ns.launch": [
        "/left/talker",
        "/left/inner/talker",
        "/far/talker",
        "/right/listener",
    ],
    "features/if_unless.launch": ["/listener", "/talker"],
    "features/if_unless.launch listen:=0 mood:=bad": ["/talker"],
    "features/if_unless.launch quiet:=1": ["/listener"],
    "features/if_unless.launch listen:=false quiet:=true": [],
    "features/include.launch rate:=1": ["/defaults/talker", "/one_by_one/talker", "/all/talker"],
    "features/last_setting_wins.launch": ["/signal_generator"],
    "features/launch_prefix.launch": ["/talker"],
    "features/launch_prefix.launch command:='nice -n 1'": ["/talker"],
    "features/machine.launch": ["/talker", "/listener"],
    "features/node_args.launch": ["/talker"],
    "features/param_types.launch": [],
    "features/param_types.launch bytes:=true": [],
    "features/remap.launch": ["/before", "/inside", "/own", "/after"],
    "features/required.launch": ["/talker", "/listener"],
    "features/respawn.launch delay:=0": ["/talker"],
    "features/rosparam.launch rate:=1": ["/talker"],
    "features/self_test.launch": ["/talker"],
    "features/substitution.launch rate:=1": ["/talker_"],
}


def files(*endings: str) -> List[str]:
    """Return the names of the launch files, relative to the folder launch."""
    return sorted(
        os.path.relpath(os.path.join(folder, name), LAUNCH)
        for folder, _, names in os.walk(LAUNCH)
        for name in names
        if name.endswith(endings)
    )


def node_names(config: ROSLaunchConfig) -> List[str]:
    """Return the global names of all nodes, those made up by $(anon) cut short."""
    names = (node.namespace + node.name for node in config.nodes)
    return [name.split("_")[0] + "_" if name.count("_") > 2 else name for name in names]


def required_arguments(command: str) -> List[str]:
    """Return the required arguments of a launch file."""
    return ["text:=x"] if command.startswith("features/arg") else []


def test_every_file_is_in_the_table() -> None:
    assert set(files(".launch")) == {command.split(" ")[0] for command in COMMANDS}


@pytest.mark.parametrize("command", COMMANDS)
def test_command_brings_up_its_nodes(command: str) -> None:
    config = load(command)
    assert config.config_errors == []
    assert sorted(node_names(config)) == sorted(COMMANDS[command])


@pytest.mark.parametrize("command", files(".launch"))
def test_terminals_are_for_every_node_and_only_when_asked_for(command: str) -> None:
    arguments = required_arguments(command)
    nodes = load(command, *arguments).nodes
    assert nodes or command.endswith("param_types.launch")  # that sets parameters alone
    for node in nodes:
        assert "xterm" not in (node.launch_prefix or "")
        assert node.output == "screen"
    for node in load(command, "terminals:=true", *arguments).nodes:
        assert node.launch_prefix.startswith("xterm -e")


@pytest.mark.parametrize("name", files(".launch", ".xml"))
def test_every_argument_has_a_doc(name: str) -> None:
    root = minidom.parse(os.path.join(LAUNCH, name)).documentElement
    declared = [tag for tag in root.childNodes if tag.nodeName == "arg"]
    assert [tag.getAttribute("name") for tag in declared if not tag.getAttribute("doc")] == []


@pytest.mark.parametrize("name", files(".launch"))
def test_required_arguments_have_no_default(name: str) -> None:
    listed = listed_arguments(name)
    required = {argument for argument, (_, default) in listed.items() if not default}
    assert required == ({"text"} if name == "features/arg.launch" else set())


def test_ros_args_is_readable_help() -> None:
    command = ["roslaunch", "--ros-args", "basic_comms", "talker_listener.launch"]
    text = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
    assert "Required Arguments" not in text
    assert 'rate (default "10.0"): messages per second, Hz' in text
    assert {line.split()[0] for line in text.splitlines()[1:]} == {
        "prefix",
        "rate",
        "scope",
        "terminals",
        "topic_name",
    }


def test_file_names_are_unique_so_that_roslaunch_finds_them_without_a_folder() -> None:
    names = [os.path.basename(name) for name in files(".launch", ".xml")]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("scope", ["global", "local", "private", "closest"])
@pytest.mark.parametrize("activity", ["activity2.launch", "activity3.launch"])
def test_scope_reaches_both_talkers(activity: str, scope: str) -> None:
    parameters = load(activity, "scope:=" + scope).params
    assert parameters["/Group1/talker/message_scope"].value == scope
    assert parameters["/Group2/talker/message_scope"].value == scope


def test_activities_2_and_3_set_the_same_parameters() -> None:
    def values(command: str) -> Dict[str, Any]:
        return {key: parameter.value for key, parameter in load(command).params.items()}

    assert values("activity2.launch") == values("activity3.launch")
    texts = {key: value for key, value in values("activity2.launch").items() if "Mess" in key}
    assert texts == {
        "/Message": "global message",
        "/Group1/Message": "local message",
        "/Group2/Message": "local message",
        "/Group1/talker/Message": "private message",
        "/Group2/talker/Message": "private message",
    }


@pytest.mark.parametrize(
    "prefix, path",
    [("cw1", "/home/me/cw1"), ("runs/my first", "/home/me/runs/my first"), ("/tmp/2", "/tmp/2")],
)
def test_bag_is_written_to_callers_folder(
    prefix: str, path: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setenv("PWD", "/home/me")
    nodes = load("cw1.launch record:=true", "record_prefix:=" + prefix).nodes
    (record,) = [node for node in nodes if node.type == "record"]
    assert words_from_prefix(record) == ["-o", path, "/signal", "/proc_signal"]


def test_recorder_has_a_terminal_when_asked_for() -> None:
    nodes = load("cw1.launch record:=true terminals:=true").nodes
    assert "record" in [node.name for node in nodes]
    for node in nodes:
        assert node.launch_prefix.startswith("xterm -e")
        assert node.output == "screen"


def test_a_required_argument_must_be_given() -> None:
    with pytest.raises(RLException, match="requires the 'text' arg to be set"):
        load("features/arg.launch")


def test_a_constant_argument_cannot_be_given() -> None:
    with pytest.raises(RLException, match="cannot override arg 'name'"):
        load("features/arg.launch", "text:=x", "name:=y")


def test_self_test_contains_one_test() -> None:
    (test,) = load("features/self_test.launch").tests
    assert (test.package, test.type, test.test_name) == ("rostest", "hztest", "talker_rate")


def test_machine_is_assigned_to_its_node_only() -> None:
    nodes = load("features/machine.launch", "address:=192.0.2.1").nodes
    assert {node.name: node.machine.address for node in nodes} == {
        "talker": "192.0.2.1",
        "listener": "localhost",
    }


def test_only_process_runs_on_the_other_host() -> None:
    arguments = ["host:=192.0.2.2", "user:=me", "ssh_port:=2222", "env_loader:=/opt/ros/env.sh"]
    machines = {node.name: node.machine for node in load("cw1_two_hosts.launch", *arguments).nodes}
    assert machines["signal_generator"].address == "localhost"
    there = machines["process"]
    assert (there.address, there.user, there.ssh_port) == ("192.0.2.2", "me", 2222)
    assert there.env_loader == "/opt/ros/env.sh"


def test_other_host_needs_same_workspace() -> None:
    (process,) = [
        node
        for node in load("cw1_two_hosts.launch", "host:=192.0.2.2").nodes
        if "process" in node.name
    ]
    assert os.access(process.machine.env_loader, os.X_OK)


@pytest.mark.parametrize("name", ["signal_generator.yaml", "process.yaml"])
def test_config_files_know_no_namespaces(name: str) -> None:
    config = load("activity4.launch")
    node = f"/Group1/{name[: -len('.yaml')]}/"
    with open(os.path.join(LAUNCH, "..", "config", name)) as source:
        lines = [line.split(":")[0] for line in source if not line.startswith("#")]
    assert lines and all(node + key in config.params for key in lines)


@pytest.mark.parametrize(
    "command, expected",
    [
        ("if_unless", {"/talker/Message": "what a day"}),
        ("if_unless listen:=false mood:=bad", {"/talker/Message": "go away"}),
        ("if_unless quiet:=true", {"/talker/Message": None}),
        ("arg text:=hello", {"/arg_talker/Message": "hello", "/arg_talker/rate": 2.0}),
        (
            "include rate:=3.0",
            {
                "/defaults/talker/rate": 10.0,
                "/one_by_one/talker/rate": 6.0,
                "/all/talker/rate": 3.0,
            },
        ),
        (
            "last_setting_wins",
            {"/signal_generator/amplitude": 5.0, "/signal_generator/rate": 20.0},
        ),
    ],
)
def test_feature_sets_its_values(command: str, expected: Dict[str, Any]) -> None:
    """Course 001-feature-1."""
    name, _, arguments = command.partition(" ")
    parameters = load(f"features/{name}.launch {arguments}").params
    found = {key: parameters[key].value if key in parameters else None for key in expected}
    assert found == expected


def test_substitutions_have_their_values(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:12345")
    monkeypatch.delenv("ROBOT_NAME", raising=False)
    config = load("features/substitution.launch rate:=3.0")
    (node,) = config.nodes
    assert re.match("talker_.*[0-9]$", node.name)
    values = {key: one.value for key, one in config.params.items() if key.startswith("/substi")}
    assert values == {
        "/substitution/env": "http://localhost:12345",
        "/substitution/optenv": "no name",
        "/substitution/find": os.path.dirname(LAUNCH),
        "/substitution/dirname": os.path.join(LAUNCH, "features"),
        "/substitution/arg": "at 3.0 Hz",
        "/substitution/eval": 1.5,
        "/substitution/anon": node.name,
    }
