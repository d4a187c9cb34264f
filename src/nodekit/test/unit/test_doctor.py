"""Tests of the checks and the report of ``rosrun nodekit doctor``."""

import dataclasses
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, List, Optional

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.doctor import graph_checks, machine_checks, workspace_checks
from nodekit.doctor.findings import Finding, Level, count_faults, fault, note, ok, report
from nodekit.doctor.graph_snapshot import NodeState, Publication, Snapshot
from nodekit.doctor.graph_survey import stamp_offset

FIRST, SECOND = "http://localhost:1/", "http://localhost:2/"
KIND, SUM = "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"


def state(uri: str = FIRST, **fields: Any) -> NodeState:
    return dataclasses.replace(NodeState(uri, "localhost", True, pid=1), **fields)


def graph(**fields: Any) -> Snapshot:
    """Return a talker that a listener hears, with some fields replaced."""
    healthy = Snapshot(
        publishers={"/chatter": ["/talker"]},
        subscribers={"/chatter": ["/listener"]},
        nodes={
            "/talker": state(links=frozenset([("/chatter", "/listener")])),
            "/listener": state(SECOND, subscriptions={"/chatter": KIND}, links=frozenset()),
        },
        publications={("/chatter", "/talker"): Publication(KIND, SUM)},
        types={"/chatter": KIND},
    )
    return dataclasses.replace(healthy, **fields)


def with_node(name: str, **fields: Any) -> Snapshot:
    nodes = graph().nodes
    return graph(nodes={**nodes, name: dataclasses.replace(nodes[name], **fields)})


def md5sum(_kind: str) -> Optional[str]:
    return SUM


def all_checks(system: Snapshot, use_sim_time: bool = False) -> List[Finding]:
    return [
        *graph_checks.check_nodes(system),
        *graph_checks.check_types(system, md5sum),
        *graph_checks.check_links(system),
        *graph_checks.check_sides(system),
        *graph_checks.check_clocks(system, use_sim_time),
    ]


def faults(findings: List[Finding]) -> List[str]:
    return [str(finding) for finding in findings if finding.level is Level.FAULT]


def test_healthy_graph_yields_no_fault_and_no_note() -> None:
    assert {finding.level for finding in all_checks(graph())} == {Level.OK}


def test_node_without_an_answer_is_named_with_its_remedy() -> None:
    found = faults(all_checks(with_node("/talker", error="has ended", remedy="restart {name}")))
    assert found == ["fault /talker: has ended; restart /talker"]
    odd = with_node("/talker", error="no host {x}", remedy="start {name}, {x}")
    assert faults(all_checks(odd)) == ["fault /talker: no host {x}; start /talker, {x}"]


def test_loopback_address_is_a_fault_only_beside_other_machines() -> None:
    system = with_node("/listener", host="robot", is_local=False)
    found = graph_checks.check_nodes(system)
    assert faults(found) == [
        "fault /talker: announces itself as localhost, where nodes on robot cannot reach it; "
        "start it with ROS_IP set to this machine's address in their network"
    ]
    assert any("cannot tell" in finding.problem for finding in found)
    ended = with_node("/listener", host="robot", is_local=False, error="x", remedy="y")
    assert len(faults(graph_checks.check_nodes(ended))) == 1  # its own


def test_topic_with_two_types_is_one_fault_that_names_both_sides() -> None:
    system = with_node("/listener", subscriptions={"/chatter": "std_msgs/Int32"})
    nodes = {**system.nodes, "/talker": state(links=frozenset())}
    assert faults(all_checks(dataclasses.replace(system, nodes=nodes))) == [
        "fault /chatter: has several types: std_msgs/Int32 in /listener, std_msgs/String in "
        "/talker; remap one of them, or correct its type"
    ]


def test_subscriber_of_any_type_fits_each() -> None:
    assert not faults(all_checks(with_node("/listener", subscriptions={"/chatter": "*"})))


def test_definitions_are_compared_by_checksum() -> None:
    system = graph(publications={("/chatter", "/talker"): Publication(KIND, "0" * 32)})
    (found,) = faults(all_checks(system))
    assert f"md5sum {'0' * 32} in /talker, md5sum {SUM} in this shell" in found


def test_definition_that_is_missing_here_is_a_note() -> None:
    (found,) = graph_checks.check_types(graph(), lambda _kind: None)
    assert found.level is Level.NOTE and "build and source the workspace of std_msgs" in str(found)


