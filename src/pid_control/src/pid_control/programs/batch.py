"""Batch run over a folder: builds each package, judges it in its own process, writes reports."""

import contextlib
import csv
import io
import itertools
import os
import re
import signal
import subprocess
import sys
import tempfile
from typing import Dict, List, Optional, Sequence, Tuple

import rospkg

from pid_control.output_files import write_file
from pid_control.programs.program_finder import NothingToJudge, SubjectFinder
from pid_control.programs.submissions import (
    Submission,
    missing_in,
    name_in,
    needed_siblings,
    submissions_in,
)
from pid_control.verdicts.batch_page import as_html, as_page_of_student
from pid_control.verdicts.judgement import FAILED, NOT_JUDGED, PASSED, STATUS, Judgement
from pid_control.verdicts.reports import as_csv, text_cell

#: Time limit of a build, and extra time for a judge beyond its own limit [s].
_BUILD_S, _BEYOND_S = 180.0, 60.0
#: Commands in a CMakeLists.txt of a package that must be built.
_IS_BUILT = re.compile(r"^\s*(add_executable|catkin_python_setup|generate_messages)\b", re.M)
#: Error line in the output of a build.
_ERROR = re.compile(r"error", re.IGNORECASE)
#: Message package of the course in a separate workspace, for programs in C++.
_MESSAGES = ("motor_input.msg", "motor_output.msg", "set_point.msg")
_MESSAGES_XML = """<package format="2">
  <name>pid_control</name><version>1.0.0</version><description>messages</description>
  <maintainer email="judge@example.invalid">judge</maintainer><license>BSD</license>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>message_generation</depend><depend>message_runtime</depend>
</package>
"""
_MESSAGES_CMAKE = f"""cmake_minimum_required(VERSION 3.5)
project(pid_control)
find_package(catkin REQUIRED COMPONENTS message_generation)
add_message_files(FILES {" ".join(_MESSAGES)})
generate_messages()
catkin_package(CATKIN_DEPENDS message_runtime)
"""


