"""Tests of finding a coursework in a package."""

import pathlib
from typing import Any, Dict, List

import pytest
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Float32, Float32MultiArray, Int32, String

from pid_control.programs.node_queries import NodeTopics
from pid_control.programs.program_command import CommandError
from pid_control.signal_runner.coursework import (
    Coursework,
    find_coursework,
    has_coursework,
    launch_files,
    package_folder,
    yaml_files,
)
from pid_control.signal_runner.coursework_finder import CourseworkFinder
from pid_control.signal_judging.scenarios import SCENARIO_METRICS
from pid_control.signal_runner.message_numbers import numbers_in
from pid_control.signal_runner.node_pair import choose_pair, describe_topics

COURSEWORKS = pathlib.Path(__file__).resolve().parents[1] / "courseworks"
ENVIRONMENT = {"PATH": "/usr/bin:/bin"}
NODE = "#!/usr/bin/env python3\nimport rospy\nrospy.init_node('x')\n"


def good(name: str) -> Coursework:
    return find_coursework(str(COURSEWORKS / name), [], dict(ENVIRONMENT))


def package(folder: pathlib.Path, launch: Dict[str, str], *programs: str) -> str:
    """Make a package; return its folder."""
    (folder / "scripts").mkdir()
    (folder / "package.xml").write_text("<package><name> anna\n</name></package>")
    for name, text in launch.items():
        (folder / name).write_text(f"<launch>{text}</launch>")
    for name in programs:
        (folder / "scripts" / name).write_text(NODE)
        (folder / "scripts" / name).chmod(0o755)
    return str(folder)


def node(program: str, of: str = "anna", name: str = "") -> str:
    return f'<node pkg="{of}" type="{program}" name="{name or program[:-3]}"/>'


@pytest.mark.parametrize(
    ("name", "launch", "nodes"),
    [
        ("wave_loops", "launch/cw1.launch", ["/process", "/signal_generator"]),
        ("sine_classes", "launch/both.launch", ["/lab/processor", "/lab/source"]),
        ("magnitude_vectors", "launch/all.launch", ["/rectifier", "/oscillator"]),
        ("included_arguments", "launch/cw1.launch", ["/process_node", "/sig_gen"]),
    ],
)
def test_find_coursework_takes_the_launch_file_of_both_nodes(
    name: str, launch: str, nodes: List[str]
) -> None:
    found = good(name)
    assert found.launch_file == str(COURSEWORKS / name / launch)
    assert [node.global_name for node in found.nodes] == nodes
    assert found.missing == "" and f"launch file: {launch}" in found.notes


def test_find_coursework_reads_the_files_beside_the_launch_file(tmp_path: pathlib.Path) -> None:
    """The same package in a built workspace is another one, with other values."""
    load = '<rosparam file="$(find anna)/values.yaml"/>' + node("process.py") + node("signal.py")
    places = {name: tmp_path / name / "anna" for name in ("src", "copy")}
    for name, place in places.items():
        place.mkdir(parents=True)
        package(place, {"both.launch": load}, "process.py", "signal.py")
        (place / "values.yaml").write_text(f"from: {name}")
    (tmp_path / "devel").mkdir()
    (tmp_path / "devel" / ".catkin").write_text(str(tmp_path / "src"))
    built = {**ENVIRONMENT, "CMAKE_PREFIX_PATH": str(tmp_path / "devel")}
    found = find_coursework(str(places["copy"]), [], built)
    assert found.parameters == {"/from": "copy"}


def test_find_coursework_leaves_out_nodes_of_other_packages_and_terminals() -> None:
    found = good("wave_loops")
    assert "not started: rqt_plot of rqt_plot" in found.notes
    assert all("gnome" not in word for node in found.nodes for word in node.command.argv)
    assert found.numbers() == {
        "/signal_amplitude": 2.0,
        "/signal_omega": 3.0,
        "/process_angle": 1.2,
        "/process_offset": 1.5,
        "/process_amplitude": 0.5,
    }


