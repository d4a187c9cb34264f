"""Tests of finding the controller that a command line names, and its parameters."""

import os
import pathlib
import sys
from typing import Dict, List, Optional

import pytest
from roslaunch import substitution_args

from nodekit.testing.waiting import wait_until
from pid_control.programs import program_command
from pid_control.programs.program_command import (
    CommandError,
    ProgramCommand,
    find_controller,
    find_files,
    near_names,
    package_environment,
    workspace_environment,
)
from pid_control.programs.program_process import ProgramProcess
from pid_control.programs.python_program import start_words


def test_find_files_skips_hidden_folders(tmp_path: pathlib.Path) -> None:
    for folder in (".git/kept", "scripts", "scripts/.old"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "controller.py").write_text("")
    found = [str(tmp_path / "scripts" / "controller.py")]
    assert find_files(str(tmp_path), "controller.py") == found
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "controller.py").write_text("")
    (tmp_path / "scripts" / "controller.py").chmod(0o755)
    found.append(str(tmp_path / "a" / "controller.py"))
    assert find_files(str(tmp_path), "controller.py") == found


@pytest.mark.parametrize(
    "name, hint",
    [
        ("controller.py", "; did you mean Controller.py or controler.py?"),
        ("controller_node", "; did you mean controller_node_pi?"),
        ("controler.launch", "; did you mean controller.launch?"),
        ("motor", ""),
    ],
)
def test_near_names_returns_existing_programs(name: str, hint: str, tmp_path: pathlib.Path) -> None:
    for file in ("Controller.py", "controler.py", "controller.launch", "controller_node_pi"):
        (tmp_path / file).write_text("")
    (tmp_path / "controller_node_pi").chmod(0o755)
    for other in ("controller.cpp", "controller.pyc", ".git/controllers.py"):
        (tmp_path / other).parent.mkdir(exist_ok=True)
        (tmp_path / other).write_text("")
    assert near_names(name, str(tmp_path)) == hint


