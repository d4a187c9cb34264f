"""Launch files show signals in the scope: cw1.launch of basic_comms, and scope.launch."""

import os
import shlex
import subprocess
from typing import Dict, List

import pytest
import rospkg
from roslaunch.core import Node, local_machine, setup_env

from nodekit.testing.launch_files import load_launch
from topic_scope.protocol.options import parse

CW1 = os.path.join(rospkg.RosPack().get_path("basic_comms"), "launch", "cw1.launch")


def programs(*arguments: str) -> Dict[str, Node]:
    """Return the nodes of the launch file by the names of their programs."""
    config = load_launch("basic_comms", "cw1.launch", *arguments)
    return {node.type: node for node in config.nodes}


def tokens_of(node: Node, variables: Dict[str, str]) -> List[str]:
    """Return the arguments that the shell passes to the program of a node."""
    command = shlex.split(node.launch_prefix) + ["printf", "%s\\n"] + shlex.split(node.args)
    printed = subprocess.run(command, env=variables, stdout=subprocess.PIPE, check=True)
    return printed.stdout.decode().splitlines()


def test_there_is_no_scope_unless_it_is_asked_for() -> None:
    assert sorted(programs()) == ["process.py", "signal_generator.py"]


@pytest.mark.parametrize(
    "space, around, begin",
    [
        ("/", "/", ""),
        ("robot", "/", "/robot"),
        ("/a/b/", "/", "/a/b"),
        ("/", "/lab", "/lab"),
        ("robot", "/lab", "/lab/robot"),
        ("/robot", "/lab", "/robot"),
    ],
)
def test_both_signals_are_chosen(
    space: str, around: str, begin: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    scope = programs("plot:=true", "ns:=" + space, "__ns:=" + around)["scope.py"]
    variables = setup_env(scope, local_machine(), "http://localhost:11311", dict(os.environ))
    monkeypatch.setenv("ROS_NAMESPACE", variables.get("ROS_NAMESPACE", "/"))
    options = parse(tokens_of(scope, variables))
    assert options.fields == (begin + "/signal/signal_y", begin + "/proc_signal/data")
    assert options.open_browser and options.is_local and options.next_port


def test_fields_of_a_launch_file_are_in_two_plots() -> None:
    arguments = ["fields:=/a/x /a/y", "below:=/b/x:y /c", "__ns:=/"]
    (scope,) = load_launch("topic_scope", "scope.launch", *arguments).nodes
    variables = setup_env(scope, local_machine(), "http://localhost:11311", dict(os.environ))
    options = parse(tokens_of(scope, variables))
    assert options.fields == ("/a/x", "/a/y", "/b/x", "/b/y", "/c")
    lower = {name: {"plot": 2} for name in ("/b/x", "/b/y", "/c")}
    assert options.setup == {"traces": lower}