def test_find_coursework_given_launch_file_gets_its_arguments() -> None:
    folder = str(COURSEWORKS / "sine_classes")
    found = find_coursework(folder, ["both.launch", "amplitude:=7.5"], dict(ENVIRONMENT))
    assert found.parameters["/lab/source/amplitude"] == 7.5
    assert found.arguments == ["amplitude:=7.5"]
    path = f"{folder}/launch/both.launch"
    assert found.launch_file == path == find_coursework(folder, [path], ENVIRONMENT).launch_file
    says = r"^launch file not found \(x.launch\); the package has: both.launch$"
    with pytest.raises(CommandError, match=says):
        find_coursework(folder, ["x.launch"], dict(ENVIRONMENT))
    with pytest.raises(CommandError, match=r"^must be a launch file of the package \(x.py\)$"):
        find_coursework(folder, ["x.py"], dict(ENVIRONMENT))
    with pytest.raises(CommandError, match=r"^launch file not found \(x.launch\); .* has: none$"):
        find_coursework("/proc/self/ns", ["x.launch"], dict(ENVIRONMENT))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (node("process.py"), "/a.launch: starts 1 node of it$"),
        ("", "/a.launch: starts no nodes of it$"),
        (node("process.py") + node("talker.py"), "^talker.py: not found in the package"),
        ('<arg name="x" value="$(eval 1/0)"/>', "a.launch: .*division by zero"),
    ],
)
def test_find_coursework_given_launch_file_that_cannot_be_used_is_refused(
    text: str, says: str, tmp_path: pathlib.Path
) -> None:
    folder = package(tmp_path, {"a.launch": text}, "process.py", "signal.py")
    with pytest.raises(CommandError, match=says):
        find_coursework(folder, ["a.launch"], dict(ENVIRONMENT))


def test_find_coursework_without_launch_file_takes_programs_by_name(
    tmp_path: pathlib.Path,
) -> None:
    folder = package(tmp_path, {}, "sin_gen.py", "my_process.py", "talker.py")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert [node.program for node in found.nodes] == ["my_process.py", "sin_gen.py"]
    assert found.missing == "the package has no launch file"
    assert [node.global_name for node in found.nodes] == ["/my_process", "/sin_gen"]
    assert "my_process.py and sin_gen.py are started without a launch file" in found.notes
    (tmp_path / "scripts" / "gen_tools.py").write_text("")  # no node
    (tmp_path / "scripts" / "a_process.txt").write_text(NODE)  # no program
    (tmp_path / "scripts" / "b_process.py").symlink_to("nowhere")
    (tmp_path / "scripts" / "sin_other.py").write_text(NODE)
    for programs in ([], ["sin_gen.py", "my_process.py"]):
        found = find_coursework(folder, [], dict(ENVIRONMENT), programs)
        assert [node.program for node in found.nodes] == ["my_process.py", "sin_gen.py"]
    found = find_coursework(folder, [], dict(ENVIRONMENT), ["gen_tools.py", "my_process.py"])
    assert [node.program for node in found.nodes] == ["my_process.py", "gen_tools.py"]


def test_find_coursework_keeps_remappings_and_leaves_parameters_of_others(
    tmp_path: pathlib.Path,
) -> None:
    launch = """<node pkg="anna" type="signal.py" name="signal"><remap from="x" to="y"/></node>
      <node pkg="rqt_plot" type="rqt_plot" name="plot"><param name="rate" value="5"/></node>
      <param name="gain" value="2"/>"""
    folder = package(tmp_path, {"a.launch": launch + node("process.py")}, "signal.py", "process.py")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert found.parameters == {"/gain": 2}
    assert found.nodes[1].command.argv[-1] == "x:=y"
    for command in (good("sine_classes").nodes[0].command, found.nodes[1].command):
        assert not {"ROS_NAMESPACE", "ROS_MASTER_URI"} & set(command.environment)
        assert command.environment["PATH"] == ENVIRONMENT["PATH"]
    command = found.nodes[1].command
    path = f"{folder}/scripts/signal.py"
    assert command[:2] == (path, [path, "x:=y"]) and command[3:] == ({}, {}, (), folder)