def test_find_controller_unknown_program_offers_near_name(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    (tmp_path / "package.xml").write_text("<package><name>anna</name></package>")
    (tmp_path / "Controller.py").write_text("")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    says = r"controller\.py: not found in the package anna \(.*\); did you mean Controller\.py\?$"
    with pytest.raises(CommandError, match=says):
        find_controller(["anna", "controller.py"])


def test_find_controller_built_program_comes_before_its_source(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    built = tmp_path / "devel" / "lib" / "anna"
    for folder in (built, tmp_path / "src" / "scripts"):
        folder.mkdir(parents=True)
        (folder / "controller.py").write_text("")
    (tmp_path / "src" / "package.xml").write_text("<package><name>anna</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    monkeypatch.setenv("CMAKE_PREFIX_PATH", str(tmp_path / "devel"))
    assert find_controller(["anna", "controller.py"]).name == str(built / "controller.py")
    # A program without that ending is only looked for there if the package has none.
    (built / "pid").write_bytes(b"\x7fELF")
    (built / "pid").chmod(0o755)
    assert find_controller(["anna", "pid", "a:=1"]).argv == [str(built / "pid"), "a:=1"]
    (tmp_path / "src" / "pid").write_bytes(b"\x7fELF")
    (tmp_path / "src" / "pid").chmod(0o755)
    assert find_controller(["anna", "pid"]).name == str(tmp_path / "src" / "pid")


def test_find_controller_program_of_another_workspace_belongs_to_its_package(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    """Built below a folder without package.xml, so that only the workspace names the package."""
    built, source, here = (tmp_path / name for name in ("ws/devel/lib/anna", "ws/src", "here"))
    for folder in (built, source, here):
        folder.mkdir(parents=True)
    for folder in (source, here):
        (folder / "package.xml").write_text("<package><name>anna</name></package>")
    (built / "pid").write_bytes(b"\x7fELF")
    (built / "pid").chmod(0o755)
    script = tmp_path / "ws" / "devel" / "env.sh"
    variables = f"ROS_PACKAGE_PATH={source} CMAKE_PREFIX_PATH={tmp_path}/ws/devel"
    script.write_text(f'#!/bin/sh\n{variables} exec "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(here))
    command = find_controller(["anna", "pid"], workspace=str(tmp_path / "ws"))
    assert (command.name, command.package) == (str(built / "pid"), str(source))
    assert command.environment["ROS_PACKAGE_PATH"] == str(source)
    by_path = find_controller([str(built / "pid")], workspace=str(tmp_path / "ws"))
    assert (by_path.name, by_path.package) == (str(built / "pid"), str(source))
    assert find_controller([str(built / "pid")]).package == ""
    says = f"^pidd: not found in the package anna \\({source}\\); did you mean pid\\?$"
    with pytest.raises(CommandError, match=says):
        find_controller(["anna", "pidd"], workspace=str(tmp_path / "ws"))


def test_interrupt_lets_a_program_end_by_itself() -> None:
    script = "trap 'sleep 0.05; exit 3' INT; echo ready; sleep 60 & wait"
    controller = ProgramProcess(ProgramCommand("x", ["sh", "-c", script], {}, {}, {}), {})
    try:
        wait_until(lambda: controller.last_words() == "ready", controller.last_words)
        controller.interrupt()
        assert controller.status == 3
    finally:
        controller.end()


@pytest.mark.usefixtures("typed")
def test_program_has_no_input_and_its_long_last_line_is_cut() -> None:
    script = (
        "read line && exit 5; echo first; echo; echo '  '$(printf 'x%.0s' $(seq 400)); echo; exit 4"
    )
    environment = {"PATH": os.environ["PATH"]}
    command = ProgramCommand("x", ["sh", "-c", script], environment, {}, {})
    controller = ProgramProcess(command, {})
    try:
        assert not controller.writes_without_end
        wait_until(lambda: controller.status is not None, controller.last_words)
        assert (controller.status, controller.last_words()) == (4, "x" * 300)
    finally:
        controller.end()


def test_end_of_a_program_ends_its_processes_in_other_sessions() -> None:
    script = "setsid sleep 60 & echo $!; wait"
    controller = ProgramProcess(ProgramCommand("x", ["sh", "-c", script], {}, {}, {}), {})
    try:
        wait_until(lambda: len(controller.watch.pids()) == 2, controller.last_words)
    finally:
        controller.end()
    assert not os.path.exists(f"/proc/{controller.last_words()}")
    assert controller.processor_time() == 0.0


def test_find_controller_separates_parameters_of_other_nodes(tmp_path: pathlib.Path) -> None:
    launch = tmp_path / "loop.launch"
    launch.write_text(
        """<launch>
          <param name="limit" value="1.0"/>
          <node pkg="pid_control" type="system.py" name="loop">
            <param name="system_param_K" value="2.0"/>
          </node>
          <group ns="loop">
            <node pkg="pid_control" type="controller.py" name="controller">
              <param name="kp" value="0.5"/>
            </node>
            <node pkg="pid_control" type="controller.py" name="controller2">
              <param name="kp" value="0.7"/>
            </node>
          </group>
        </launch>"""
    )
    target = find_controller([str(launch)], "controller")
    assert find_controller([str(launch)], "/loop/controller") == target
    parameters = target.parameters.items()
    assert parameters >= {"/limit": 1.0, "/loop/controller/kp": 0.5}.items()
    assert not parameters & target.of_others.items()
    assert target.of_others == {"/loop/system_param_K": 2.0, "/loop/controller2/kp": 0.7}


#: A controller that only prints its first argument.
SAYS = b"import sys\nprint('started', sys.argv[1])\n"
STARTS = f"#!{sys.executable}\n".encode()


@pytest.mark.parametrize(
    "name, first_line, mode, problems",
    [
        ("controller.py", STARTS, 0o755, []),
        ("controller.py", b"#!/usr/bin/env python\n", 0o755, ["interpreter not found (python)"]),
        (
            "controller.py",
            b"#!/usr/bin/env -S python -u\n",
            0o755,
            ["interpreter not found (python)"],
        ),
        (
            "controller",
            b"#!/usr/bin/no_python\n",
            0o755,
            ["interpreter not found (/usr/bin/no_python)"],
        ),
        (
            "controller.py",
            b"#!/usr/bin/env -S A=1 python\n",
            0o755,
            ["interpreter not found (python)"],
        ),
        ("controller.py", STARTS, 0o644, ["not executable"]),
        ("controller", STARTS, 0o644, ["not executable"]),
        ("controller.py", b"", 0o755, ["the first line does not begin with #!"]),
        (
            "controller.py",
            b"\xef\xbb\xbf" + STARTS,
            0o755,
            ["the first line does not begin with #!"],
        ),
        (
            "controller.py",
            STARTS.replace(b"\n", b"\r\n"),
            0o755,
            ["the first line ends with CR LF, as on Windows"],
        ),
    ],
)
def test_find_controller_starts_python_file_and_notes_repairs(
    name: str,
    first_line: bytes,
    mode: int,
    problems: List[str],
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))  # without a Python
    says = SAYS.replace(b"\n", b"\r\n") if b"\r" in first_line else SAYS
    program = tmp_path / name
    program.write_bytes(first_line + says)
    program.chmod(mode)
    command = find_controller([str(program), "_kp:=1"])
    assert command.notes == [f"{program}: {one}; started with python3" for one in problems]
    assert command.name == str(program)
    controller = ProgramProcess(command, {})
    try:
        wait_until(lambda: controller.status is not None, controller.last_words)
        assert (controller.status, controller.last_words()) == (0, "started _kp:=1")
    finally:
        controller.end()


def test_start_words_other_python_than_that_of_ros_is_not_used(tmp_path: pathlib.Path) -> None:
    program, other = tmp_path / "controller.py", tmp_path / "python"
    program.write_text("#!/usr/bin/env python\n")
    other.write_text("#!/bin/sh\n")
    for path in (program, other):
        path.chmod(0o755)
    words, notes = start_words(str(program), {"PATH": str(tmp_path)})
    assert words == [sys.executable, str(program)]
    assert notes == [f"{program}: not the Python of ROS ({other}); started with python3"]
    other.unlink()
    other.symlink_to(sys.executable)
    assert start_words(str(program), {"PATH": str(tmp_path)}) == ([str(program)], [])


def test_start_words_interpreter_with_a_long_path_is_found(tmp_path: pathlib.Path) -> None:
    program, folder = tmp_path / "controller.py", tmp_path / ("x" * (200 - len(str(tmp_path))))
    folder.mkdir()
    (folder / "python3").symlink_to(sys.executable)
    program.write_text(f"#!{folder}/python3\n")
    program.chmod(0o755)
    assert start_words(str(program), {"PATH": ""}) == ([str(program)], [])


def test_find_controller_compiled_program_is_started_as_it_is(tmp_path: pathlib.Path) -> None:
    program = tmp_path / "controller.py"  # its target in CMakeLists.txt may be called so
    program.write_bytes(b"\x7fELF\x02\x01")
    program.chmod(0o755)
    command = find_controller([str(program)])
    assert (command.argv, list(command.notes)) == ([str(program)], [])


def test_find_controller_of_launch_file_starts_python_node(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    (tmp_path / "package.xml").write_text("<package><name>anna</name></package>")
    program = tmp_path / "controller.py"
    program.write_bytes(b"#!/usr/bin/env no_python\n" + SAYS)
    program.chmod(0o755)
    launch = tmp_path / "anna.launch"
    node = '<node pkg="anna" type="controller.py" name="control"/>'
    launch.write_text(f'<launch><param name="from" value="$(env FROM)"/>{node}</launch>')
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path), prepend=os.pathsep)
    devel = tmp_path / "devel"
    devel.mkdir()
    (devel / "env.sh").write_text('#!/bin/sh\nFROM=devel exec "$@"\n')
    (devel / "env.sh").chmod(0o755)
    before = dict(os.environ)
    command = find_controller([str(launch)], workspace=str(devel))
    assert os.environ == before
    assert (command.package, command.environment["FROM"]) == (str(tmp_path), "devel")
    assert command.parameters == {"/from": "devel"}
    assert command.argv[:3] == [sys.executable, str(program), "__name:=control"]
    problem = "interpreter not found (no_python)"
    assert command.notes == [f"{program}: {problem}; started with python3"]


def test_find_controller_of_launch_file_starts_a_script_that_is_not_executable(
    tmp_path: pathlib.Path,
) -> None:
    remap = '<remap from="set_point" to="wanted"/>'
    node = '<node pkg="anna" type="{}" name="mine" args="--fast">%s</node>' % remap
    program = package_with_launch_file(tmp_path, f"<launch>{node.format('controller.py')}</launch>")
    program.chmod(0o644)
    launch = tmp_path / "launch" / "loop.launch"
    command = find_controller([str(launch)])
    words = ["--fast", "set_point:=wanted", "__name:=mine"]
    assert command.argv == [sys.executable, str(program), *words]
    assert command.notes[0] == f"{program}: not executable; started with python3"
    program.write_bytes(b"\x7fELF")
    with pytest.raises(CommandError, match=f"^{program} is not executable: chmod \\+x {program}$"):
        find_controller([str(launch)])
    launch.write_text(f"<launch>{node.format('controler.py')}</launch>")
    with pytest.raises(CommandError, match=r"not found in the package anna .*mean controller\.py"):
        find_controller([str(launch)])


def test_workspace_environment_is_that_of_devel_and_a_script_that_hangs_is_named(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    for name in ("devel", "install"):
        script = tmp_path / name / "env.sh"
        script.parent.mkdir()
        script.write_text(f'#!/bin/sh\nFROM={name} TEXT="a=b\nc" exec "$@"\n')
        script.chmod(0o755)
    found = workspace_environment(str(tmp_path))
    assert (found["FROM"], found["TEXT"]) == ("devel", "a=b\nc") and "" not in found
    assert workspace_environment(str(tmp_path / "install"))["FROM"] == "install"
    monkeypatch.setattr(program_command, "_ENVIRONMENT_S", 0.1)
    (tmp_path / "devel" / "env.sh").write_text("#!/bin/sh\nexec sleep 60\n")
    with pytest.raises(CommandError, match=r"devel/env\.sh fails: .*timed out"):
        workspace_environment(str(tmp_path))
    monkeypatch.undo()
    for text in ("#!/bin/sh\nexit 3\n", "#!/no/such/shell\n"):
        (tmp_path / "devel" / "env.sh").write_text(text)
        with pytest.raises(CommandError, match=rf"^{tmp_path}/devel/env\.sh fails: "):
            workspace_environment(str(tmp_path))
    says = rf"^{tmp_path}/x: not a built workspace; devel/env\.sh is missing$"
    with pytest.raises(CommandError, match=says):
        workspace_environment(f"{tmp_path}/x")


def package_with_launch_file(tmp_path: pathlib.Path, launch: str) -> pathlib.Path:
    """Make a package with a program, gains in a YAML file and a launch file; return the program."""
    for folder in ("scripts", "launch", "config"):
        (tmp_path / folder).mkdir()
    (tmp_path / "package.xml").write_text("<package><name>anna</name></package>")
    (tmp_path / "config" / "gains.yaml").write_text("{kp: 0.5, ki: 2.0}\n")
    (tmp_path / "launch" / "loop.launch").write_text(launch)
    program = tmp_path / "scripts" / "controller.py"
    program.write_bytes(STARTS + SAYS)
    program.chmod(0o755)
    return program


LAUNCH = """<launch>
  <rosparam file="$(find anna)/config/gains.yaml"/>
  <node pkg="no_such_package" type="plot" name="plot"><param name="rate" value="9"/></node>
  <node pkg="anna" type="controller.py" name="mine" args="--fast">
    <param name="rate" value="50"/>
    <env name="MODE" value="fast"/>
    <remap from="set_point" to="wanted"/>
  </node>
</launch>"""


def test_find_controller_program_gets_the_parameters_of_its_launch_file(
    tmp_path: pathlib.Path,
) -> None:
    program = package_with_launch_file(tmp_path, LAUNCH)
    program.chmod(0o644)
    before = dict(os.environ)
    command = find_controller([str(program)])
    assert os.environ == before and command.environment["MODE"] == "fast"
    assert command.parameters == {"/kp": 0.5, "/ki": 2.0, "/mine/rate": 50}
    assert command.of_others == {"/plot/rate": 9}
    start = [sys.executable, str(program)]
    assert command.argv == [*start, "--fast", "__name:=mine", "set_point:=wanted"]
    launch = tmp_path / "launch" / "loop.launch"
    assert command.notes == [
        f"{program}: not executable; started with python3",
        f"{launch}: its parameters and names for /mine are used",
    ]
    assert command.package == str(tmp_path)


@pytest.mark.parametrize("is_program", [True, False])
def test_find_controller_in_a_namespace_is_connected_to_the_topics_of_the_judge(
    is_program: bool, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    launch = """<launch><group ns="left"><node pkg="anna" type="controller.py" name="mine">
      <remap from="feedback" to="motor_output"/>
      <remap from="set_point" to="wanted"/>
      <remap from="debug" to="/debug"/>
    </node></group></launch>"""
    program = package_with_launch_file(tmp_path, launch)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path), prepend=os.pathsep)
    command = find_controller([str(program if is_program else tmp_path / "launch" / "loop.launch")])
    assert command.environment["ROS_NAMESPACE"].strip("/") == "left"
    assert {word for word in command.argv if ":=" in word} == {
        "__name:=mine",
        "feedback:=/motor_output",
        "set_point:=wanted",
        "debug:=/debug",
        "/left/motor_input:=/motor_input",
        "/left/motor_output:=/motor_output",
    }


@pytest.mark.parametrize(
    "words, options, says",
    [
        (["{launch}"], {"launch": "x.launch"}, r"--launch: only valid with a program \(.*launch\)"),
        (
            ["{program}"],
            {"node": "x"},
            r"--node: only valid with a launch file \(.*controller.py\)",
        ),
        (["anna"], {}, r"^file not found \(anna\); for a package, name a program in it as well$"),
        (["an/na"], {}, r"^file not found \(an/na\)$"),
        (["no_anna", "x"], {}, r"^package not found in ROS_PACKAGE_PATH \(no_anna\)$"),
        (["{launch}"], {}, "which node is the controller\\? --node NAME, of /one, /two$"),
        (["{launch}"], {"node": "three"}, "has no node three; its nodes are /one, /two$"),
    ],
)
def test_find_controller_that_is_not_certain_names_the_option(
    words: List[str], options: Dict[str, str], says: str, tmp_path: pathlib.Path
) -> None:
    program, launch = tmp_path / "controller.py", tmp_path / "two.launch"
    program.write_bytes(STARTS + SAYS)
    program.chmod(0o755)
    nodes = "".join(f'<node pkg="x" type="{name}" name="{name}"/>' for name in ("one", "two"))
    launch.write_text(f"<launch>{nodes}</launch>")
    with pytest.raises(CommandError, match=says):
        find_controller([word.format(launch=launch, program=program) for word in words], **options)


def test_find_controller_only_node_of_a_launch_file_is_taken(tmp_path: pathlib.Path) -> None:
    launch = tmp_path / "one.launch"
    launch.write_text('<launch><node pkg="pid_control" type="system.py" name="mine"/></launch>')
    assert find_controller([str(launch)]).name == f"{launch} /mine"


def test_find_controller_first_launch_file_by_name_is_used(tmp_path: pathlib.Path) -> None:
    program = package_with_launch_file(tmp_path, LAUNCH)
    for name in "hgfedcba":
        (tmp_path / "launch" / f"{name}.launch").write_text(LAUNCH)
    [note] = find_controller([str(program)]).notes
    assert note.startswith(f"{tmp_path}/launch/a.launch: ")


def test_package_environment_forgets_the_paths_that_roslaunch_keeps(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(substitution_args, "_rospack", "of another package")
    monkeypatch.setenv("CMAKE_PREFIX_PATH", "/devel")
    before = dict(os.environ)
    for package, paths in (("/anna", f"/anna{os.pathsep}/x"), ("", "/x")):
        with package_environment(package, {"ROS_PACKAGE_PATH": "/x", "FROM": "it"}):
            assert (os.environ["ROS_PACKAGE_PATH"], os.environ["FROM"]) == (paths, "it")
            assert ("CMAKE_PREFIX_PATH" in os.environ) == (not package)
            assert substitution_args._rospack is None
            substitution_args._rospack = "of this one"
        assert os.environ == before and substitution_args._rospack is None


def test_find_controller_of_a_launch_file_is_of_the_package_around_it(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    """A teacher has a package with the course's name, too."""
    for folder in ("student", "teacher"):
        (tmp_path / folder).mkdir()
        package_with_launch_file(tmp_path / folder, LAUNCH)
    built = tmp_path / "devel" / "lib" / "anna"
    built.mkdir(parents=True)
    (built / "controller.py").write_bytes(STARTS)
    (built / "controller.py").chmod(0o755)
    (tmp_path / "student" / "config" / "gains.yaml").write_text("{kp: 3.0}\n")
    launch = tmp_path / "student" / "launch" / "loop.launch"
    monkeypatch.setenv("CMAKE_PREFIX_PATH", str(tmp_path / "devel"), prepend=os.pathsep)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "teacher"), prepend=os.pathsep)
    command = find_controller([str(launch)], "mine")
    assert command.parameters["/kp"] == 3.0
    assert command.argv[0] == str(tmp_path / "student" / "scripts" / "controller.py")


def test_find_controller_program_keeps_its_arguments(tmp_path: pathlib.Path) -> None:
    program = package_with_launch_file(tmp_path, LAUNCH)
    command = find_controller([str(program), "_kp:=1"])
    assert (command.argv, command.parameters) == ([str(program), "_kp:=1"], {})
    found = find_controller([str(program), "_kp:=1"], launch=f"{tmp_path}/launch/loop.launch")
    assert found.parameters["/kp"] == 0.5 and found.argv[1] == "_kp:=1"


def test_find_controller_launch_file_that_cannot_be_used_is_noted(tmp_path: pathlib.Path) -> None:
    program = package_with_launch_file(tmp_path, LAUNCH.replace("gains.yaml", "no.yaml"))
    [note] = find_controller([str(program)]).notes
    assert "loop.launch cannot be used: " in note and "no.yaml" in note


@pytest.mark.parametrize(
    "text, says",
    [
        (LAUNCH.replace("$(find anna)", "$(find missing)"), "missing"),
        (LAUNCH.replace('"50"', '"$(eval 1/0)"'), "division by zero"),
        (LAUNCH.replace("--fast", "don't"), "No closing quotation"),
        (None, "loop.launch"),  # a link that leads nowhere
    ],
)
def test_find_controller_faulty_launch_file_is_noted_but_refused_if_given(
    tmp_path: pathlib.Path, text: Optional[str], says: str
) -> None:
    program = package_with_launch_file(tmp_path, text or "")
    launch = tmp_path / "launch" / "loop.launch"
    if text is None:
        launch.unlink()
        launch.symlink_to(tmp_path / "gone.launch")
    command = find_controller([str(program)])
    assert command.argv == [str(program)]
    [note] = command.notes
    assert note.startswith(f"{launch} cannot be used: ") and says in note
    with pytest.raises(CommandError, match=f"--launch: .*cannot be used: .*{says}"):
        find_controller([str(program)], launch=str(launch))


@pytest.mark.parametrize("wrong", ["$(find missing)", "$(eval 1/0)"])
def test_find_controller_in_a_launch_file_with_a_fault_is_refused(
    tmp_path: pathlib.Path, wrong: str
) -> None:
    package_with_launch_file(tmp_path, f'<launch><param name="x" value="{wrong}"/></launch>')
    with pytest.raises(CommandError, match="loop.launch: (missing|division by zero)"):
        find_controller([f"{tmp_path}/launch/loop.launch"])


@pytest.mark.parametrize(
    "text, says",
    [
        (LAUNCH.replace("controller.py", "other.py"), "loop.launch does not start controller.py"),
        ("<launch>", "loop.launch cannot be used: "),
    ],
)
def test_find_controller_given_launch_file_without_the_program_is_refused(
    tmp_path: pathlib.Path, text: str, says: str
) -> None:
    program = package_with_launch_file(tmp_path, text)
    with pytest.raises(CommandError, match=says):
        find_controller([str(program)], launch=f"{tmp_path}/launch/loop.launch")
