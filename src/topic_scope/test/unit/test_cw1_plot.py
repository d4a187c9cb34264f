"""basic_comms' cw1.launch shows its signals in the scope when it is asked to."""

import os
from typing import Dict

import pytest
import rospkg
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from topic_scope.options import parse

CW1 = os.path.join(rospkg.RosPack().get_path("basic_comms"), "launch", "cw1.launch")


def programs(*arguments: str) -> Dict[str, str]:
    """Return the arguments of each program that would be started, by its name."""
    config = ROSLaunchConfig()
    XmlLoader().load(CW1, config, argv=list(arguments), verbose=False)
    assert config.config_errors == []
    return {node.type: node.args for node in config.nodes}


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
    arguments = programs("plot:=true", "ns:=" + space)["scope.py"].split()
    monkeypatch.setenv("ROS_NAMESPACE", around)  # as roslaunch __ns:= sets it for its nodes
    options = parse(arguments)
    assert options.fields == (begin + "/signal/signal_y", begin + "/proc_signal/data")
    assert options.open_browser and options.is_local