def test_find_coursework_moves_private_parameters_from_arguments(tmp_path: pathlib.Path) -> None:
    """A node sets parameters of its arguments itself: in a trial, they would not change."""
    arguments = "--fast _gain:=0.5 _name:=wave _bad:=[ __log:=x in:=out a:=_b:=c"
    launch = node("signal.py") + node("process.py", name="p")[:-2] + f' args="{arguments}"/>'
    folder = package(tmp_path, {"a.launch": launch}, "signal.py", "process.py")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert found.parameters == {"/p/gain": 0.5, "/p/name": "wave"}
    rest = ["--fast", "_bad:=[", "__log:=x", "in:=out", "a:=_b:=c"]
    assert found.nodes[0].command.argv[-5:] == rest


def test_find_coursework_reports_a_launch_file_of_one_node(tmp_path: pathlib.Path) -> None:
    launch = {"a.launch": node("process.py"), "b.launch": "<broken"}
    folder = package(tmp_path, launch, "signal.py", "process.py")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert len(found.nodes) == 2
    assert found.missing.startswith("a.launch starts 1 node of it; b.launch cannot be loaded: ")
    assert found.missing.endswith(" not well-formed (invalid token): line 1, column 15")
    assert (found.folder, found.package, found.launch_file) == (folder, "anna", "")
    assert (found.arguments, found.parameters) == ([], {})


def test_find_coursework_names_the_package_of_a_foreign_launch_file(
    tmp_path: pathlib.Path,
) -> None:
    both = node("plot.py", "rqt") + node("process.py", "ben") + node("signal.py", "cleo")
    folder = package(tmp_path, {"a.launch": both}, "signal.py", "process.py")
    missing = find_coursework(folder, [], dict(ENVIRONMENT)).missing
    assert missing == (
        "a.launch starts no nodes of it: process.py is started from the package ben, but this"
        " package is called anna"
    )


def test_find_coursework_prefers_the_launch_file_with_fitting_names(
    tmp_path: pathlib.Path,
) -> None:
    talk = node("talker.py") + node("listener.py")
    both = node("process.py") + node("signal.py")
    some = node("process.py") + node("talker.py")
    launch = {"a.launch": talk, "aa.launch": some, "b.launch": both, "c.launch": both}
    folder = package(tmp_path, launch, "talker.py", "listener.py", "signal.py", "process.py")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert found.launch_file.endswith("b.launch")
    # Of the others, nothing is said.
    assert [one for one in found.notes if "launch" in one] == ["launch file: b.launch"]
    for name in ("aa.launch", "b.launch", "c.launch"):
        (tmp_path / name).unlink()
    found = find_coursework(folder, [], dict(ENVIRONMENT))  # by the names of the programs
    assert [node.program for node in found.nodes] == ["process.py", "signal.py"]
    assert (found.launch_file, found.missing) == ("", "a.launch starts other nodes")
    (tmp_path / "scripts" / "signal.py").unlink()
    assert find_coursework(folder, [], dict(ENVIRONMENT)).launch_file.endswith("a.launch")


def test_find_coursework_takes_built_programs_and_sources_of_scripts(
    tmp_path: pathlib.Path,
) -> None:
    place, built = tmp_path / "src", tmp_path / "devel" / "lib" / "anna"
    place.mkdir()
    launch = {"a.launch": node("process", name="process") + node("signal.py")}
    folder = package(place, launch, "process", "signal.py")
    built.mkdir(parents=True)
    for name in ("process", "signal.py"):
        (built / name).write_bytes(b"\x7fELF")
        (built / name).chmod(0o755)
    environment = {**ENVIRONMENT, "CMAKE_PREFIX_PATH": str(tmp_path / "devel")}
    found = find_coursework(folder, [], environment)
    paths = [str(built / "process"), str(place / "scripts" / "signal.py")]
    assert [node.command.name for node in found.nodes] == paths
    (place / "scripts" / "signal.py").unlink()
    found = find_coursework(folder, [], environment)
    assert found.nodes[1].command.name == str(built / "signal.py")


