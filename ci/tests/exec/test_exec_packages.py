"""ci/exec installs what is missing, says so, and refuses where it may or can not."""

import pytest
from conftest import Workspace

LISTED = """# a comment
[run ros]
catkin
[run]
one
two  # another
[test]
three
"""
BORROWED = """
[borrowed Ubuntu]
two pool/universe/two.deb bad
[borrowed Debian]
two pool/main/two.deb 5ec
"""


def test_installs_only_what_is_missing(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\none\n", known="two\n")
    workspace.fakes["env"] += "; cat"  # may not take the command's input
    result = workspace.run("cat", stdin="input\n")
    assert (result.stdout, result.returncode) == ("input\n", 0)
    commands = log.read_text().splitlines()
    assert len(commands) == 1, commands
    assert commands[0].startswith("apt-get install --yes --no-install-recommends ")
    assert commands[0].endswith(" two")
    assert "apt-get install --no-install-recommends two" in result.stderr
    assert workspace.run("true").stderr == ""


def test_updates_the_lists_if_a_package_is_not_in_them(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\n", known="one\n")
    (log.parent / "mirror").write_text("one\ntwo\n")
    assert workspace.run("true").returncode == 0
    commands = log.read_text().splitlines()
    assert commands[0] == "apt-get update"
    assert commands[1].endswith(" one two")


def test_says_what_the_system_does_not_have(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\n", known="one\n")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "has no package two:" in result.stderr
    assert log.read_text() == "apt-get update\n"


def test_borrows_from_a_later_release_what_this_one_lacks(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED + BORROWED, installed="catkin\n", known="one\n")
    result = workspace.run("true")
    assert result.returncode == 0
    update, download, install = log.read_text().splitlines()
    file = str(workspace.root / "build" / "ci-exec" / "two.deb")
    assert update == "apt-get update"
    url = "http://mirror/debian/pool/main/two.deb"
    assert download == "download-file %s %s SHA256:5ec" % (url, file)
    assert install.endswith(" one " + file)
    assert "has no two: taking that of a later release" in result.stderr


def test_borrows_nothing_that_the_system_has(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED + BORROWED, known="catkin\none\ntwo\n")
    assert workspace.run("true").returncode == 0
    (install,) = log.read_text().splitlines()
    assert install.endswith(" catkin one two")


def test_failed_download_is_shown(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED + BORROWED, installed="catkin\n", known="one\n")
    workspace.fakes["apt-helper"] = 'echo "E: Hash Sum mismatch"; false'
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "E: Hash Sum mismatch" in result.stderr
    assert "cannot download pool/main/two.deb" in result.stderr
    assert log.read_text() == "apt-get update\n"


def test_may_be_forbidden_to_install(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    result = workspace.run("echo", "not reached", CI_EXEC_NO_INSTALL="1")
    assert (result.stdout, result.returncode) == ("", 125)
    line = result.stderr.splitlines()[-1]
    assert line.replace("sudo ", "") == ("apt-get install --no-install-recommends catkin one two")
    assert log.read_text() == ""


def test_failed_installation_is_shown(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["env"] = 'echo "E: as the test wants it"; [ "${*: -1}" = update ]'
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "E: as the test wants it" in result.stderr


def test_names_what_is_to_be_borrowed_by_hand(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED + BORROWED, installed="catkin\n", known="one\n")
    result = workspace.run("echo", "not reached", CI_EXEC_NO_INSTALL="1")
    *_, hint, line = result.stderr.splitlines()
    assert hint.endswith(": http://mirror/debian/pool/main/two.deb")
    assert line.replace("sudo ", "") == "apt-get install --no-install-recommends one two"


@pytest.mark.parametrize("absent", ["apt-get", "dpkg-query"])
def test_refuses_a_system_without_apt_in_one_sentence(workspace: Workspace, absent: str) -> None:
    log = workspace.pretend_packages(LISTED)
    workspace.fakes["command"] = '[ "$2" != %s ] && builtin command "$@"' % absent
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert len(result.stderr.splitlines()) == 1
    assert "is not served" in result.stderr
    assert log.read_text() == ""


def test_takes_noetic_where_it_is(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="one\ntwo\n")
    noetic = workspace.root / "noetic"
    noetic.mkdir()
    (noetic / "setup.bash").write_text("export FAKE_NOETIC=sourced\n")
    setup = workspace.root / "ci" / "lib" / "setup.bash"
    setup.write_text(setup.read_text().replace("=/opt/ros/noetic\n", "='%s'\n" % noetic))
    workspace.fakes["catkin_make"] = 'mkdir -p devel; : > devel/setup.bash; echo "$FAKE_NOETIC"'
    result = workspace.run("true")
    assert result.returncode == 0
    # ROS's own packages are Noetic's part, and the build happens on top of it.
    assert log.read_text().splitlines()[0].endswith(" one two")
    assert "sourced" in (workspace.root / "build" / "ci-exec" / "log").read_text()
