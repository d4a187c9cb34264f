"""Qualities of service, and the path of the environment."""

import math
import os
import pathlib
import sys
from typing import Any, Dict

import pytest

from nodekit import ParameterError, describe
from ros2_bridge.environment import start
from ros2_bridge.environment.start import find, python_path
from ros2_bridge.rules.selection import Rules
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import BridgeParameters, QosProfiles, QosProfile

PYTHON = f"lib/python{sys.version_info[0]}.{sys.version_info[1]}"


def test_quality_is_the_user_s_or_fits_the_publishers() -> None:
    camera = {"topic": "/camera/*", "reliability": "best_effort", "depth": 2}
    later = {"topic": "/camera/left", "depth": 7}  # the first that fits is taken
    map_ = {"topic": "/map", "durability": "transient_local"}
    fixed = {"topic": "/fixed", "durability": "volatile", "reliability": "reliable"}
    qualities = QosProfiles(1000, [camera, later, map_, fixed])
    assert qualities.of("/signal") == QosProfile(1000)
    assert qualities.of("/signal", latched=True, best_effort=True) == QosProfile(1000, True, True)
    assert qualities.of("/signal", latched=True, at_least=3) == QosProfile(3, True)
    assert qualities.of("/camera/left") == QosProfile(2, False, True)
    assert qualities.of("/camera/left", latched=True, at_least=9) == QosProfile(2, True, True)
    assert qualities.of("/map") == QosProfile(1000, True)
    assert qualities.of("/fixed", latched=True, best_effort=True) == QosProfile(1000)


