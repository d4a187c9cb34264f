"""Tests of the Debian files generated from the package.xml files and the table."""

import pathlib
import re
import subprocess
from typing import List

import pytest

from ci.packages import debian_files

TABLE = """# a comment

catkin: | catkin
message_runtime: python3-genpy | ros-message-runtime
plots: | | python3-plots
rospy: python3-rospy  # another
launch/: python3-roslaunch
scripts/: rosbash
two_msgs: | | tools
"""
MANIFEST = """<package format="3"><name>{name}</name><version>1.2.3</version>
  <description>
    A {name}, to
    look at: and more.
  </description>
  <maintainer email="us@example.org">we</maintainer>
  <buildtool_depend>catkin</buildtool_depend>
  {depends}
</package>"""


@pytest.fixture
def tree(tmp_path: pathlib.Path) -> pathlib.Path:
    """Return a workspace of two packages, exported."""
    write(tmp_path, "one", ["<exec_depend> rospy </exec_depend>", "<depend>two_msgs</depend>"])
    write(tmp_path, "two_msgs", ["<exec_depend>message_runtime</exec_depend>"])
    (tmp_path / "src" / "one" / "launch").mkdir()
    (tmp_path / "packaging" / "debian").mkdir(parents=True)
    (tmp_path / "packaging" / "debian" / "rules").write_text("the rules")
    (tmp_path / "packaging" / "dependencies.txt").write_text(TABLE)
    return tmp_path


def write(root: pathlib.Path, name: str, depends: List[str]) -> None:
    folder = root / "src" / name
    folder.mkdir(parents=True, exist_ok=True)
    text = MANIFEST.format(name=name, depends="\n".join(depends))
    (folder / "package.xml").write_text(text)


def made(tree: pathlib.Path) -> List[str]:
    """Return the paragraphs of debian/control, and its changelog."""
    debian_files.make(tree, "trixie", "Sun, 22 Nov 2026 06:00:00 +0000")
    assert (tree / "debian" / "rules").read_text() == "the rules"
    control, changelog = (tree / "debian" / name for name in ("control", "changelog"))
    return control.read_text().split("\n\n") + [changelog.read_text()]


def faults(tree: pathlib.Path) -> List[str]:
    manifests = debian_files.read_manifests(tree / "src")
    return list(debian_files.faults(manifests, debian_files.read_table(TABLE)))


def values(paragraph: str, field: str) -> List[str]:
    """Return the values of a field with one value per line."""
    found = re.search(rf"^{field}:\n((?: .*\n?)*)", paragraph, re.MULTILINE)
    return [value.strip() for value in found.group(1).split(",")] if found else []


def test_each_catkin_package_is_a_debian_package_with_what_its_user_needs(
    tree: pathlib.Path,
) -> None:
    source, one, two, changelog = made(tree)
    always = ["${misc:Depends}", "${python3:Depends}"]
    assert one.startswith("Package: ros-one\n") and two.startswith("Package: ros-two-msgs\n")
    # The launch file needs roslaunch, which no package.xml declares; versions are equal.
    needed = ["python3-roslaunch", "python3-rospy", "ros-two-msgs (= ${binary:Version})"]
    assert values(one, "Depends") == always + needed
    assert values(two, "Depends") == always + ["python3-genpy"]
    assert (values(one, "Recommends"), values(two, "Recommends")) == ([], ["tools"])
    assert "Description: one, to look at\n A one, to look at: and more.\n .\n" in one
    assert "\nMaintainer: we <us@example.org>\n" in source
    assert changelog.startswith("ros-basic-comms (1.2.3+deb13) trixie; ")
    assert changelog.endswith("\n -- we <us@example.org>  Sun, 22 Nov 2026 06:00:00 +0000\n")


def test_description_equal_to_the_synopsis_is_not_repeated(tree: pathlib.Path) -> None:
    file = tree / "src" / "one" / "package.xml"
    file.write_text(
        file.read_text().replace("A one, to\n    look at: and more.", "One to look at.")
    )
    assert "\nDescription: one to look at\n This is the package one of ROS 1." in made(tree)[1]