def test_find_coursework_without_two_nodes_names_the_option(tmp_path: pathlib.Path) -> None:
    folder = package(tmp_path, {}, "a.py", "b.py")
    for why in ("it has no launch file", "one.launch starts 1 node of it"):
        with pytest.raises(CommandError) as error:
            find_coursework(folder, [], dict(ENVIRONMENT))
        assert str(error.value) == (
            "no signal generator and process node found: no launch file starts two nodes of the"
            f" package ({why}), and no two programs have such names; name both: --nodes"
            " PROGRAM,PROGRAM"
        )
        (tmp_path / "one.launch").write_text(f"<launch>{node('a.py')}</launch>")
    (tmp_path / "one.launch").unlink()
    found = find_coursework(folder, [], dict(ENVIRONMENT), ["a.py", "b.py"])
    assert [node.program for node in found.nodes] == ["a.py", "b.py"]
    (tmp_path / "CMakeLists.txt").write_text("add_executable(wave src/wave.cpp)")
    for name, hint in (("c.py", ""), ("wave", "; build its workspace, and use --workspace")):
        with pytest.raises(CommandError) as error:
            find_coursework(folder, [], dict(ENVIRONMENT), ["a.py", name])
        assert str(error.value) == f"{name}: not found in the package ({folder}){hint}"
    # A Python program that is not executable is started all the same; another is not.
    (tmp_path / "scripts" / "b.py").chmod(0o644)
    found = find_coursework(folder, [], dict(ENVIRONMENT), ["a.py", "b.py"])
    assert [one for one in found.notes if "not executable" in one] == [
        f"{folder}/scripts/b.py: not executable; started with python3"
    ]
    (tmp_path / "scripts" / "b").write_bytes(b"\x7fELF")
    with pytest.raises(CommandError, match=r"scripts/b is not executable: chmod \+x "):
        find_coursework(folder, [], dict(ENVIRONMENT), ["a.py", "b"])


def test_find_coursework_named_programs_are_the_only_ones_of_a_launch_file(
    tmp_path: pathlib.Path,
) -> None:
    names = ["talker.py", "process.py", "signal.py"]
    folder = package(tmp_path, {"a.launch": "".join(map(node, names))}, *names)
    found = find_coursework(folder, [], dict(ENVIRONMENT), ["signal.py", "process.py"])
    assert [node.program for node in found.nodes] == ["process.py", "signal.py"]
    assert found.notes == ["launch file: a.launch", "not started: talker.py of anna"]
    names_ = node("signal.py", name="one") + node("process.py", name="two") + node("talker.py")
    (tmp_path / "a.launch").write_text(f"<launch>{names_}</launch>")
    found = find_coursework(folder, [], dict(ENVIRONMENT), ["one", "two"])
    assert [node.program for node in found.nodes] == ["process.py", "signal.py"]


def test_find_coursework_starts_eight_nodes_at_most_likely_process_nodes_first(
    tmp_path: pathlib.Path,
) -> None:
    names = [f"n{index}.py" for index in range(9)]
    launch = "".join(map(node, names)) + node("last.py", name="Proc")
    folder = package(tmp_path, {"a.launch": launch}, *names, "last.py")
    (tmp_path / "scripts" / "n3.py").chmod(0o644)
    (tmp_path / "scripts" / "last.py").write_text("x")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    assert [node.program for node in found.nodes] == ["last.py", *names[:7]]
    scripts = tmp_path / "scripts"
    assert found.notes == [
        f"{scripts}/n3.py: not executable; started with python3",
        f"{scripts}/last.py: the first line does not begin with #!; started with python3",
        "launch file: a.launch",
    ]


