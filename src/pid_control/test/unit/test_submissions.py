"""Tests of the submissions in the folder of a class: folders, workspaces, archives, roster."""

import gzip
import io
import os
import pathlib
import tarfile
import zipfile
from typing import Dict, List, Tuple

import pytest

from pid_control.programs import archives
from pid_control.programs.archives import ArchiveError, is_archive, stem_of, unpack
from pid_control.programs.program_finder import ProgramFinder
from pid_control.programs.submissions import (
    RosterError,
    Submission,
    missing_in,
    name_in,
    needed_siblings,
    packages_in,
    read_roster,
    submissions_in,
)

PACKAGE = {"package.xml": "<package><name>x</name></package>", "scripts/controller.py": "pass\n"}


def fill(folder: pathlib.Path, files: Dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def make_zip(path: pathlib.Path, files: Dict[str, str]) -> pathlib.Path:
    with zipfile.ZipFile(str(path), "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def make_tar(path: pathlib.Path, files: Dict[str, str]) -> pathlib.Path:
    with tarfile.open(str(path), "w:gz") as archive:
        for name, text in files.items():
            member = tarfile.TarInfo(name)
            member.size = len(text)
            archive.addfile(member, io.BytesIO(text.encode()))
    return path


def found(tmp_path: pathlib.Path) -> List[Tuple[str, str]]:
    """Return name and reason of each submission in the folder class."""
    scratch = str(tmp_path / "scratch")
    submissions = submissions_in(
        str(tmp_path / "class"), ProgramFinder("controller.py", [], {}), scratch
    )
    for one in submissions:
        assert bool(one.package) != bool(one.why) and os.sep not in one.entry
        assert not one.package or os.path.isfile(os.path.join(one.package, "package.xml"))
    return [(one.name, one.why) for one in submissions]


def test_each_entry_of_a_class_has_a_submission(tmp_path: pathlib.Path) -> None:
    class_ = tmp_path / "class"
    fill(class_ / "anna", PACKAGE)
    fill(class_ / "ben" / "catkin_ws" / "src" / "repository" / "pid", PACKAGE)
    fill(class_ / "ben" / "catkin_ws" / "src" / "repository" / "msgs", {"package.xml": ""})
    fill(class_ / "ben" / "catkin_ws" / "devel" / "share" / "pid", PACKAGE)
    make_zip(class_ / "cleo.ZIP", {f"cleo-main/{name}": text for name, text in PACKAGE.items()})
    make_tar(class_ / "dora.tar.gz", PACKAGE)
    (class_ / "emil_123_assignsubmission").mkdir()
    make_zip(class_ / "emil_123_assignsubmission" / "work.zip", PACKAGE)
    make_zip(class_ / "emil_123_assignsubmission" / "x.zip", {"x/package.xml": ""})
    fill(class_, {"finn/controller.py": "", "gina/notes.txt": "", "hugo.pdf": "", ".hidden": ""})
    (class_ / "ida.zip").write_bytes(b"broken")
    lines = dict(found(tmp_path))
    assert {name for name, why in lines.items() if not why} == {
        "anna",
        "ben/catkin_ws/src/repository/pid",
        "cleo.ZIP/cleo-main",
        "dora.tar.gz",
        "emil_123_assignsubmission/work.zip",
        "emil_123_assignsubmission/x.zip/x",
    }
    assert {name: why for name, why in lines.items() if why} == {
        "finn": "it has no package.xml: not a ROS package; controller.py can be judged by its path",
        "gina": "it has no package.xml: not a ROS package",
        "hugo.pdf": "it is neither a folder nor an archive (zip, tar)",
        "ida.zip": "it cannot be unpacked: File is not a zip file",
    }


def test_workspace_with_a_compiled_controller_is_the_package_that_builds_it(
    tmp_path: pathlib.Path,
) -> None:
    sources = tmp_path / "class" / "anna" / "src"
    fill(sources / "messages", {"package.xml": ""})
    text = "add_executable(controller src/controller.cpp)\n"
    fill(sources / "pid", {"package.xml": "", "CMakeLists.txt": text})
    scratch = str(tmp_path / "scratch")
    [one] = submissions_in(str(tmp_path / "class"), ProgramFinder("controller", [], {}), scratch)
    assert (one.package, one.siblings) == (str(sources / "pid"), [str(sources / "messages")])
    assert one == (
        "anna/src/pid",
        "anna",
        str(sources / "pid"),
        "",
        [str(sources / "messages")],
        False,
    )
    # Of several controllers, each may need another.
    for name in ("pid", "pid2"):
        fill(sources / name, {"package.xml": "", "controller": ""})
    found = submissions_in(str(tmp_path / "class"), ProgramFinder("controller", [], {}), scratch)
    assert [one.siblings[-1] for one in found] == [str(sources / "pid2"), str(sources / "pid")]


def test_needed_siblings_are_those_that_a_package_depends_on(tmp_path: pathlib.Path) -> None:
    needs = {
        "pid": ("pid", "<depend>tools</depend><test_depend>broken</test_depend>"),
        "tools": ("tools", "<run_depend> messages </run_depend><exec_depend>pid</exec_depend>"),
        "messages": ("messages", "<build_depend>rospy</build_depend>"),
        "messages_old": ("messages", ""),
        "pid_old": ("pid", ""),
        "broken": ("broken", "<depend>messages</depend>"),
    }
    for folder, (name, elements) in needs.items():
        text = f"<package><name>{name}</name>{elements}</package>"
        fill(tmp_path / folder, {"package.xml": text})
    fill(tmp_path / "unreadable", {"package.xml": '<?xml version="1.0" encoding="no"?><package/>'})
    names = [*needs, "unreadable"]
    siblings = sorted(str(tmp_path / name) for name in names if name != "pid")
    found = needed_siblings(str(tmp_path / "pid"), siblings)
    assert found == [str(tmp_path / "messages"), str(tmp_path / "tools")]
    assert needed_siblings(str(tmp_path / "unreadable"), siblings) == []


@pytest.mark.parametrize(
    "files",
    [
        {"scripts/controller.py": "import rospy\nfrom messages.msg import set_point\n"},
        {"src/controller.cpp": '#include "messages/set_point.h"\n'},
        {"CMakeLists.txt": "find_package(catkin REQUIRED COMPONENTS\n  rospy messages)\n"},
    ],
)
def test_needed_siblings_include_those_that_a_package_uses_without_a_declaration(
    tmp_path: pathlib.Path, files: Dict[str, str]
) -> None:
    fill(tmp_path / "pid", {"package.xml": "<package><name>pid</name></package>", **files})
    for name in ("messages", "unrelated"):
        fill(tmp_path / name, {"package.xml": f"<package><name>{name}</name></package>"})
    siblings = [str(tmp_path / name) for name in ("messages", "unrelated")]
    assert needed_siblings(str(tmp_path / "pid"), siblings) == siblings[:1]


def test_a_class_that_is_a_package_is_its_only_submission(tmp_path: pathlib.Path) -> None:
    fill(tmp_path / "class", PACKAGE)
    assert found(tmp_path) == [(".", "")]


def test_built_files_and_deep_folders_of_an_entry_have_no_packages(tmp_path: pathlib.Path) -> None:
    class_ = tmp_path / "class"
    for name in ("build", "devel", "install", "logs", ".ros"):
        fill(class_ / "anna" / name / "x", PACKAGE)
    fill(class_ / "anna" / "1" / "2" / "3" / "4" / "five", PACKAGE)
    fill(class_ / "anna" / "1" / "2" / "3" / "4" / "5" / "six", PACKAGE)
    fill(class_ / "anna" / "off", {**PACKAGE, "CATKIN_IGNORE": ""})
    assert found(tmp_path) == [("anna/1/2/3/4/five", "")]
    assert packages_in(str(class_ / "anna" / "1")) == []
    assert packages_in(str(class_ / "anna" / "1"), 4) == [str(class_ / "anna/1/2/3/4/five")]


def test_entry_with_several_archives_is_named_by_each(tmp_path: pathlib.Path) -> None:
    class_ = tmp_path / "class"
    (class_ / "anna").mkdir(parents=True)
    for name in ("a", "b"):
        make_zip(class_ / "anna" / f"{name}.zip", {"pid/package.xml": "", "x/package.xml": name})
    (class_ / "anna" / "c.zip").write_text("")
    (class_ / "anna" / "d.txt").write_text("")
    finder, scratch = ProgramFinder("controller.py", [], {}), f"{tmp_path}/scratch"
    submissions = submissions_in(str(class_), finder, scratch)
    assert submissions == [
        ("anna/a.zip/pid", "anna", f"{scratch}/0-0/pid", "", [f"{scratch}/0-0/x"], False),
        ("anna/b.zip/pid", "anna", f"{scratch}/0-1/pid", "", [f"{scratch}/0-1/x"], False),
        ("anna/c.zip", "anna", "", "it cannot be unpacked: File is not a zip file", (), False),
    ]


@pytest.mark.parametrize("make", [make_zip, make_tar])
@pytest.mark.parametrize(
    "name", ["../evil", "/tmp/evil", "\\evil", "a/../../evil", "..\\evil", "C:\\evil"]
)
def test_unpack_path_that_leads_out_is_refused(
    tmp_path: pathlib.Path, make: object, name: str
) -> None:
    assert callable(make)
    archive = make(tmp_path / ("x.zip" if make is make_zip else "x.tar.gz"), {name: "evil"})
    with pytest.raises(ArchiveError) as error:
        unpack(str(archive), str(tmp_path / "target"))
    assert str(error.value) == f"a path leads out of it ({name})"
    assert sorted(os.listdir(str(tmp_path))) == [archive.name]


def test_unpack_leaves_links_out(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "x.tar"
    with tarfile.open(str(path), "w") as archive:
        for kind in (tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.FIFOTYPE):
            member = tarfile.TarInfo(f"link{kind!r}")
            member.type, member.linkname = kind, "/etc/passwd"
            archive.addfile(member)
        archive.addfile(tarfile.TarInfo("file"), io.BytesIO())
    with zipfile.ZipFile(str(tmp_path / "x.zip"), "w") as zipped:
        link = zipfile.ZipInfo("link")
        link.external_attr = 0o120777 << 16
        zipped.writestr(link, "/etc/passwd")
        zipped.writestr("file", "")
    for name in ("x.tar", "x.zip"):
        unpack(str(tmp_path / name), str(tmp_path / "target" / name))
        assert os.listdir(str(tmp_path / "target" / name)) == ["file"]


def test_unpack_keeps_programs_executable(tmp_path: pathlib.Path) -> None:
    with tarfile.open(str(tmp_path / "x.tar"), "w") as packed:
        for name, mode in (("program", 0o755), ("file", 0o444)):
            member = tarfile.TarInfo(name)
            member.mode = mode
            packed.addfile(member, io.BytesIO())
    with zipfile.ZipFile(str(tmp_path / "x.zip"), "w") as zipped:
        for name, mode in (("program", 0o100755), ("file", 0o100644)):
            info = zipfile.ZipInfo(name)
            info.external_attr = mode << 16
            zipped.writestr(info, "")
    # As of "tar c | gzip", whose header has no name.
    (tmp_path / "x.tar.gz").write_bytes(gzip.compress((tmp_path / "x.tar").read_bytes()))
    for archive in ("x.tar", "x.tar.gz", "x.zip"):
        target = tmp_path / f"unpacked {archive}"
        unpack(str(tmp_path / archive), str(target))
        modes = {path.name: path.stat().st_mode & 0o777 for path in target.iterdir()}
        assert modes == {"program": 0o711, "file": 0o600}


@pytest.mark.parametrize("ending", ["zip", "tar.xz"])
def test_class_with_a_damaged_archive_reports_it_and_judges_the_others(
    tmp_path: pathlib.Path, ending: str
) -> None:
    path = tmp_path / "class" / f"anna.{ending}"
    fill(tmp_path / "class" / "ben", PACKAGE)
    text = "".join(map(str, range(50000)))
    if ending == "zip":
        with zipfile.ZipFile(str(path), "w", zipfile.ZIP_DEFLATED) as zipped:
            zipped.writestr("numbers", text)
    else:
        with tarfile.open(str(path), f"w:{ending[-2:]}") as packed:
            member = tarfile.TarInfo("numbers")
            member.size = len(text)
            packed.addfile(member, io.BytesIO(text.encode()))
    damaged = bytearray(path.read_bytes())
    middle = len(damaged) // 2
    damaged[middle : middle + 200] = b"\xff" * 200
    path.write_bytes(bytes(damaged))
    (anna, why), ben = found(tmp_path)
    assert (anna, ben) == (path.name, ("ben", ""))
    assert why.startswith("it cannot be unpacked: ")


def test_unpack_damage_that_only_the_sum_shows_is_refused(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "x.tar.gz"
    with tarfile.open(str(path), "w:gz", compresslevel=0) as packed:
        member = tarfile.TarInfo("file")
        member.size = 4
        packed.addfile(member, io.BytesIO(b"text"))
    content = path.read_bytes()
    path.write_bytes(content.replace(b"text", b"tent"))
    with pytest.raises(ArchiveError, match="it cannot be unpacked: CRC check failed"):
        unpack(str(path), str(tmp_path / "target"))


def test_unpack_path_with_a_zero_byte_is_refused(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "x.tar"
    with tarfile.open(str(path), "w", format=tarfile.PAX_FORMAT) as packed:
        member = tarfile.TarInfo("file")
        member.pax_headers = {"path": "a\0b"}
        packed.addfile(member, io.BytesIO())
    with pytest.raises(ArchiveError, match="it cannot be unpacked: embedded null byte"):
        unpack(str(path), str(tmp_path / "target"))
    assert not (tmp_path / "target").exists()


@pytest.mark.parametrize("make", [make_zip, make_tar])
def test_unpack_name_with_a_colon_is_kept(tmp_path: pathlib.Path, make: object) -> None:
    assert callable(make)
    name, long = "notes 10:30.txt", "".join(map(str, range(30_000)))
    files = {name: "text", "./a//b\\c": "deep", "a/b/long": long}
    archive = make(tmp_path / ("x.zip" if make is make_zip else "x.tar.gz"), files)
    target = tmp_path / "target"
    unpack(str(archive), str(target))
    kept = {str(path.relative_to(target)): path for path in target.rglob("*") if path.is_file()}
    assert {path: kept[path].read_text() for path in kept} == {
        name: "text",
        "a/b/c": "deep",
        "a/b/long": long,
    }


def test_unpack_counts_members_that_are_not_files(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(archives, "_MOST", 3)
    make_zip(tmp_path / "x.zip", {f"{index}/": "" for index in range(4)})
    with tarfile.open(str(tmp_path / "x.tar"), "w") as packed:
        for index in range(4):
            member = tarfile.TarInfo(str(index))
            member.type, member.linkname = tarfile.SYMTYPE, "x"
            packed.addfile(member)
    for name in ("x.zip", "x.tar"):
        with pytest.raises(ArchiveError, match=r"^too many files \(more than 3\)$"):
            unpack(str(tmp_path / name), str(tmp_path / "target"))
    monkeypatch.setattr(archives, "_MOST", 4)
    for name in ("x.zip", "x.tar"):
        unpack(str(tmp_path / name), str(tmp_path / f"target of {name}"))
        assert os.listdir(str(tmp_path / f"target of {name}")) == []


@pytest.mark.parametrize("ending", ["tar", "tar.gz", "tar.bz2", "tar.xz"])
def test_unpack_large_header_is_refused(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", ending: str
) -> None:
    path = tmp_path / f"x.{ending}"
    with tarfile.open(str(path), "w:" + ending[4:], format=tarfile.PAX_FORMAT) as packed:
        packed.addfile(tarfile.TarInfo("small"), io.BytesIO())
    unpack(str(path), str(tmp_path / "small"))
    assert os.listdir(str(tmp_path / "small")) == ["small"]
    with tarfile.open(str(path), "w:" + ending[4:], format=tarfile.PAX_FORMAT) as packed:
        member = tarfile.TarInfo("file")
        member.pax_headers = {"comment": "0" * 200_000}
        packed.addfile(member, io.BytesIO())
    monkeypatch.setattr(archives, "_LARGEST", 100_000)
    with pytest.raises(ArchiveError, match="too large"):
        unpack(str(path), str(tmp_path / "target"))


def test_unpack_large_archives_are_refused(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    many = make_zip(tmp_path / "many.zip", {str(index): "" for index in range(4)})
    large = make_zip(tmp_path / "large.zip", {"a": "0" * 3000, "b": "0" * 3000})
    assert (archives._MOST, archives._LARGEST) == (10_000, 200_000_000)
    monkeypatch.setattr(archives, "_MOST", 3)
    monkeypatch.setattr(archives, "_LARGEST", 5999)
    with pytest.raises(ArchiveError, match="too many files"):
        unpack(str(many), str(tmp_path / "target"))
    with pytest.raises(ArchiveError, match=r"^too large \(more than 0 MB\)$"):
        unpack(str(large), str(tmp_path / "target"))
    assert not (tmp_path / "target").exists()
    monkeypatch.setattr(archives, "_LARGEST", 6000)
    unpack(str(large), str(tmp_path / "target"))


def test_stem_of_removes_the_ending_of_archives_only(tmp_path: pathlib.Path) -> None:
    endings = "zip ZIP tar tar.gz TAR.GZ tgz tar.bz2 tbz2 tar.xz txz"
    names = [f"a.{ending}" for ending in endings.split()]
    assert {stem_of(name) for name in names} == {"a"}
    assert [stem_of(name) for name in ("a.b", "a", "tar.gz.b")] == ["a.b", "a", "tar.gz.b"]
    (tmp_path / "folder.zip").mkdir()
    (tmp_path / "a.txt").write_text("")
    (tmp_path / "a.zip").write_text("")
    found = [name for name in ("folder.zip", "a.txt", "a.zip") if is_archive(f"{tmp_path}/{name}")]
    assert found == ["a.zip"]


def test_roster_maps_folders_and_archives_to_students(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "roster.csv"
    path.write_text('\ufeff g1.zip , "Anna, B."\ng2,Ben\n\ng3.tar.gz,Cleo\n', encoding="utf-8")
    roster = read_roster(str(path))
    assert roster == {"g1": "Anna, B.", "g2": "Ben", "g3": "Cleo"}
    there = [Submission("g1.zip/x", "g1.zip", "/x"), Submission("g2", "g2", "/y")]
    missing = missing_in(there, roster)
    assert missing == [("g3", "g3", "", "nothing handed in", (), False)]


def test_roster_names_the_student_of_a_file_that_is_not_unpacked(tmp_path: pathlib.Path) -> None:
    fill(tmp_path / "class", {"anna.rar": "", "ben.v2/x": "", "cleo.pdf": ""})
    finder = ProgramFinder("controller.py", [], {})
    there = submissions_in(str(tmp_path / "class"), finder, str(tmp_path / "scratch"))
    roster = {"anna": "Anna", "ben": "Ben", "cleo.pdf": "Cleo"}
    assert [name_in(roster, one) for one in there] == ["anna", "", "cleo.pdf"]
    make_zip(tmp_path / "class" / "ben.v2" / "pid.zip", PACKAGE)
    there = submissions_in(str(tmp_path / "class"), finder, str(tmp_path / "again"))
    assert [one.entry for one in there] == ["anna.rar", "ben.v2", "cleo.pdf"]
    assert [one.entry for one in missing_in(there, roster)] == ["ben"]


@pytest.mark.parametrize(
    "heading, names",
    [
        ("Folder,Name", ["a"]),
        ("id, student,mark", ["a"]),
        ("Entry,Student name", ["a"]),
        ("archive,full name", ["a"]),
        ("Submission,Group", ["a"]),
        ("File,User", ["a"]),
        ("login,students", ["a"]),
        ("Username,Name", ["a"]),
        ("b,Name", ["b", "a"]),
    ],
)
def test_roster_heading_is_skipped(tmp_path: pathlib.Path, heading: str, names: List[str]) -> None:
    path = tmp_path / "roster.csv"
    path.write_text(f"{heading}\na,Anna\nfile,Group\n")
    assert list(read_roster(str(path))) == [*names, "file"]  # only at the top


@pytest.mark.parametrize(
    "text, says",
    [
        ("a\n", "^line 1: must be a folder or archive, and a student$"),
        ("a,A\n\n,B\n", "^line 3: must be a folder or archive, and a student$"),
        ("a,A\nb, \n", "^line 2: must be a folder or archive, and a student$"),
        ("a,Anna\na.zip,Ben\n", "line 2: a.zip appears twice"),
        ('"' + 200_000 * "x", r"it is not CSV: field larger than field limit \(131072\)"),
    ],
)
def test_roster_invalid_row_is_refused(tmp_path: pathlib.Path, text: str, says: str) -> None:
    path = tmp_path / "roster.csv"
    path.write_text(text)
    with pytest.raises(RosterError, match=says):
        read_roster(str(path))
