"""make_environment reports failures in one message, and builds twins in order."""

import concurrent.futures
import os
import pathlib
import platform
import sys
from typing import Any, Dict, Iterator, List, Sequence

import pytest
import yaml

from nodekit.testing.waiting import wait_until
from ros2_bridge.commands import make_environment
from ros2_bridge.environment import python_environment
from ros2_bridge.environment.python_environment import PythonEnvironment, Unavailable
from ros2_bridge.types.ros2_interfaces import TwinPackage, generate_interfaces


def twins_of(**definitions: str) -> Dict[str, TwinPackage]:
    """Return packages of twins, each with one message X."""
    texts = {name: {"msg/X.msg": text} for name, text in definitions.items()}
    return generate_interfaces(texts, lambda _: False).packages


@pytest.fixture
def place(tmp_path: pathlib.Path) -> pathlib.Path:
    """Return the folder of an environment that is not yet made."""
    return tmp_path / "ros2"


@pytest.fixture
def wheels(monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path) -> pathlib.Path:
    """Return a list of wheels, of any Python."""
    monkeypatch.setattr(python_environment, "PYTHONS", (sys.version_info[:2],))
    monkeypatch.setattr(python_environment, "MACHINES", (platform.machine(),))
    path = tmp_path / "wheels.txt"
    path.write_text("x==1.0\n")
    return path


class Environment(PythonEnvironment):
    """Environment with fake wheels and builder.

    :ivar script: replaces pip
    :ivar failing: package that does not build
    :ivar built: packages built in the last run
    """

    script, failing, reason = "exit 0", "", "X.h:3: error: no"

    def __init__(self, folder: pathlib.Path) -> None:
        super().__init__(folder)
        self.built: List[str] = []

    def _install(self, wheels: pathlib.Path) -> None:
        super().run(["sh", "-c", self.script], 10.0, "no wheels")

    def run(self, command: Sequence[str], limit: float, what: str) -> None:
        if len(command) < 3 or command[1] != str(python_environment.BUILDER):
            super().run(command, limit, what)
            return
        self.built = [word.partition(":")[0] for word in command[3:]]
        if self.failing in self.built:
            (self._twins / self.failing / "error").write_text(self.reason)

    def names(self) -> Dict[str, str]:
        """Return the renamed types; each package here has one."""
        found = yaml.safe_load(self._names.read_text())
        return {name: twin for name, twin in found.items() if name.endswith("/x")}


