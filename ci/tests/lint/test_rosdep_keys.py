"""Tests of the lint of dependencies that rosdep cannot install."""

import pathlib

import pytest

from ci.lint import rosdep_keys

MANIFEST = """<package format="3"><name>one</name>
  <buildtool_depend condition="$ROS_PYTHON_VERSION == 3">%s</buildtool_depend>
  <depend>two</depend><exec_depend> known </exec_depend><group_depend>any</group_depend>
</package>"""


@pytest.mark.parametrize("key, sentences", [("known", 0), ("unknown", 1), ("", 1)])
def test_each_key_is_a_known_one_or_a_package_of_the_workspace(
    tmp_path: pathlib.Path, key: str, sentences: int
) -> None:
    for name in ("one", "two"):
        (tmp_path / "src" / name).mkdir(parents=True)
        (tmp_path / "src" / name / "package.xml").write_text("<package/>")
    (tmp_path / "src" / "one" / "package.xml").write_text(MANIFEST % key)
    (tmp_path / "keys").write_text("# a comment\n\nknown # another\n")
    found = list(rosdep_keys.unknown(tmp_path / "src", rosdep_keys.listed(tmp_path / "keys")))
    assert len(found) == sentences
    assert all(f"src/one/package.xml: buildtool_depend '{key}' is not a key" in s for s in found)


def test_the_workspaces_own_list_is_made_of_rules_with_a_debian_package(
    tmp_path: pathlib.Path,
) -> None:
    (tmp_path / "rules.yaml").write_text(
        """
        plain: {debian: [a], ubuntu: [b]}
        later: {debian: {bookworm: [a], buster: null}}
        apt: {debian: {apt: {packages: [a]}}}
        former: {debian: {buster: [a]}}
        pip: {debian: {pip: {packages: [a]}}}
        gone: {debian: {bookworm: null}}
        elsewhere: {ubuntu: [a]}
        python-old: {debian: [a]}
        """
    )
    # Packages of pip do not count: all dependencies are from Debian.
    assert rosdep_keys.keys_of([str(tmp_path / "rules.yaml")]) == ["apt", "later", "plain"]