def test_pair_that_neither_side_lists_is_not_connected() -> None:
    system = with_node("/talker", links=frozenset())
    (found,) = faults(all_checks(system))
    assert f"/listener is not connected to /talker ({FIRST})" in found


@pytest.mark.parametrize(
    "name, value",
    [
        ("links", None),  # it does not list them
        ("error", "does not answer"),
    ],
)
def test_pair_is_not_accused_without_an_answer(name: str, value: Any) -> None:
    nodes = {**with_node("/talker", links=frozenset()).nodes}
    side = "/talker" if name == "links" else "/listener"
    nodes[side] = dataclasses.replace(nodes[side], **{name: value})
    assert not faults(graph_checks.check_links(graph(nodes=nodes)))


@pytest.mark.parametrize("name", ["/talker", "/listener"])
def test_node_with_its_connections_at_a_proxy_is_not_accused(name: str) -> None:
    nodes = {**with_node("/talker", links=frozenset()).nodes}
    nodes[name] = dataclasses.replace(nodes[name], has_proxy=True)
    assert not faults(graph_checks.check_links(graph(nodes=nodes)))


def test_connection_that_a_subscriber_only_attempts_is_missing() -> None:
    """Rospy lists it from the first attempt on."""
    nodes = {**with_node("/talker", links=frozenset()).nodes}
    nodes["/listener"] = dataclasses.replace(
        nodes["/listener"], links=frozenset([("/chatter", FIRST)])
    )
    assert len(faults(graph_checks.check_links(graph(nodes=nodes)))) == 1


def test_subscriber_of_a_misspelt_topic_is_a_fault() -> None:
    system = graph(
        publishers={"/robot/chatter": ["/talker"]},
        types={"/robot/chatter": KIND},
        publications={},
    )
    (found,) = faults(graph_checks.check_sides(system))
    assert "/talker publishes /robot/chatter" in found and "/chatter:=/robot/chatter" in found


@pytest.mark.parametrize(
    "publishers, types",
    [
        ({}, {}),
        ({"/robot/chatter": ["/talker"]}, {"/robot/chatter": "std_msgs/Int32"}),
        ({"/scan": ["/talker"]}, {"/scan": KIND}),
        ({"/old_chatter_of_robot": ["/talker"]}, {"/old_chatter_of_robot": KIND}),
        ({"/robot/chatter": ["/listener"]}, {"/robot/chatter": KIND}),  # its own
    ],
)
def test_topic_without_publisher_is_a_note_if_no_near_name_fits(
    publishers: Dict[str, List[str]], types: Dict[str, str]
) -> None:
    system = graph(publishers=publishers, types=types, publications={})
    (found,) = graph_checks.check_sides(system)
    assert str(found) == "note  /chatter: /listener subscribes, and no node publishes"


def test_topic_with_other_subscribers_is_not_proposed() -> None:
    system = graph(
        publishers={"/chatter2": ["/talker"]},
        subscribers={"/chatter": ["/listener"], "/chatter2": ["/other"]},
        publications={},
        types={"/chatter2": KIND},
    )
    assert not faults(graph_checks.check_sides(system))


@given(st.sets(st.text("abc/", min_size=1, max_size=6)), st.text("abc/", min_size=1, max_size=6))
def test_nearest_topic_is_one_of_the_others(others: "set[str]", topic: str) -> None:
    found = graph_checks.nearest_topic(topic, others)
    assert found is None or found in others
    assert topic not in others or found == topic


def test_nearest_topic_prefers_the_same_name_and_the_nearest_namespace() -> None:
    names = {"/robot2/scan", "/robot1/scan", "/robot1/scam"}
    assert graph_checks.nearest_topic("/robot1/lidar/scan", names) == "/robot1/scan"
    assert graph_checks.nearest_topic("/robot1/scann", {"/robot1/scan"}) == "/robot1/scan"


def stamped(stamp: Optional[float], **node: Any) -> Snapshot:
    system = with_node("/talker", **node)
    answer = Publication("std_msgs/Header", SUM, stamp, received_at=1000.0)
    return dataclasses.replace(system, publications={("/chatter", "/talker"): answer})


