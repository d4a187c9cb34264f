"""The Arduino library that make_headers writes."""

import pathlib
import re
import subprocess

from header_command import LIBRARIES, command
import zipfile

HERE = pathlib.Path(__file__).resolve().parents[1]
SOURCES = HERE.parents[1]


def test_library_has_files_expected_by_arduino_ide(tmp_path: pathlib.Path) -> None:
    done = command("pid_control", "std_srvs", "--arduino", "--into", str(tmp_path))
    assert (done.returncode, done.stderr) == (0, "")
    library = tmp_path / "ros_messages"
    assert done.stdout == f"{library}: a library with 7 headers; #include <ros_messages.h>\n"
    lines = (library / "library.properties").read_text().splitlines()
    properties = dict(line.split("=", 1) for line in lines)
    assert properties["includes"] == "ros_messages.h" and properties["name"] == "ros_messages"
    assert properties["sentence"].startswith("Messages and services of pid_control, std_srvs for")
    assert properties["depends"] == "Rosserial Arduino Library (=0.7.8)"
    assert re.fullmatch(r"\d+\.\d+\.\d+", properties["version"])
    # The compiler of the IDE has the folder src alone, and each header finds the others from there.
    sketch = tmp_path / "sketch.cpp"
    sketch.write_text(
        "#include <ros_messages.h>\n"
        "std_srvs::Trigger::Request request; pid_control::motor_output output;\n"
    )
    includes = [f"-I{library / 'src'}", *LIBRARIES]
    subprocess.check_call(["g++", "-std=gnu++11", "-fsyntax-only", "-Wall", *includes, str(sketch)])


def test_zip_has_the_files_of_the_library(tmp_path: pathlib.Path) -> None:
    archive = tmp_path / "library.zip"
    done = command("std_srvs", "--arduino", "--into", str(archive))
    assert (done.returncode, done.stderr) == (0, "")
    command("std_srvs", "--arduino", "--into", str(tmp_path / "folder"))
    with zipfile.ZipFile(str(archive)) as opened:
        names = set(opened.namelist())
    headers = [name for name in names if name.endswith(".h") and "/src/ros_" not in name]
    told = f"{archive}: a library with {len(headers)} headers; #include <ros_messages.h>\n"
    assert done.stdout == told
    folder = tmp_path / "folder"
    files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert names == files and "ros_messages/library.properties" in names


def test_the_sketch_of_the_docs_is_right_with_them(tmp_path: pathlib.Path) -> None:
    command("pid_control", "--arduino", "--into", str(tmp_path))
    sketch = SOURCES.parent / "docs" / "examples" / "board" / "motor_board" / "motor_board.ino"
    compiler = ["g++", "-std=gnu++11", "-fsyntax-only", "-Wall", "-Werror"]
    includes = [*LIBRARIES, f"-I{tmp_path / 'ros_messages' / 'src'}"]
    subprocess.check_call([*compiler, *includes, "-x", "c++", str(sketch)])