def test_find_coursework_program_that_runs_twice_is_repaired_once(tmp_path: pathlib.Path) -> None:
    launch = node("process.py") + node("process.py", name="again")
    folder = package(tmp_path, {"a.launch": launch}, "process.py")
    (tmp_path / "scripts" / "process.py").chmod(0o644)
    assert find_coursework(folder, [], dict(ENVIRONMENT)).notes == [
        f"{folder}/scripts/process.py: not executable; started with python3",
        "launch file: a.launch",
    ]


def test_names_in_source_have_their_numeric_default(tmp_path: pathlib.Path) -> None:
    found = good("wave_loops")
    names = dict(found.names_in_source(found.nodes[0].command.name))
    assert names["process_offset"] == 1.0 and names["process_angle"] > 0.0
    found = good("magnitude_vectors")
    assert [name for name, _ in found.names_in_source(found.nodes[0].command.name)] == [
        "~phase_samples",
        "~gain",
    ]
    assert found.mentions("gain") and not found.mentions("gai")
    (tmp_path / "x.py").write_text("get_param('~a', 'sine'), get_param('b', True), get_param('c')")
    assert found.names_in_source(str(tmp_path / "x.py")) == [("c", 1.1)]
    assert found.names_in_source(str(tmp_path / "gone.py")) == []
    texts = ("[1.0]", "{}", "False", "true", "false", '"a"', "'a'", "2", "1e-3", "RATE", "")
    text = "".join(f'nh.getParam("{index}", {one});' for index, one in enumerate(texts))
    text += 'nh.param<double>("/a/x", x, 1.0); searchParam( "~y" ,-2.5); other("z", 1)'
    (tmp_path / "x.cpp").write_text(text)
    assert found.names_in_source(str(tmp_path / "x.cpp")) == [
        ("7", 2.0),
        ("8", 0.001),
        ("9", 1.1),
        ("10", 1.1),
        ("/a/x", 1.1),
        ("~y", -2.5),
    ]


def test_names_are_quoted_by_programs_and_mentioned_by_any_source(tmp_path: pathlib.Path) -> None:
    launch = node("signal.py") + node("process.py")
    folder = package(tmp_path, {"a.launch": launch}, "signal.py", "process.py")
    (tmp_path / "scripts" / "process.py").open("a").write("x = '~gain', 'a/rate', 'omega_2'\n")
    (tmp_path / "scripts" / "helper.cpp").write_text('"size" offset')
    (tmp_path / "scripts" / "notes.txt").write_text("'text'")
    found = find_coursework(folder, [], dict(ENVIRONMENT))
    names = ("gain", "rate", "omega", "omega_2", "size", "offset", "text", "g.in")
    assert [name for name in names if found.mentions(name)] == [
        "gain",
        "rate",
        "omega_2",
        "size",
        "offset",
    ]
    assert [name for name in names if found.quotes(name)] == ["gain", "rate", "omega_2"]
    # The source of a built program may be any; one may be gone.
    built = found.nodes[0].command._replace(name="/devel/lib/anna/process")
    found = found._replace(nodes=[found.nodes[0]._replace(command=built), found.nodes[1]])
    assert [name for name in names if found.quotes(name)] == ["gain", "rate", "omega_2", "size"]
    (tmp_path / "scripts" / "gone.py").symlink_to("nowhere")
    assert found.quotes("size")