def test_build_dependencies_include_exported_dependencies(tree: pathlib.Path) -> None:
    write(tree, "two_msgs", ["<build_export_depend>message_runtime</build_export_depend>"])
    write(tree, "one", ["<build_export_depend>two_msgs</build_export_depend>"])
    source, one, two, _ = made(tree)
    assert {"catkin", "ros-message-runtime"} <= set(values(source, "Build-Depends"))
    assert not {"python3-rospy", "rospy"} & set(values(source, "Build-Depends"))
    # Not to run it: that would install a compiler's headers for users of nodes.
    assert values(two, "Suggests") == ["ros-message-runtime"]
    assert "python3-genpy" not in values(two, "Depends")
    assert "ros-two-msgs (= ${binary:Version})" in values(one, "Depends")


def test_useful_packages_are_recommended_and_test_dependencies_left_out(
    tree: pathlib.Path,
) -> None:
    write(tree, "one", ["<exec_depend>plots</exec_depend>", "<test_depend>probe</test_depend>"])
    one = made(tree)[1]
    assert values(one, "Recommends") == ["python3-plots"]
    assert "probe" not in one and "python3-plots" not in values(one, "Depends")


def test_missing_and_superfluous_keys_are_reported(tree: pathlib.Path) -> None:
    (tree / "src" / "one" / "scripts").mkdir()
    plots = "<exec_depend>plots</exec_depend>"
    write(tree, "one", [plots, "<exec_depend>rospy</exec_depend>"])
    assert faults(tree) == []
    write(tree, "one", [plots, "<build_depend>unheard_of</build_depend>"])
    assert faults(tree) == [
        "src/one/package.xml: 'unheard_of' is not in packaging/dependencies.txt",
        "packaging/dependencies.txt: no package.xml names 'rospy'",
    ]


def test_packages_of_two_versions_are_reported(tree: pathlib.Path) -> None:
    (tree / "src" / "one" / "scripts").mkdir()
    write(tree, "one", ["<depend>rospy</depend>", "<depend>plots</depend>"])
    file = tree / "src" / "two_msgs" / "package.xml"
    file.write_text(file.read_text().replace("1.2.3", "1.2.4"))
    assert [fault.partition(":")[2] for fault in faults(tree)] == [
        " all must have the same version and the same maintainer"
    ]


@pytest.mark.parametrize("line", ["key", "key:", ": a", "a: b | c | d | e", "rospy: again"])
def test_a_line_of_another_form_is_refused(line: str) -> None:
    with pytest.raises(ValueError, match="must be 'key: run"):
        debian_files.read_table(f"{TABLE}{line}\n")


@pytest.mark.parametrize(
    "description, expected",
    [
        ("A plant. And more.", "plant"),
        ("The service: it is called.", "service"),
        ("ROS in a box", "ROS in a box"),
        ("What rclpy's Node gives, on 1.0", "what rclpy's Node gives, on 1.0"),
        ("Messages, " + "and more " * 9, "messages"),
        ("word " * 30, " ".join(["word"] * 16)),
    ],
)
def test_the_synopsis_is_the_beginning_of_the_description(description: str, expected: str) -> None:
    assert debian_files.synopsis(description) == expected


def test_the_workspaces_own_table_is_complete() -> None:
    assert list(debian_files.all_faults()) == []


def test_build_between_two_versions_has_a_version_between_them(tree: pathlib.Path) -> None:
    log = tree / "src" / "one" / "CHANGELOG.rst"
    log.write_text(
        "Forthcoming\n-----------\n* More.\n\n1.2.3 (2026-11-01)\n------\n* Forthcoming.\n"
    )
    debian_files.make(tree, "trixie", "Sun, 22 Nov 2026 06:00:00 +0000", "20261122.abc1234")
    changelog = (tree / "debian" / "changelog").read_text()
    assert changelog.startswith("ros-basic-comms (1.2.4~git20261122.abc1234+deb13) trixie; ")
    log.write_text("1.2.3 (2026-11-01)\n------\n* Forthcoming.\n")
    assert debian_files.is_release(tree)
    versions = ["1.2.3+deb12", "1.2.4~git20261122.abc1234+deb12", "1.2.4+deb12"]
    for older, newer in zip(versions, versions[1:]):
        subprocess.run(["dpkg", "--compare-versions", older, "lt", newer], check=True)
