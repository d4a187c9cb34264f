"""Tests of batch runs: finding, building and judging the packages of a class."""

import os
import pathlib
import re
import sys
import time
from typing import Any, List, Tuple
from unittest import mock

import pytest

from nodekit.testing.waiting import wait_until
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.programs import batch
from pid_control.programs.batch import run_bounded
from pid_control.programs.program_finder import NothingToJudge, ProgramFinder
from pid_control.programs.submissions import packages_in

#: Stands for a build: makes a workspace, and says something in the user's language.
CATKIN_MAKE = """#!/bin/sh
mkdir -p "$2/devel/lib/x" && touch "$2/devel/env.sh" "$2/devel/lib/x/program"
echo "{says} ($LC_ALL)"
exit {status}
"""


def program(name: str = "controller.py") -> ProgramFinder:
    """Return a finder of a program."""
    return ProgramFinder(name, [], SCENARIO_METRICS)


def put_catkin_make(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", says: str, status: int
) -> None:
    """Have a catkin_make that does nothing but this found first."""
    (tmp_path / "catkin_make").write_text(CATKIN_MAKE.format(says=says, status=status))
    (tmp_path / "catkin_make").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")


def build_with(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", says: str, status: int
) -> str:
    """Build a package by a catkin_make that does nothing but this; return the workspace."""
    put_catkin_make(tmp_path, monkeypatch, says, status)
    (tmp_path / "x").mkdir()
    return batch.build(str(tmp_path / "x"), str(tmp_path / "scratch"))[0]


def found(folder: pathlib.Path) -> List[str]:
    return [os.path.relpath(package, str(folder)) for package in packages_in(str(folder))]


def test_packages_are_found_in_folders_and_not_in_each_other(tmp_path: pathlib.Path) -> None:
    for name in ("b", "a/src/deep", "b/inner", "a/src/x/too_deep", "ignored/c"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "package.xml").write_text("")
    (tmp_path / "ignored" / "CATKIN_IGNORE").write_text("")
    assert found(tmp_path) == ["a/src/deep", "b"]


def test_a_folder_that_is_a_package_is_its_only_one(tmp_path: pathlib.Path) -> None:
    (tmp_path / "package.xml").write_text("")
    assert found(tmp_path) == ["."]


@pytest.mark.parametrize(
    "text, needs",
    [
        ("add_executable(x x.cpp)", True),
        ("  catkin_python_setup()", True),
        ("generate_messages()", True),
        ("# add_executable(x)", False),
        ("catkin_package()", False),
    ],
)
def test_needs_build_depends_on_cmake_commands(
    tmp_path: pathlib.Path, text: str, needs: bool
) -> None:
    assert not batch._needs_build(str(tmp_path))
    (tmp_path / "CMakeLists.txt").write_text("project(x)\n" + text + "\n")
    assert batch._needs_build(str(tmp_path)) is needs
    (tmp_path / "CMakeLists.txt").write_bytes(text.encode() + b"\xff")
    assert not batch._needs_build(str(tmp_path))


def test_finder_of_a_program_prefers_its_source_and_names_it_exactly(
    tmp_path: pathlib.Path,
) -> None:
    package, built = tmp_path / "x", tmp_path / "ws" / "devel" / "lib" / "x"
    for folder in (package, built):
        folder.mkdir(parents=True)
        (folder / "pid").write_text("")
    finder = ProgramFinder("pid", ["_kp:=1"], SCENARIO_METRICS)
    assert finder.words(str(package), str(tmp_path / "ws")) == [str(package / "pid"), "_kp:=1"]
    assert (finder.subject, finder.figures) == ("controller", SCENARIO_METRICS)
    assert finder.is_in(str(package)) and not finder.is_built_by(str(package))
    assert finder.hint(str(tmp_path)) == "; ws/devel/lib/x/pid can be judged by its path"
    (package / "pid").unlink()
    assert finder.words(str(package), str(tmp_path / "ws")) == [str(built / "pid"), "_kp:=1"]
    assert not finder.is_in(str(package)) and finder.hint(str(package)) == ""
    for text, builds in (
        (b"add_executable(pid_2 x.cpp)", False),
        (b"add_executable(my_pid x.cpp)", False),
        (b"add_executable( pid x)", True),
        (b"add_executable(\npid\nx)", True),
        (b"add_executable(pid x) # \xff", False),
    ):
        (package / "CMakeLists.txt").write_bytes(text)
        assert finder.is_built_by(str(package)) is builds