def test_has_coursework_goes_by_the_names_of_programs(tmp_path: pathlib.Path) -> None:
    folder = package(tmp_path, {}, "signal.py", "talker.py")
    assert not has_coursework(folder)
    (tmp_path / "scripts" / "signal.py").rename(tmp_path / "scripts" / "process.py")
    assert not has_coursework(folder)
    (tmp_path / "scripts" / "process_signal.py").write_text("")  # one node is not two
    assert not has_coursework(folder)
    for name in ("Signal", "gen.h", "publ.launch"):
        (tmp_path / "scripts" / name).write_text("")  # no source of a program
    assert not has_coursework(folder) and not CourseworkFinder([]).is_in(folder)
    for name in ("generator.cpp", "Sine.cc", "gen.py", "SIGNAL.py", "publisher.cpp"):
        (tmp_path / "scripts" / name).write_text("")
        assert has_coursework(folder) and CourseworkFinder([]).is_in(folder)
        (tmp_path / "scripts" / name).unlink()
    assert CourseworkFinder(["a.launch"]).words(folder, None) == [folder, "a.launch"]
    finder = CourseworkFinder([])
    assert (finder.subject, finder.hint(folder)) == ("package", "")
    assert finder.figures is SCENARIO_METRICS
    (tmp_path / "CMakeLists.txt").write_text("add_executable(signal signal.cpp)")
    assert not CourseworkFinder([]).is_built_by(folder)  # has_coursework sees its source


def test_files_of_a_package_are_found() -> None:
    folder = str(COURSEWORKS / "magnitude_vectors")
    assert [pathlib.Path(path).name for path in yaml_files(folder)] == [
        "oscillator.yaml",
        "rectifier.yaml",
    ]
    assert len(launch_files(folder)) == 1


def test_hidden_yaml_files_are_not_of_the_coursework(tmp_path: pathlib.Path) -> None:
    names = [*(f"{letter}.yaml" for letter in "abcdefgh"), "values.yml"]
    for name in (".travis.yml", *reversed(names), "values.yml.old"):
        (tmp_path / name).write_text("a: 1")
        (tmp_path / f"{name}.launch").write_text("")
    assert yaml_files(str(tmp_path)) == [str(tmp_path / name) for name in names]
    files = [f"{name}.launch" for name in (".travis.yml", *names, "values.yml.old")]
    assert launch_files(str(tmp_path)) == [str(tmp_path / name) for name in files]