def package(folder: pathlib.Path, text: str = "uint8 x\n") -> Dict[str, pathlib.Path]:
    """Write a package with one message, x."""
    (folder / "msg").mkdir(parents=True, exist_ok=True)
    (folder / "msg" / "x.msg").write_text(text)
    (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>")
    return {folder.name: folder}


def test_unsupported_python_is_rejected(
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    tmp_path: pathlib.Path,
) -> None:
    monkeypatch.setattr(python_environment, "MACHINES", (platform.machine(),))
    monkeypatch.setattr(python_environment, "PYTHONS", ((3, 2),))
    monkeypatch.setattr(sys, "argv", ["make_environment", "--into", str(tmp_path / "ros2")])
    assert make_environment.main() == 125
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("make_environment: PyPI has ROS 2 for Python 3.2 only, and this is 3.")


def test_architecture_without_wheels_is_named_with_a_workaround(
    monkeypatch: "pytest.MonkeyPatch", wheels: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    monkeypatch.setattr(python_environment, "MACHINES", ("x86_64",))
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    with pytest.raises(Unavailable) as caught:
        Environment(tmp_path / "ros2").make(wheels, {})
    assert str(caught.value) == (
        "PyPI has ROS 2 only for x86_64 (this machine: aarch64); start the bridge on one of those,"
        " with ROS_MASTER_URI set to this machine's master"
    )
    assert not (tmp_path / "ros2").exists()


def test_folder_that_cannot_be_written_to_is_named(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(sys, "argv", ["make_environment", "--into", "/proc/ros2"])
    assert make_environment.main() == 125
    shown = capsys.readouterr().err
    assert shown.startswith("make_environment: cannot create /proc/ros2: ")
    assert shown.endswith("is not writable, choose another with --into\n")


def test_arguments_name_the_folder_the_packages_and_the_command_line(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    calls: List[Any] = []

    def make(self: PythonEnvironment, wheels: pathlib.Path, packages: Any) -> None:
        calls.append((self.folder, wheels.name, packages))

    def install(_: PythonEnvironment, wheels: pathlib.Path) -> None:
        calls.append(wheels.name)

    def run(*arguments: str) -> List[Any]:
        monkeypatch.setattr(sys, "argv", ["make_environment", *arguments])
        calls.clear()
        assert make_environment.main() == 0
        return calls

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(PythonEnvironment, "make", make)
    monkeypatch.setattr(make_environment.command_line, "install", install)
    debian = {name: pathlib.Path("/usr/share", name) for name in ("acme_msgs", "std_msgs")}
    monkeypatch.setattr(python_environment, "debian_packages", lambda: dict(debian))
    ((folder, wheels, packages),) = run()
    assert (folder, wheels) == (tmp_path / "home" / "ros2_bridge", "wheels.txt")
    assert {*debian, "ros2_bridge", "basic_comms"} <= {*packages}
    package(tmp_path / "src" / "acme_msgs")
    (folder, _, packages), wheels = run("--into", "x", "--sources", "src", "--command-line")
    assert (folder, wheels) == (tmp_path / "x", "command_line.txt")
    assert packages == {**debian, "acme_msgs": pathlib.Path("src", "acme_msgs")}

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(PythonEnvironment, "make", interrupt)
    assert make_environment.main() == 130
    assert capsys.readouterr().err == "make_environment: interrupted: run it again\n"


def test_only_what_has_no_wheel_is_built_from_its_source(
    monkeypatch: "pytest.MonkeyPatch", place: pathlib.Path, wheels: pathlib.Path
) -> None:
    commands: List[Sequence[str]] = []
    ours = PythonEnvironment(place)
    monkeypatch.setattr(ours, "run", lambda command, *_: commands.append(command))
    ours._install(wheels)
    venv, tools, rest = commands
    assert venv[1:] == ["-m", "venv", str(place)]
    assert {"--no-deps", "--only-binary"} <= {*tools} & {*rest}
    assert tools[-2:] == ["--requirement", str(wheels.with_name("build_tools.txt"))]
    assert "--no-binary" not in tools
    assert rest[-5:-2] == ["--no-binary", "empy", "--no-build-isolation"]
    assert rest[-2:] == ["--requirement", str(wheels)]


def test_first_error_of_a_command_is_the_reason(place: pathlib.Path) -> None:
    ours = PythonEnvironment(place)
    place.with_name("ros2_twins").mkdir()
    noise = "echo collecting; echo 'ERROR: No matching distribution found'; echo error: bye; exit 1"
    with pytest.raises(Unavailable, match="no wheels: ERROR: No matching"):
        ours.run(["sh", "-c", noise], 10.0, "no wheels")
    with pytest.raises(Unavailable, match="no wheels: killed"):
        ours.run(["sh", "-c", "echo collecting; echo killed; exit 1"], 10.0, "no wheels")
    with pytest.raises(Unavailable, match="no wheels: it wrote nothing"):
        ours.run(["false"], 10.0, "no wheels")
    with pytest.raises(Unavailable, match="not finished within 0.1 s"):
        ours.run(["sleep", "10"], 0.1, "no wheels")


def test_without_a_network_that_is_the_reason() -> None:
    retry = "WARNING: Retrying after connection broken by 'NewConnectionError(…)': /simple/x/"
    log = f"{retry}\nERROR: No matching distribution found for x==1.0\n"
    assert python_environment.first_error(log) == "no connection"


@pytest.mark.parametrize("script", ["exit 1", "kill -INT $PPID; sleep 9"])
def test_complete_environment_is_kept_until_replaced(
    script: str, wheels: pathlib.Path, place: pathlib.Path
) -> None:
    first = Environment(place)
    first.make(wheels, package(place.parent / "src" / "a_msgs"))
    (place / "old").touch()
    wheels.write_text("x==2.0\n")
    second = Environment(place)
    second.script = script
    with pytest.raises((Unavailable, KeyboardInterrupt)):
        second.make(wheels, {})
    assert (place / "old").exists() and second.names() == {"a_msgs/x": "a_msgs/X"}
    assert not place.with_name("ros2_previous").exists()
    third = Environment(place)
    third.make(wheels, {})
    assert not (place / "old").exists() and not place.with_name("ros2_previous").exists()
    assert third.built == ["a_msgs"] and third.names() == {"a_msgs/x": "a_msgs/X"}


def test_environment_before_is_back_after_a_kill(wheels: pathlib.Path, place: pathlib.Path) -> None:
    Environment(place).make(wheels, {})
    (place / "old").touch()
    place.rename(place.with_name("ros2_previous"))
    place.mkdir()
    (place / python_environment.MARK).touch()
    Environment(place).make(wheels, {})
    assert (place / "old").exists() and not place.with_name("ros2_previous").exists()


def test_second_command_waits_for_the_first(
    wheels: pathlib.Path, place: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    begun, go_on = place.with_name("begun"), place.with_name("go_on")
    first, second = Environment(place), Environment(place)
    first.script = f"touch {begun}; until [ -e {go_on} ]; do sleep 0.02; done"
    second.script = "exit 1"  # nothing is left to install
    with concurrent.futures.ThreadPoolExecutor() as pool:
        earlier = pool.submit(first.make, wheels, package(place.parent / "src" / "a_msgs"))
        try:
            wait_until(begun.exists, lambda: "not begun")
            later = pool.submit(second.make, wheels, {})
            shown: List[str] = []
            wait_until(
                lambda: shown.append(capsys.readouterr().err) or "waiting" in "".join(shown),
                lambda: str(shown),
            )
            assert not later.done()
        finally:
            go_on.touch()
        earlier.result()
        later.result()
    assert second.names() == {"a_msgs/x": "a_msgs/X"}


@pytest.mark.parametrize("name", ["ros2", "ros2_twins", "ros2_previous"])
def test_users_folder_is_rejected_and_kept(
    name: str, wheels: pathlib.Path, place: pathlib.Path
) -> None:
    mine = place.with_name(name) / "src" / "mine.cpp"
    mine.parent.mkdir(parents=True)
    mine.touch()
    with pytest.raises(
        Unavailable, match=f"{name} is not empty and was not created by this command"
    ):
        Environment(place).make(wheels, {})
    assert mine.exists()
    assert sorted(path.name for path in place.parent.iterdir()) == [name, "wheels.txt"]


def test_users_file_is_rejected_and_kept(wheels: pathlib.Path, place: pathlib.Path) -> None:
    place.write_text("mine")
    with pytest.raises(Unavailable, match="ros2 is not empty and was not created by this command"):
        Environment(place).make(wheels, {})
    assert place.read_text() == "mine"


def test_environment_of_an_earlier_release_is_taken_over(
    wheels: pathlib.Path, place: pathlib.Path
) -> None:
    (place / "share" / "ros2_bridge").mkdir(parents=True)
    (place / "share" / "ros2_bridge" / "names.yaml").write_text("{}")
    (place.with_name("ros2_twins") / "a_msgs" / "source").mkdir(parents=True)
    failing = Environment(place)
    failing.script = "exit 1"
    with pytest.raises(Unavailable):
        failing.make(wheels, {})
    assert (place / python_environment.MARK).exists()  # a kill may leave it under another name
    Environment(place).make(wheels, {})
    assert (place / "wheels").exists()


def test_environment_of_another_python_is_replaced(
    wheels: pathlib.Path, place: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    Environment(place).make(wheels, {})
    (place / "old").touch()
    Environment(place).make(wheels, {})
    assert (place / "old").exists()
    monkeypatch.setattr(sys, "version", "of an upgrade")
    Environment(place).make(wheels, {})
    assert not (place / "old").exists()


def test_package_of_a_wheel_gets_no_twin(
    wheels: pathlib.Path, place: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    ours = Environment(place)
    ours.make(wheels, {})
    index = place / "share" / "ament_index" / "resource_index" / "rosidl_interfaces"
    index.mkdir(parents=True)
    (index / "std_msgs").write_text("msg/String.idl\n")
    sources = place.parent / "src"
    ours.make(wheels, {**package(sources / "std_msgs"), **package(sources / "own_msgs")})
    assert ours.built == ["own_msgs"] and list(ours.names()) == ["own_msgs/x"]
    users = {**package(sources / "good_msgs", "std_msgs/String s\n")}
    ours.make(wheels, {**users, **package(sources / "odd_msgs", "std_msgs/Odd odd\n")})
    assert ours.built == ["good_msgs"]
    error = "left out odd_msgs/msg/x.msg: it uses std_msgs/Odd, which ROS 2 does not have here"
    assert f"make_environment: {error}\n" in capsys.readouterr().err


def test_packages_of_earlier_runs_are_rebuilt_with_dependencies(
    wheels: pathlib.Path, place: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    sources = place.parent / "src"
    ours = Environment(place)
    ours.make(wheels, package(sources / "one_msgs"))
    ours.make(wheels, package(sources / "two_msgs", "one_msgs/x x\n"))
    assert ours.built == ["two_msgs"]
    assert sorted(ours.names()) == ["one_msgs/x", "two_msgs/x"]
    ours.make(wheels, package(sources / "one_msgs", "uint16 x\n"))
    assert ours.built == ["one_msgs", "two_msgs"]
    assert sorted(ours.names()) == ["one_msgs/x", "two_msgs/x"]
    builder = place.with_name("builder.py")
    builder.write_text("of a later release")
    monkeypatch.setattr(python_environment, "BUILDER", builder)
    ours.built = []
    ours.make(wheels, {})
    assert ours.built == ["one_msgs", "two_msgs"]
    names = yaml.safe_load((place / "share" / "ros2_bridge" / "names.yaml").read_text())
    assert names["std_msgs/Time"] == "builtin_interfaces/Time"


def test_failing_package_is_reported_once_and_others_built(
    wheels: pathlib.Path, place: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    sources = place.parent / "src"
    ours = Environment(place)
    ours.failing = "odd_msgs"
    packages = {**package(sources / "good_msgs"), **package(sources / "odd_msgs")}
    ours.make(wheels, packages)
    assert "make_environment: left out odd_msgs: X.h:3: error: no\n" in capsys.readouterr().err
    assert list(ours.names()) == ["good_msgs/x"]
    ours.make(wheels, packages)
    assert ours.built == ["odd_msgs"] and capsys.readouterr().err == ""
    ours.reason = "disk full"
    ours.make(wheels, packages)
    assert capsys.readouterr().err == "make_environment: left out odd_msgs: disk full\n"


def test_commands_run_without_ros_1(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    for name in ("PYTHONPATH", "ROS_DISTRO", "CATKIN_TEST", "CMAKE_PREFIX_PATH"):
        monkeypatch.setenv(name, "/somewhere")
    place = tmp_path / "ros2"
    command = (
        'test -z "$PYTHONPATH$ROS_DISTRO$CATKIN_TEST" &&'
        f' test "$CMAKE_PREFIX_PATH $AMENT_PREFIX_PATH" = "{place} {place}" &&'
        f' case "$PATH" in {place}/bin:*) ;; *) exit 1; esac'
    )
    (tmp_path / "ros2_twins").mkdir()
    PythonEnvironment(place).run(["sh", "-c", command], 10.0, "it sees ROS 1")


def test_dependencies_are_built_first() -> None:
    assert python_environment.in_order(twins_of(a="b/X x\n", b="c/X x\n", c="uint8 x\n")) == [
        "c",
        "b",
        "a",
    ]


def test_companions_have_same_maintainer(tmp_path: pathlib.Path) -> None:
    for name, maintainer in (("bridge", "we"), ("a_msgs", "we"), ("std_msgs", "others")):
        (tmp_path / name / "msg").mkdir(parents=True)
        (tmp_path / name / "msg" / "X.msg").write_text("uint8 x\n")
        (tmp_path / name / "package.xml").write_text(
            f"<package><maintainer>{maintainer}</maintainer></package>"
        )
    found = python_environment.companions(tmp_path / "bridge")
    assert list(found) == ["a_msgs", "bridge"]
    assert python_environment.definitions(found)["a_msgs"] == {"msg/X.msg": "uint8 x\n"}


def test_packages_are_found_at_any_depth_as_catkin_finds_them(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    package(tmp_path / "top_msgs")
    package(tmp_path / "repository" / "folder" / "deep_msgs")
    package(tmp_path / "repository" / "ignored_msgs")
    (tmp_path / "repository" / "ignored_msgs" / "CATKIN_IGNORE").touch()
    package(tmp_path / "repository" / "ignored_msgs" / "below_msgs")
    package(tmp_path / "top_msgs" / "inside_msgs")
    found = python_environment.packages_under(tmp_path)
    assert {name: folder.parent.name for name, folder in found.items()} == {
        "top_msgs": tmp_path.name,
        "deep_msgs": "folder",
    }
    assert capsys.readouterr().err == ""


def test_first_path_counts_of_packages_with_the_same_name(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    for folder in ("fork", "master"):
        package(tmp_path / folder / "arm_msgs")
    walk = os.walk

    def walk_backwards(*given: Any, **named: Any) -> Iterator[Any]:
        for place, folders, files in walk(*given, **named):
            folders.sort(reverse=True)  # as a file system may list them
            yield place, folders, files

    monkeypatch.setattr(os, "walk", walk_backwards)
    found = python_environment.packages_under(tmp_path)
    assert found == {"arm_msgs": tmp_path / "fork" / "arm_msgs"}
    error = f"{tmp_path}/master/arm_msgs/package.xml: same name as {tmp_path}/fork/arm_msgs"
    assert error in capsys.readouterr().err


def test_package_with_an_invalid_manifest_is_named_and_skipped(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    package(tmp_path / "good_msgs")
    package(tmp_path / "broken_msgs")
    (tmp_path / "broken_msgs" / "package.xml").write_text("<package><name>broken_msgs</name")
    assert list(python_environment.packages_under(tmp_path)) == ["good_msgs"]
    assert "broken_msgs/package.xml: invalid XML (unclosed token" in capsys.readouterr().err
    (tmp_path / "broken_msgs" / "package.xml").write_text("<package/>")
    (tmp_path / "lost_msgs").mkdir()
    (tmp_path / "lost_msgs" / "package.xml").symlink_to("nowhere")
    assert list(python_environment.packages_under(tmp_path)) == ["good_msgs"]
    lines = capsys.readouterr().err
    assert "broken_msgs/package.xml: missing name; the package is skipped" in lines
    assert "lost_msgs/package.xml: [Errno 2] No such file or directory" in lines


def test_definition_with_a_comment_in_latin1_is_read(tmp_path: pathlib.Path) -> None:
    package(tmp_path / "old_msgs")
    (tmp_path / "old_msgs" / "msg").mkdir(exist_ok=True)
    (tmp_path / "old_msgs" / "msg" / "Heat.msg").write_bytes(b"float32 value  # in \xb0C\n")
    found = python_environment.definitions({"old_msgs": tmp_path / "old_msgs"})
    assert found["old_msgs"]["msg/Heat.msg"] == "float32 value  # in \xb0C\n"


def test_debian_packages_contain_only_messages(tmp_path: pathlib.Path) -> None:
    for name, parts in {
        "a_msgs": ["__init__.py", "msg"],
        "with_code": ["__init__.py", "msg", "client.py"],
        "not_installed": [],
        "only_srvs": ["__init__.py", "srv"],
    }.items():
        (tmp_path / "share" / name / ("srv" if "srv" in parts else "msg")).mkdir(parents=True)
        for part in parts:
            (tmp_path / "python" / name / part).mkdir(parents=True)
    found = python_environment.debian_packages(tmp_path / "share", str(tmp_path / "python"))
    assert found == {name: tmp_path / "share" / name for name in ("a_msgs", "only_srvs")}