def test_first_error_returns_line_and_next_line() -> None:
    text = "ok\nx.cpp:1: error: expected ')'\n  int main( {\nmake: Error 2\n"
    assert batch._first_error(text) == "x.cpp:1: error: expected ')' int main( {"
    assert batch._first_error("just\n\n  this\n") == "this"
    assert batch._first_error(f"Error{'x' * 300}\n") == f"Error{'x' * 295}"
    assert batch._first_error("") == ""


def test_build_nonzero_status_is_a_failure(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    with pytest.raises(NothingToJudge, match=r"it does not build: Fehler 2 \(C\)"):
        build_with(tmp_path, monkeypatch, "Fehler 2", 1)


def test_build_error_has_paths_below_the_package(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    """The workspace is removed, so its path would not help a student."""
    workspace = tmp_path / "scratch" / "workspace"
    error = f"Error in {workspace}/src/package/package.xml: no version"
    with pytest.raises(NothingToJudge, match=r"it does not build: Error in package\.xml: no vers"):
        build_with(tmp_path, monkeypatch, error, 1)


def test_package_without_the_named_file_has_a_hint_of_its_controllers(
    tmp_path: pathlib.Path,
) -> None:
    package = tmp_path / "scripts"
    package.mkdir()
    (package / "plot.py").write_text("import rospy\n")
    with pytest.raises(NothingToJudge, match=r"^it has no controller\.py$"):
        program().words(str(tmp_path), None)
    (package / "pid.py").write_text("rospy.Publisher('motor_input', Float32)\n")
    says = (
        r"no controller\.py; scripts/pid\.py mentions motor_input, and can be judged by its path$"
    )
    with pytest.raises(NothingToJudge, match=says):
        program().words(str(tmp_path), None)
    for name in ("d.py", "a.py", "b.py", "c.txt"):
        (tmp_path / name).write_text("motor_input")
    says = r"controller\.py; a\.py or b\.py or d\.py mentions motor_input"
    with pytest.raises(NothingToJudge, match=says):
        program().words(str(tmp_path), None)
    (package / "controler.py").write_text("")
    with pytest.raises(NothingToJudge, match=r"controller\.py; did you mean controler\.py\?$"):
        program().words(str(tmp_path), None)


def test_build_without_add_dependencies_succeeds_once_the_messages_are_there(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    messages = tmp_path / "messages"
    put_catkin_make(tmp_path, monkeypatch, "", 0)
    (tmp_path / "catkin_make").write_text(
        f"#!/bin/sh\n[ -e {messages} ] && exit 0\n"
        f'[ "$4" = -k ] && touch {messages}\necho "x.cpp:5: fatal error: x/y.h"; exit 1\n'
    )
    (tmp_path / "x").mkdir()
    calls: List[Any] = []

    def run(*call: Any) -> Tuple[str, int]:
        calls.append(call)
        return run_bounded(*call)

    monkeypatch.setattr(batch, "run_bounded", run)
    workspace, notes = batch.build(str(tmp_path / "x"), str(tmp_path / "scratch"))
    assert notes == ["it was built in a second attempt; in the first: x.cpp:5: fatal error: x/y.h"]
    assert workspace == str(tmp_path / "scratch" / "workspace")
    command = ["catkin_make", "-C", workspace]
    assert [call[:2] for call in calls] == [
        (command, 180.0),
        ([*command, "--make-args", "-k"], 180.0),
        (command, 180.0),
    ]
    assert {call[2]["LC_ALL"] for call in calls} == {"C"}
    languages = [set(call[2]["ROS_LANG_DISABLE"].split(os.pathsep)) for call in calls]
    assert all("gencpp" not in one for one in languages)


def test_build_warning_with_the_word_error_is_not_a_failure(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    workspace = build_with(tmp_path, monkeypatch, "warning: x = 1; // Error of the integral", 0)
    assert os.path.isdir(workspace)


def test_batch_judges_a_program_that_the_build_creates(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "built", 0)
    package, judge = tmp_path / "class" / "x", tmp_path / "judge"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("")
    (package / "CMakeLists.txt").write_text("add_executable(program program.cpp)\n")
    judge.write_text("import sys; print('judged:', sys.argv[-1])")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    output = tmp_path / "out"
    batch.Batch(str(tmp_path / "class"), program("program"), [], str(output), 10.0).run()
    said = (output / "x.txt").read_text()
    assert said.startswith("judged: ") and said.endswith("/workspace/devel/lib/x/program\n")


def test_batch_judge_has_its_own_folder_and_package_and_time_beyond_its_limit(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    package, output = tmp_path / "class" / "x", tmp_path / "out"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("")
    (package / "controller.py").write_text("")
    (package / "CMakeLists.txt").write_text("generate_messages()\n")
    calls: List[Tuple[Any, ...]] = []

    def run(*call: Any) -> Tuple[str, int]:
        calls.append(call)
        assert os.path.isdir(call[2]["TMPDIR"])
        return "first\nlast\n", 125

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["the_judge"])
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/before")
    monkeypatch.setattr(batch, "build", lambda *_: (str(tmp_path / "ws"), ["in a second attempt"]))
    monkeypatch.setattr(batch, "run_bounded", run)
    batch.Batch(str(tmp_path / "class"), program(), ["--only", "x"], str(output), 10.0).run()
    [(command, longest, environment)] = calls
    scratch = environment["TMPDIR"]
    assert command == [
        sys.executable,
        str(tmp_path / "the_judge"),
        "--only",
        "x",
        "--csv",
        f"{scratch}/judged.csv",
        "--picture",
        str(output / "x.svg"),
        "--workspace",
        str(tmp_path / "ws"),
        str(package / "controller.py"),
    ]
    assert longest == 70.0 and scratch not in (os.environ.get("TMPDIR"), None)
    assert not os.path.exists(scratch)
    paths = f"{package}{os.pathsep}/before"
    assert environment == {**os.environ, "TMPDIR": scratch, "ROS_PACKAGE_PATH": paths}
    assert (output / "x.txt").read_text() == "note: in a second attempt\nfirst\nlast\n"
    assert "x,not judged,,last," in (output / "class.csv").read_text()
    assert sorted(os.listdir(str(output))) == ["class.csv", "class.html", "x.html", "x.txt"]
    overview = (output / "class.html").read_text()
    assert 'href="x.html"' in overview and 'href="x.txt"' in overview
    assert "<img" not in (output / "x.html").read_text()


def test_batch_builds_a_package_whose_sibling_must_be_built(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "error: of a sibling", 1)
    for name, depends in (("pid", "<depend>own_msgs</depend>"), ("own_msgs", "")):
        package = tmp_path / "class" / "anna" / name
        package.mkdir(parents=True)
        (package / "package.xml").write_text(f"<package><name>{name}</name>{depends}</package>")
    (tmp_path / "class" / "anna" / "pid" / "controller.py").write_text("")
    (package / "CMakeLists.txt").write_text("find_package(pid_control)\ngenerate_messages()\n")
    output = tmp_path / "out"
    batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0).run()
    assert "it does not build: error: of a sibling" in (output / "class.csv").read_text()
    with pytest.raises(NothingToJudge):
        batch.build(str(tmp_path / "class"), str(tmp_path / "scratch"), [str(package)])
    added = tmp_path / "scratch" / "workspace" / "src" / "pid_control"  # the sibling uses it
    assert added.exists()


def test_batch_without_a_package_names_each_entry(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    (tmp_path / "x.pdf").write_text("")
    assert batch.Batch(str(tmp_path), program(), [], str(tmp_path / "out"), 10.0).run() == 125
    assert capsys.readouterr() == (
        "x.pdf: not judged: it is neither a folder nor an archive (zip, tar)\n",
        f"judge: no package in {tmp_path}\n",
    )
    assert not (tmp_path / "out").exists()


def test_run_bounded_interrupted_lets_the_command_end_its_own_processes(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    started: List[Any] = []
    ready, ended = tmp_path / "ready", tmp_path / "ended"

    def communicate(process: Any, timeout: float = 0.0) -> None:
        started.append(process)
        wait_until(ready.exists, lambda: "the command has not started")
        raise KeyboardInterrupt

    monkeypatch.setattr(batch.subprocess.Popen, "communicate", communicate)
    script = f"trap '>{ended}; exit' INT; >{ready}; while :; do sleep 0.05; done"
    with pytest.raises(KeyboardInterrupt):
        run_bounded(["sh", "-c", script], 50.0, dict(os.environ))
    assert started[0].poll() is not None and ended.exists()


def test_run_bounded_ends_a_hanging_command(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(batch, "_BEYOND_S", 1.0)  # to say something on a busy machine
    began = time.monotonic()
    script = "trap 'echo asked' INT; echo begun >&2; sleep 60 & while :; do sleep 0.05; done"
    assert run_bounded(["sh", "-c", script], 0.5, dict(os.environ)) == ("begun\nasked\n", -9)
    assert time.monotonic() - began < 20.0


@pytest.mark.usefixtures("typed")
def test_run_bounded_command_has_its_environment_and_no_input() -> None:
    script = "timeout 5 cat; echo $WHO; printf '\\377'; exit 3"
    environment = {"PATH": os.environ["PATH"], "WHO": "me"}
    assert run_bounded(["sh", "-c", script], 50.0, environment) == ("me\n\ufffd", 3)


@pytest.mark.parametrize(
    "name, text, has_messages",
    [
        ("anna", "find_package(catkin REQUIRED pid_control)", True),
        ("anna", "find_package(catkin REQUIRED roscpp)", False),
        ("pid_control", "project(pid_control)", False),
    ],
)
def test_build_adds_the_messages_of_the_course_if_they_are_used(
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
    name: str,
    text: str,
    has_messages: bool,
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "languages: $ROS_LANG_DISABLE", 1)
    monkeypatch.setenv("ROS_LANG_DISABLE", "gencpp:genlisp")
    package = tmp_path / "x"
    package.mkdir()
    (package / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (package / "CMakeLists.txt").write_text(text)
    with pytest.raises(NothingToJudge, match=r"languages: genlisp \(C\)"):
        batch.build(str(package), str(tmp_path / "scratch"))
    added = tmp_path / "scratch" / "workspace" / "src" / "pid_control"
    assert added.exists() == has_messages
    if has_messages:
        text = (added / "CMakeLists.txt").read_text()
        listed = text.partition("add_message_files(FILES ")[2].partition(")")[0].split()
        assert listed == ["motor_input.msg", "motor_output.msg", "set_point.msg"]
        assert all((added / "msg" / name).is_file() for name in listed)
        text = (added / "package.xml").read_text()
        assert "<name>pid_control</name>" in text
        assert re.search(r"<version>\d+\.\d+\.\d+</version>", text), "catkin refuses others"


def test_build_folder_called_like_the_messages_of_the_course_has_both(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "built", 0)
    package = tmp_path / "pid_control"
    package.mkdir()
    text = "<package><name>anna</name><depend>pid_control</depend></package>"
    (package / "package.xml").write_text(text)
    workspace, _ = batch.build(str(package), str(tmp_path / "scratch"))
    sources = pathlib.Path(workspace) / "src"
    texts = [path.read_text() for path in sources.glob("*/package.xml")]
    assert len(texts) == 2 and text in texts
    sibling = tmp_path / "sibling"
    sibling.mkdir()
    workspace, notes = batch.build(str(package), str(tmp_path / "again"), [str(sibling)])
    links = {path.name: path.resolve() for path in (pathlib.Path(workspace) / "src").iterdir()}
    assert links.pop("pid_control").is_dir() and notes == []
    assert links == {"package": package, "sibling0": sibling}


def test_batch_continues_after_an_unreadable_package(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    judge = tmp_path / "judge"
    for name in ("anna", "ben"):
        (tmp_path / "class" / name).mkdir(parents=True)
        (tmp_path / "class" / name / "package.xml").write_text("")
        (tmp_path / "class" / name / "controller.py").write_text("")
    judge.write_text("print('judged')")
    monkeypatch.setattr(sys, "argv", [str(judge)])

    def needs_build(package: str) -> bool:
        if package.endswith("anna"):
            raise OSError("Input/output error")
        return False

    monkeypatch.setattr(batch, "_needs_build", needs_build)
    output = tmp_path / "out"
    assert batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0).run() == 1
    assert "it cannot be judged: Input/output error" in (output / "anna.html").read_text()
    assert (output / "ben.txt").read_text() == "judged\n"


def test_batch_controller_beside_an_unrelated_package_that_does_not_build_is_judged(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "error: broken", 1)
    judge, output = tmp_path / "judge", tmp_path / "out"
    for name in ("broken", "pid"):
        package = tmp_path / "class" / "anna" / name
        package.mkdir(parents=True)
        (package / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (package / "controller.py").write_text("")
    broken = tmp_path / "class" / "anna" / "broken" / "CMakeLists.txt"
    broken.write_text("add_executable(x x.cpp)\n")
    judge.write_text("print('judged')")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0).run()
    assert "does not build" not in (output / "class.csv").read_text()
    assert (output / "anna_pid.txt").read_text() == "judged\n"


def test_batch_names_that_are_equal_without_their_marks_have_a_page_each(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    judge, output = tmp_path / "judge", tmp_path / "out"
    names = ["Anna B", "Anna_B", "class"]
    for name in names:
        (tmp_path / "class" / name).mkdir(parents=True)
        (tmp_path / "class" / name / "package.xml").write_text("")
        (tmp_path / "class" / name / "controller.py").write_text("")
    judge.write_text("import sys; print('judged', sys.argv[-1])")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0).run()
    overview = (output / "class.html").read_text()
    for name, stem in zip(names, ["Anna_B", "Anna_B-2", "class-2"]):
        assert f"{name}/controller.py" in (output / f"{stem}.html").read_text()
        assert f'"{stem}.html"' in overview


def test_batch_with_a_roster_names_students_and_writes_a_page_for_each(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    class_, output, judge = tmp_path / "class", tmp_path / "out", tmp_path / "judge"
    (class_ / "g1" / "scripts").mkdir(parents=True)
    (class_ / "g1" / "package.xml").write_text("")
    (class_ / "g1" / "scripts" / "controller.py").write_text("")
    (class_ / "g2.txt").write_text("")
    judge.write_text("print('judged: <it>')")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    roster = {"g1": "Anna", "g3": "Cleo"}
    status = batch.Batch(str(class_), program(), [], str(output), 10.0, roster).run()
    assert status == 1
    assert capsys.readouterr().out.splitlines() == [
        "Anna g1: not judged: judged: <it>",
        "g2.txt: not judged: it is neither a folder nor an archive (zip, tar)",
        "Cleo g3: not judged: nothing handed in",
    ]
    lines = (output / "class.csv").read_text().splitlines()
    assert [line.split(",")[:3] for line in lines] == [
        ["student", "controller", "verdict"],
        ["Anna", "g1", "not judged"],
        ["", "g2.txt", "not judged"],
        ["Cleo", "g3", "not judged"],
    ]
    page = (output / "g1.html").read_text()
    assert "<h1>Anna g1</h1>" in page and "judged: &lt;it&gt;" in page and "<it>" not in page
    assert "nothing handed in" in (output / "g3.html").read_text()
    assert "<th>student</th>" in (output / "class.html").read_text()


def test_batch_escapes_names_that_a_spreadsheet_would_calculate(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    output, judge = tmp_path / "out", tmp_path / "judge"
    (tmp_path / "class" / "=1+1").mkdir(parents=True)
    (tmp_path / "class" / "=1+1" / "package.xml").write_text("")
    (tmp_path / "class" / "=1+1" / "controller.py").write_text("")
    judge.write_text("print('judged')")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    roster = {"=1+1": "@Anna"}
    batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0, roster).run()
    lines = (output / "class.csv").read_text().splitlines()
    assert lines[1].split(",")[:2] == ["'@Anna", "'=1+1"]
    page = (output / "class.html").read_text()
    assert "<td>@Anna</td><td>=1+1</td>" in page and 'href="_1_1.html"' in page


def test_batch_that_is_interrupted_keeps_the_rows_so_far(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    for name in ("anna", "ben"):
        (tmp_path / "class" / name).mkdir(parents=True)
        (tmp_path / "class" / name / "package.xml").write_text("")
        (tmp_path / "class" / name / "controller.py").write_text("")
    monkeypatch.setattr(batch, "run_bounded", mock.Mock(side_effect=[("", 1), KeyboardInterrupt]))
    output = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        batch.Batch(str(tmp_path / "class"), program(), [], str(output), 10.0).run()
    lines = (output / "class.csv").read_text().splitlines()
    assert [line.partition(",")[0] for line in lines] == ["controller", "anna"]
    assert "anna.html" in (output / "class.html").read_text()


def test_batch_has_the_figures_and_the_picture_of_a_judgement(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    judge, output = tmp_path / "judge", tmp_path / "out"
    (tmp_path / "class" / "anna").mkdir(parents=True)
    (tmp_path / "class" / "anna" / "package.xml").write_text("")
    (tmp_path / "class" / "anna" / "controller.py").write_text("")
    judge.write_text(
        "import sys; options = dict(zip(sys.argv[1::2], sys.argv[2::2]))\n"
        "text = 'controller,verdict,flaws,why,a.x\\nx,passed,,,0.5\\n'\n"
        "open(options['--csv'], 'w').write(text)\n"
        "open(options['--picture'], 'w').write('<svg/>')\n"
    )
    monkeypatch.setattr(sys, "argv", [str(judge)])
    finder, class_ = ProgramFinder("controller.py", [], {"a": ("x",)}), str(tmp_path / "class")
    assert batch.Batch(class_, finder, [], str(output), 10.0).run() == 0
    assert capsys.readouterr().out == "anna: passed: all figures\n"
    lines = (output / "class.csv").read_text().splitlines()
    assert lines == ["controller,verdict,flaws,why,a.x", "anna,passed,,,0.5"]
    assert '<img src="anna.svg"' in (output / "anna.html").read_text()
    overview = (output / "class.html").read_text()
    assert re.findall('href="([^"]*)"', overview) == ["anna.html", "anna.txt", "anna.svg"]
    # One that passes is not all of them; a judge that says nothing has not judged.
    (tmp_path / "class" / "ben").mkdir()
    (tmp_path / "class" / "ben" / "package.xml").write_text("")
    (tmp_path / "class" / "ben" / "controller.py").write_text("")
    judge.write_text(f"import sys\nif 'anna' in sys.argv[-1]:\n exec({judge.read_text()!r})")
    assert batch.Batch(class_, finder, [], str(output), 10.0).run() == 1
    assert capsys.readouterr().out.splitlines() == [
        "anna: passed: all figures",
        "ben: not judged: the judge said nothing",
    ]