@pytest.mark.parametrize(
    "chosen, words",
    [
        ("best", "a list of mappings, each with a topic"),
        ({"/a": 5}, "a list of mappings"),
        ([{"topic": 5}], "a list of mappings, each with a topic"),
        ([{"topic": "/a", "depth": 0}], "qos of /a, depth: refused 0"),
        ([{"topic": "/a", "depth": True}], "1 to 100000"),
        ([{"topic": "/a", "depth": 100_001}], "1 to 100000"),
        ([{"topic": "/a", "durability": "latched"}], "one of volatile, transient_local"),
        ([{"topic": "/a", "history": "all"}], "made of topic, depth, reliability, durability, "),
    ],
)
def test_nonsense_is_refused(chosen: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        QosProfiles(10, chosen)


@pytest.mark.parametrize("depth", [1, 100_000])
def test_depths_that_can_be_chosen(depth: int) -> None:
    qualities = QosProfiles(10, [{"topic": "/a", "depth": depth}])
    assert qualities.of("/a") == QosProfile(depth)


@pytest.mark.parametrize(
    "name, default, limits",
    [
        ("depth", 1000, (1, 100_000, None)),
        ("max_nodes", 100, (0, 1000, None)),
        ("service_timeout", 5.0, (None, 3600.0, 0.0)),
    ],
)
def test_defaults_and_ranges(name: str, default: float, limits: Any) -> None:
    (entry,) = [one for one in describe(BridgeParameters()) if one["name"] == name]
    assert entry["default"] == default
    assert tuple(entry.get(key) for key in ("minimum", "maximum", "above")) == limits


def test_everything_is_bridged_unless_the_user_says() -> None:
    settings = BridgeParameters()
    rules = settings.bridged(Renaming())
    rest = rules.names, rules.max_rates
    assert settings.parameters and rules == Rules(True, True, ("*",), (), *rest)
    assert rules.max_rates.of("/signal") == math.inf


def test_startup_parameters_are_marked() -> None:
    declared = BridgeParameters().declared
    # The qualities of service and the names are made of these, once.
    assert {name for name in declared if declared[name].read_once} == {"depth", "remap"}


def test_direction() -> None:
    rules = BridgeParameters(direction="to_ros2").bridged(Renaming())
    assert (rules.to_ros2, rules.to_ros1) == (True, False)
    rules = BridgeParameters(direction="to_ros1").bridged(Renaming())
    assert (rules.to_ros2, rules.to_ros1) == (False, True)


def test_rules_for_names_are_validated() -> None:
    assert BridgeParameters(remap=["/robot1=/"]).names().in_ros2("/robot1/scan") == "/scan"
    with pytest.raises(ParameterError, match="each rule must be NAME=NAME"):
        BridgeParameters(remap=["/robot1:/"])


def test_rules_for_rates_are_validated() -> None:
    rules = BridgeParameters(max_rate=["/camera/*=10"]).bridged(Renaming())
    assert rules.max_rates.of("/camera/left") == 10.0
    with pytest.raises(ParameterError, match="each rule must be PATTERN=HZ"):
        BridgeParameters(max_rate=["/camera/*"])


def test_environment_is_found_above_or_by_name(tmp_path: pathlib.Path) -> None:
    here = tmp_path / "ws" / "src" / "ros2_bridge" / "start.py"
    user = {"ROS_HOME": str(tmp_path / "user")}
    assert find(user, here) is None
    workspace, installed = tmp_path / "ws" / "build" / "ros2", tmp_path / "user" / "ros2_bridge"
    for place in (installed, workspace, tmp_path / "other"):
        (place / "share" / "ros2_bridge").mkdir(parents=True)
        (place / "share" / "ros2_bridge" / "names.yaml").write_text("{}")
        (place / PYTHON).mkdir(parents=True)
    assert find(user, tmp_path / "usr" / "start.py") == installed
    assert find(user, here) == workspace
    named = {"ROS2_BRIDGE_ENVIRONMENT": str(tmp_path / "other")}
    assert find(named, here) == tmp_path / "other"
    assert find({"ROS2_BRIDGE_ENVIRONMENT": str(tmp_path)}, here) is None
    (workspace / PYTHON).rename(workspace / "lib" / "python3.2")  # of an earlier Debian
    assert find(user, here) == installed


@pytest.fixture
def environ(monkeypatch: "pytest.MonkeyPatch") -> Dict[str, str]:
    """Return a copy of the variables, which replaces them."""
    copy = dict(os.environ)
    monkeypatch.setattr(os, "environ", copy)
    monkeypatch.setattr(sys, "argv", ["bridge", "_depth:=5"])
    monkeypatch.setattr(start, "end", sys.exit)
    return copy


def test_start_without_an_environment_names_the_command_that_makes_one(
    environ: Dict[str, str], tmp_path: pathlib.Path
) -> None:
    environ["ROS2_BRIDGE_ENVIRONMENT"] = str(tmp_path)
    with pytest.raises(SystemExit, match="no environment with ROS 2 found: .*make_environment'"):
        start.main("nowhere")


def test_start_goes_on_in_the_python_of_the_environment(
    environ: Dict[str, str], monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    (tmp_path / "share" / "ros2_bridge").mkdir(parents=True)
    (tmp_path / "share" / "ros2_bridge" / "names.yaml").touch()
    (tmp_path / PYTHON).mkdir(parents=True)
    environ["ROS2_BRIDGE_ENVIRONMENT"] = str(tmp_path)

    def replace(*given: Any) -> None:
        raise SystemExit(given)

    monkeypatch.setattr(os, "execv", replace)
    with pytest.raises(SystemExit) as replaced:
        start.main("nowhere")
    python = str(tmp_path / "bin" / "python")
    assert replaced.value.code == (python, [python, "bridge", "_depth:=5"])
    assert environ["PYTHONPATH"] == python_path(sys.path)
    assert environ["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"

    def interrupt(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(start.importlib, "import_module", interrupt)
    with pytest.raises(SystemExit) as ended:
        start.main("nowhere")
    assert ended.value.code == 0


def test_only_ros1_s_packages_go_along() -> None:
    path = ["/home/me", "/ws/devel/lib/python3/dist-packages", "/usr/lib/python3/dist-packages"]
    assert python_path(path) == ":".join(path[1:])


def test_qualities_that_a_publisher_offers_are_the_users() -> None:
    chosen = {
        "topic": "/heart*",
        "deadline": 0.5,
        "lifespan": 86_400,
        "liveliness": "manual_by_topic",
    }
    qualities = QosProfiles(7, [{**chosen, "liveliness_lease_duration": 1.0}])
    assert dict(qualities.of("/heartbeat").offered) == {
        "deadline": 0.5,
        "lifespan": 86_400,
        "liveliness": "manual_by_topic",
        "liveliness_lease_duration": 1.0,
    }
    assert qualities.of("/other").offered == ()
    for name, value in (
        *(("deadline", wrong) for wrong in (0, -1.0, 86_401, True, "1 s", math.nan)),
        ("liveliness", "manual"),
    ):
        with pytest.raises(ParameterError, match=f"qos of /a, {name}"):
            QosProfiles(7, [{"topic": "/a", name: value}])
    with pytest.raises(ParameterError, match="made of topic, depth, .*liveliness_lease_duration"):
        QosProfiles(7, [{"topic": "/a", "lease": 1.0}])
