"""Definitions are found even if Debian has them without a package.xml."""

import pathlib

import pytest
import rospkg

from ros2_bridge.types import definition_folders
from ros2_bridge.types.definition_folders import DefinitionFolders, package_folder


def test_definitions_without_a_package_are_found(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    monkeypatch.setattr(definition_folders, "SHARE", tmp_path)
    (tmp_path / "only_text_msgs" / "srv").mkdir(parents=True)
    (tmp_path / "no_definitions").mkdir()
    packages = rospkg.RosPack()
    assert package_folder(packages, "only_text_msgs") == tmp_path / "only_text_msgs"
    assert package_folder(packages, "no_definitions") is None
    # An existing package takes precedence.
    (tmp_path / "nodekit_msgs" / "srv").mkdir(parents=True)
    found = package_folder(packages, "nodekit_msgs")
    assert found == pathlib.Path(packages.get_path("nodekit_msgs"))


def test_messages_of_an_action_are_found_where_the_build_wrote_them(
    monkeypatch: "pytest.MonkeyPatch", tmp_path: pathlib.Path
) -> None:
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path}/devel::{tmp_path}/ros")
    packages = rospkg.RosPack()
    found = DefinitionFolders(packages)["nodekit_msgs"]
    assert found[0] == str(pathlib.Path(packages.get_path("nodekit_msgs")) / "msg")
    for workspace in ("devel", "ros"):
        assert str(tmp_path / workspace / "share" / "nodekit_msgs" / "msg") in found
    assert DefinitionFolders(packages)["no_such_msgs"] == []