@pytest.mark.parametrize(
    "stamp, node, words, remedy",
    [
        (997.0, {"host": "robot", "is_local": False}, "3.0 s behind this", "the clock of robot"),
        (1003.5, {"host": "robot", "is_local": False}, "3.5 s ahead of this", "the clock of robot"),
        (997.0, {}, "3.0 s behind", "correct them"),
    ],
)
def test_stamps_of_another_clock_are_noted_with_the_rivals(
    stamp: float, node: Dict[str, Any], words: str, remedy: str
) -> None:
    (found,) = graph_checks.check_clocks(stamped(stamp, **node), use_sim_time=False)
    assert found.level is Level.NOTE and words in found.problem
    assert found.remedy.startswith("a replayed bag or a delay does so; else ")
    assert found.remedy.endswith(remedy)


@pytest.mark.parametrize("stamp", [999.5, 1000.5, 0.0, None])
def test_stamps_of_this_clock_and_unset_ones_are_not_named(stamp: Optional[float]) -> None:
    assert graph_checks.check_clocks(stamped(stamp), use_sim_time=False) == []


def simulated(stamp: float, clock: Optional[float]) -> Snapshot:
    system = stamped(stamp)
    publications = {
        **system.publications,
        ("/clock", "/simulator"): Publication("rosgraph_msgs/Clock", SUM, clock, 1000.0),
    }
    return dataclasses.replace(
        system,
        publishers={**system.publishers, "/clock": ["/simulator"]},
        subscribers={**system.subscribers, "/clock": ["/talker"]},
        publications=publications,
    )


def test_wall_stamps_in_simulated_time_are_a_fault() -> None:
    (found,) = faults(graph_checks.check_clocks(simulated(1000.0, 12.0), use_sim_time=True))
    assert "/talker stamps by the wall clock" in found
    assert graph_checks.check_clocks(simulated(12.0, 12.0), use_sim_time=True) == []


def test_simulated_time_without_clock_is_a_fault_and_a_stopped_clock_a_note() -> None:
    (found,) = faults(graph_checks.check_clocks(graph(), use_sim_time=True))
    assert "/use_sim_time is true, and no node publishes the time" in found
    (paused,) = graph_checks.check_clocks(simulated(1000.0, None), use_sim_time=True)
    assert paused.level is Level.NOTE and "does not advance" in paused.problem


@pytest.mark.parametrize(
    "header, offset",
    [
        ({"type": "a/B", "message_definition": "# text\n\nHeader header\nint8 x"}, 4),
        ({"type": "a/B", "message_definition": "std_msgs/Header h # text"}, 4),
        ({"type": "a/B", "message_definition": "Header h", "latching": "1"}, None),
        ({"type": "a/B", "message_definition": "int8 x\nHeader header"}, None),
        ({"type": "rosgraph_msgs/Clock", "message_definition": "time clock"}, 0),
        ({"type": "a/B"}, None),
    ],
)
def test_stamp_is_looked_for_where_a_definition_has_it(
    header: Dict[str, str], offset: Optional[int]
) -> None:
    assert stamp_offset(header) == offset


def test_report_has_faults_last_and_their_number() -> None:
    findings = [fault("a", "is broken", "mend it"), ok("b", "runs"), note("c", "stands")]
    assert report(findings).splitlines() == [
        "ok    b: runs",
        "note  c: stands",
        "fault a: is broken; mend it",
        "1 fault",
    ]
    assert count_faults(findings) == 1
    assert report([ok("b", "runs")]).endswith("\nhealthy")
    assert report(findings * 2).endswith("\n2 faults")


@pytest.mark.parametrize(
    "address, expected",
    [
        ("0100007F", True),
        ("0200007F", True),
        ("00000000", False),
        ("0A01A8C0", False),
        ("00000000000000000000000001000000", True),
        ("00000000000000000000000000000000", False),
        ("0000000000000000FFFF00000100007F", True),
        ("0000000000000000FFFF000000000000", False),
    ],
)
def test_loopback_in_the_kernels_table(address: str, expected: bool) -> None:
    assert machine_checks._is_loopback(address) is expected