def test_package_folder_is_absolute(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    folder = tmp_path / "anna"
    folder.mkdir()
    package(folder, {"a.launch": ""})
    monkeypatch.chdir(tmp_path)
    assert package_folder("anna", {}) == str(folder)
    assert package_folder("anna", {"ROS_PACKAGE_PATH": "/"}) == str(folder)
    monkeypatch.chdir("/")
    assert package_folder("anna", {"ROS_PACKAGE_PATH": str(tmp_path)}) == str(folder)


def test_package_folder_names_the_missing_file(tmp_path: pathlib.Path) -> None:
    place = str(tmp_path)
    for word, says in (
        (place, f"{place}: no package.xml in it: not a ROS package"),
        (f"{place}/x", f"folder not found ({place}/x)"),
        ("no_such_package", "package not found in ROS_PACKAGE_PATH (no_such_package)"),
    ):
        with pytest.raises(CommandError) as error:
            package_folder(word, {"ROS_PACKAGE_PATH": place})
        assert str(error.value) == says
    (tmp_path / "package.xml").write_text("<package/>")
    link = tmp_path / "link"
    link.symlink_to(tmp_path)
    assert package_folder(str(link), {}) == place


class Nested:
    """Message with a number, an array, and a message of its own type."""

    __slots__ = ("header", "x", "some", "inner")
    _slot_types = ("Header", "float64", "float64[]", "Nested")

    def __init__(self, x: float, inner: Any) -> None:
        self.header, self.x, self.some, self.inner = 9.0, x, (True, x, "a"), inner


def test_numbers_in_messages_of_any_depth() -> None:
    message = Vector3Stamped()
    message.vector.y = 2.0
    assert numbers_in(message) == {"vector/x": 0.0, "vector/y": 2.0, "vector/z": 0.0}
    assert numbers_in(Float32(1.5)) == {"data": 1.5}
    assert numbers_in(Float32MultiArray(data=[1.0] * 99)) == {
        f"data[{index}]": 1.0 for index in range(8)
    }
    assert numbers_in(String("x")) == numbers_in(Bool(True)) == numbers_in(Clock()) == {}
    assert str(numbers_in(Int32(3))) == "{'data': 3.0}"
    assert numbers_in(Nested(1.0, Nested(2.0, Nested(3.0, Nested(4.0, Nested(5.0, None)))))) == {
        "x": 1.0,
        "some[1]": 1.0,
        "inner/x": 2.0,
        "inner/some[1]": 2.0,
        "inner/inner/x": 3.0,
        "inner/inner/some[1]": 3.0,
        "inner/inner/inner/x": 4.0,
        "inner/inner/inner/some[1]": 4.0,
    }
    assert {name for name in numbers_in(TwistStamped()) if "x" in name} == {
        "twist/linear/x",
        "twist/angular/x",
    }


def topics(published: Dict[str, str], subscribed: Dict[str, str]) -> NodeTopics:
    return NodeTopics(published, subscribed)


def test_pair_is_found_by_topics_and_types_not_by_names() -> None:
    one, other = good("included_arguments").nodes
    a = topics({"/s": "F", "/t": "F", "/z": "F"}, {})
    b = topics({"/p": "F"}, {"/s": "F", "/t": "F"})
    found = choose_pair([one, other], {one.global_name: a, other.global_name: b})
    assert found is not None and (found.generator, found.process) == (one, other)
    assert (dict(found.inputs), dict(found.outputs)) == ({"/s": "F", "/t": "F"}, {"/p": "F"})
    assert dict(found.others) == {"/z": "F"}
    # A topic of both is no output; a node that accepts any type is connected.
    b = topics({"/p": "F", "/t": "F"}, {"/s": "*"})
    found = choose_pair([one, other], {one.global_name: a, other.global_name: b})
    assert found is not None and (dict(found.inputs), dict(found.outputs)) == (
        {"/s": "F"},
        {"/p": "F"},
    )


def test_pair_of_nodes_that_receive_each_other_is_chosen_by_name() -> None:
    process, generator = good("included_arguments").nodes
    found = {
        process.global_name: topics({"/p": "F"}, {"/s": "F"}),
        generator.global_name: topics({"/s": "F"}, {"/p": "F"}),
    }
    for nodes in ([process, generator], [generator, process]):
        pair = choose_pair(nodes, found)
        assert pair is not None and pair.process is process
    # Also by its program, rather than by its namespace; of equal ones, that of the other's.
    plain = generator._replace(name="listener", program="listener.py")
    for process in (plain._replace(program="proc.py"), plain._replace(name="proc")):
        process = process._replace(namespace="/other/")
        found[process.global_name] = topics({"/p": "F"}, {"/s": "F"})
        found[plain.global_name] = topics({"/q": "F"}, {"/s": "F"})
        pair = choose_pair([plain, process, generator], found)
        assert pair is not None and pair.process is process
    far = plain._replace(namespace="/other/")
    found[far.global_name] = topics({"/p": "F"}, {"/s": "F"})
    for nodes in ([far, plain, generator], [plain, far, generator]):
        pair = choose_pair(nodes, found)
        assert pair is not None and pair.process is plain


def test_pair_of_other_types_or_without_an_output_is_not_found() -> None:
    one, other = good("included_arguments").nodes
    a = topics({"/s": "F"}, {})
    for b in (topics({"/p": "F"}, {"/s": "D"}), topics({}, {"/s": "F"})):
        assert choose_pair([one, other], {one.global_name: a, other.global_name: b}) is None
    a = topics({"/t": "D", "/s": "F"}, {"/v": "F", "/u": "F"})
    text = describe_topics([one, other], {one.global_name: a, other.global_name: topics({}, {})})
    assert text == (
        "process_node.py publishes /s (F), /t (D) and subscribes to /u (F), /v (F);"
        " sig_gen.py publishes nothing and subscribes to nothing"
    )
    assert describe_topics([other], {}) == "sig_gen.py does not answer"