class Batch:
    """Batch run over the packages of a class.

    :param folder: folder of the packages
    :param finder: finds what to judge in each package
    :param options: options of each judge
    :param output: folder for the files
    :param time_limit: time limit per package [s]
    :param roster: student of each folder or archive
    """

    def __init__(
        self,
        folder: str,
        finder: SubjectFinder,
        options: Sequence[str],
        output: str,
        time_limit: float,
        roster: Optional[Dict[str, str]] = None,
    ) -> None:
        self._roster = roster or {}
        self._folder, self._output = os.path.abspath(folder), output
        self._finder = finder
        self._options, self._time_limit = list(options), time_limit
        self._rows: List[Dict[str, str]] = []
        self._files: Dict[str, List[str]] = {}
        #: Used names of files, without their endings.
        self._stems = {"class"}

    def run(self) -> int:
        """Judge all packages, and update the files after each of them.

        :returns: exit status: 0 if all passed, 1 if not, 125 if there is no package
        """
        with tempfile.TemporaryDirectory(prefix="judge-") as unpacked:
            submissions = submissions_in(self._folder, self._finder, unpacked)
            submissions += missing_in(submissions, self._roster)
            if not any(submission.package for submission in submissions):
                for submission in submissions:
                    print(f"{submission.name}: {NOT_JUDGED}: {submission.why}")
                print(f"judge: no package in {self._folder}", file=sys.stderr)
                return STATUS[NOT_JUDGED]
            os.makedirs(self._output, exist_ok=True)
            for submission in submissions:
                with tempfile.TemporaryDirectory(prefix="judge-") as scratch:
                    row = self._judge(submission, scratch)
                self._rows.append(row)
                name = " ".join(filter(None, [row.get("student"), submission.name]))
                print(f"{name}: {row['verdict']}: {row['why'] or 'all figures'}", flush=True)
                self._write()
        passed = all(row["verdict"] == PASSED for row in self._rows)
        return STATUS[PASSED if passed else FAILED]

    def _judge(self, submission: Submission, scratch: str) -> Dict[str, str]:
        """Judge a submission, and return its row."""
        name, package = submission.name, submission.package
        stem = self._new_stem(name)
        picture, words = stem + ".svg", stem + ".txt"
        table = os.path.join(scratch, "judged.csv")
        self._files[name] = []
        text = ""
        try:
            if not package:
                raise NothingToJudge(submission.why)
            workspace: Optional[str] = None
            options = [*self._options, "--csv", table]
            options += ["--picture", os.path.join(self._output, picture)]
            siblings = needed_siblings(package, submission.siblings)
            notes: List[str] = []
            if any(map(_needs_build, [package, *siblings])):
                workspace, notes = build(package, scratch, siblings)
                options += ["--workspace", workspace]
            environment = dict(os.environ, TMPDIR=scratch)
            paths = [package, os.environ.get("ROS_PACKAGE_PATH", "")]
            environment["ROS_PACKAGE_PATH"] = os.pathsep.join(paths)
            command = [sys.executable, os.path.abspath(sys.argv[0]), *options]
            text, _ = run_bounded(
                [*command, *self._finder.words(package, workspace)],
                self._time_limit + _BEYOND_S,
                environment,
            )
            text = "".join(f"note: {note}\n" for note in notes) + text
            with open(os.path.join(self._output, words), "w", encoding="utf-8") as file:
                file.write(text)
            self._files[name] = [words]
            if os.path.exists(os.path.join(self._output, picture)):
                self._files[name].append(picture)
            if not os.path.exists(table):
                raise NothingToJudge((text.strip().splitlines() or ["the judge said nothing"])[-1])
            with open(table, encoding="utf-8", newline="") as file:
                [row] = csv.DictReader(file)
        except (NothingToJudge, OSError) as error:
            why = (
                str(error) if isinstance(error, NothingToJudge) else f"it cannot be judged: {error}"
            )
            not_judged = [(name, Judgement(NOT_JUDGED, [], [], why))]
            text_of_row = as_csv(not_judged, self._finder.figures, self._finder.subject)
            [row] = csv.DictReader(io.StringIO(text_of_row))
        student = self._roster.get(name_in(self._roster, submission), "")
        student_cell = {"student": student} if self._roster else {}
        row = {**student_cell, **row, self._finder.subject: name}
        page = stem + ".html"
        drawn = [file for file in self._files[name] if file == picture]
        self._put(page, as_page_of_student(row, self._finder.subject, text, drawn))
        self._files[name].insert(0, page)
        return row

    def _new_stem(self, name: str) -> str:
        """Return a unique name for the files of a submission."""
        first = re.sub(r"[^\w.-]", "_", name)
        numbered = (f"{first}-{number}" for number in itertools.count(2))
        stem = next(one for one in itertools.chain([first], numbered) if one not in self._stems)
        self._stems.add(stem)
        return stem

    def _write(self) -> None:
        text = io.StringIO()
        writer = csv.DictWriter(text, list(self._rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in self._rows:
            names = {
                key: text_cell(row[key]) for key in ("student", self._finder.subject) if key in row
            }
            writer.writerow({**row, **names})
        self._put("class.csv", text.getvalue())
        self._put("class.html", as_html(self._rows, self._finder.subject, self._files))

    def _put(self, name: str, content: str) -> None:
        write_file(os.path.join(self._output, name), content)


def _needs_build(package: str) -> bool:
    try:
        with open(os.path.join(package, "CMakeLists.txt"), encoding="utf-8") as file:
            return _IS_BUILT.search(file.read()) is not None
    except (OSError, UnicodeDecodeError):
        return False


def build(package: str, scratch: str, siblings: Sequence[str] = ()) -> Tuple[str, List[str]]:
    """Build a package and its dependencies in a new workspace.

    :param package: folder of the package
    :param scratch: folder for the workspace
    :param siblings: folders of the packages that it needs
    :returns: path of the workspace, and notes
    :raises NothingToJudge: if the build fails
    """
    workspace = os.path.join(scratch, "workspace")
    os.makedirs(os.path.join(workspace, "src"))
    os.symlink(package, os.path.join(workspace, "src", "package"))
    for index, sibling in enumerate(siblings):
        os.symlink(sibling, os.path.join(workspace, "src", f"sibling{index}"))
    _add_messages([package, *siblings], os.path.join(workspace, "src"))
    environment = dict(os.environ, LC_ALL="C")  # errors are found by their English text
    languages = environment.get("ROS_LANG_DISABLE", "").split(os.pathsep)
    environment["ROS_LANG_DISABLE"] = os.pathsep.join({*languages} - {"gencpp", ""})
    command = ["catkin_make", "-C", workspace]
    text, status = run_bounded(command, _BUILD_S, environment)
    if status == 0:
        return workspace, []
    # Paths below the package, as the workspace of the build is removed.
    text = text.replace(os.path.join(workspace, "src", "package", ""), "")
    # Without add_dependencies in CMakeLists.txt, messages may be generated too late for a program.
    run_bounded([*command, "--make-args", "-k"], _BUILD_S, environment)
    if run_bounded(command, _BUILD_S, environment)[1] != 0:
        raise NothingToJudge(f"it does not build: {_first_error(text)}")
    return workspace, [f"it was built in a second attempt; in the first: {_first_error(text)}"]


def _add_messages(packages: Sequence[str], sources: str) -> None:
    """Add the course's messages to a workspace if its packages use but lack them.

    Built without C++, they have no headers.
    """
    texts = []
    files = ("CMakeLists.txt", "package.xml")
    for path in [os.path.join(package, name) for package in packages for name in files]:
        with contextlib.suppress(OSError, UnicodeDecodeError):
            with open(path, encoding="utf-8") as file:
                texts.append(file.read())
    text = "\n".join(texts)
    if "pid_control" not in text or re.search(r"<name>\s*pid_control\s*</name>", text):
        return
    target = os.path.join(sources, "pid_control")
    os.makedirs(target)
    messages = os.path.join(rospkg.RosPack().get_path("pid_control"), "msg")
    os.symlink(messages, os.path.join(target, "msg"))
    for name, content in (("package.xml", _MESSAGES_XML), ("CMakeLists.txt", _MESSAGES_CMAKE)):
        with open(os.path.join(target, name), "w", encoding="utf-8") as file:
            file.write(content)


def _first_error(text: str) -> str:
    """Return the first error line of a build's output, and the line after it."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    first = next((i for i, line in enumerate(lines) if _ERROR.search(line)), len(lines) - 1)
    return " ".join(lines[first : first + 2])[:300]


def run_bounded(command: List[str], longest: float, environment: Dict[str, str]) -> Tuple[str, int]:
    """Run a command with a time limit, after which its process group is ended.

    :param command: program and arguments
    :param longest: time limit [s]
    :param environment: environment variables
    :returns: output and exit status
    """
    process = subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    output: Optional[bytes] = None
    try:
        for number in (signal.SIGINT, signal.SIGKILL):
            try:
                output, _ = process.communicate(timeout=longest)
                break
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, number)
                longest = _BEYOND_S
        else:
            output, _ = process.communicate()
    finally:
        if output is None:  # interrupted: the command ends its own processes
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGINT)
            process.wait(_BEYOND_S)
    return (output or b"").decode(errors="replace"), process.returncode