@pytest.mark.parametrize(
    "uri, words, is_reported",
    [
        (None, [], True),
        ("http://localhost:11311/", [], True),
        ("http://localhost:11312", [], False),
        ("http://localhost:11312", ["__master:=http://localhost:11311"], True),
        (None, ["__master:=http://localhost:11312"], False),
    ],
)
def test_ignored_arguments_are_those_of_a_roslaunch_with_the_same_master(
    tmp_path: Path,
    monkeypatch: "pytest.MonkeyPatch",
    uri: Optional[str],
    words: List[str],
    is_reported: bool,
) -> None:
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    (tmp_path / "roslaunch").write_text("print('ready', flush=True); input()")
    (tmp_path / "some.launch").write_text('<launch><arg name="type"/></launch>')
    command = [sys.executable, "roslaunch", "some.launch", "typo:=1", *words]
    environ = {"ROS_MASTER_URI": uri} if uri else {}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, cwd=str(tmp_path), env=environ, **pipes) as process:
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        found = [one for one in machine_checks.check_launch_arguments() if "typo" in one.problem]
        process.communicate(b"\n")
    mine = [one for one in found if f"process {process.pid}" in one.subject]
    assert bool(mine) == is_reported


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: "pytest.MonkeyPatch") -> Path:
    """Workspace with one package that has a message."""
    package = tmp_path / "src" / "arm"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arm</name></package>")
    (package / "msg" / "Joint.msg").write_text("float64 angle\n")
    (tmp_path / ".catkin_workspace").write_text("")
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    return tmp_path


def only_fault(folder: Path) -> str:
    (found,) = faults(workspace_checks.check_workspace(str(folder)))
    return found


def test_workspace_that_is_not_built_or_not_sourced(workspace: Path) -> None:
    assert "not built (arm); cd " in only_fault(workspace)
    assert only_fault(workspace).endswith("catkin_make")
    (workspace / ".catkin_tools").mkdir()
    assert only_fault(workspace).endswith("catkin build")
    (workspace / "devel").mkdir()
    (workspace / "devel" / "setup.bash").write_text("")
    found = only_fault(workspace / "src" / "arm")
    assert f"not sourced in this shell (arm); source {workspace}/devel/setup.bash" in found


@pytest.fixture
def sourced(workspace: Path, monkeypatch: "pytest.MonkeyPatch") -> Path:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(workspace / "src"))
    return workspace


def test_messages_that_are_newer_than_their_code(
    sourced: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    assert "arm/Joint.msg: no code was generated from it" in only_fault(sourced)
    built = sourced / "devel" / "arm" / "msg" / "_Joint.py"
    built.parent.mkdir(parents=True)
    built.write_text("")
    monkeypatch.syspath_prepend(str(sourced / "devel"))
    assert not faults(workspace_checks.check_workspace(str(sourced)))
    definition = sourced / "src" / "arm" / "msg" / "Joint.msg"
    later = built.stat().st_mtime + 10
    os.utime(definition, (later, later))
    assert f"arm/Joint.msg: newer than {built}; build the workspace again" in only_fault(sourced)


def test_script_that_hides_a_module(sourced: Path) -> None:
    (sourced / "src" / "arm" / "msg" / "Joint.msg").unlink()
    scripts = sourced / "src" / "arm" / "scripts"
    scripts.mkdir()
    (scripts / "queue.py").write_text("")
    assert not faults(workspace_checks.check_workspace(str(sourced)))  # no program beside it
    (scripts / "move.py").write_text("")
    (scripts / "move.py").chmod(0o755)
    assert f"{scripts}/queue.py: hides the module queue" in only_fault(sourced)


def test_package_that_another_copy_hides(
    workspace: Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    other = workspace / "other" / "arm"
    other.mkdir(parents=True)
    (other / "package.xml").write_text("<package><name>arm</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(workspace / "other"))
    assert f"is hidden by the copy in {other}" in only_fault(workspace)


def test_folder_outside_of_a_workspace(tmp_path: Path) -> None:
    (tmp_path / "program" / "src").mkdir(parents=True)
    (tmp_path / "program" / "src" / "CMakeLists.txt").write_text("")  # of C++ without ROS
    (found,) = workspace_checks.check_workspace(str(tmp_path / "program"))
    assert found.problem.startswith("no package in")
    assert workspace_checks.find_workspace(str(tmp_path)) is None
    assert not faults(workspace_checks.check_workspace(str(tmp_path)))


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_processes_that_listen_to_other_machines_are_a_note(host: str) -> None:
    system = graph(nodes={"/talker": state(pid=os.getpid()), "/hidden": state(pid=2**22 + 1)})
    with socket.socket() as listener:
        listener.bind((host, 0))
        listener.listen()
        found = [str(each) for each in machine_checks.check_listening(system, None)]
    is_open = host == "0.0.0.0"
    assert is_open == any("every machine in the network can connect to /talker" in f for f in found)
    assert any("unknown for /hidden" in f for f in found)
