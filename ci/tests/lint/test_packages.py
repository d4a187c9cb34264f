"""Tests of each package's licence and README."""

import pathlib
import re
from typing import Dict
from xml.etree import ElementTree

import pytest

WORKSPACE = pathlib.Path(__file__).resolve().parents[3]
PACKAGES = {
    manifest.parent.name: manifest.parent for manifest in WORKSPACE.glob("src/*/package.xml")
}
#: Folders of the names that commands take after a package.
FOLDERS: Dict[str, str] = {"roslaunch": "launch", "rosrun": "scripts"}

each_package = pytest.mark.parametrize("name", sorted(PACKAGES))


def page(name: str) -> str:
    return (PACKAGES[name] / "README.md").read_text("utf-8")


@each_package
def test_each_carries_the_licence(name: str) -> None:
    manifest = ElementTree.parse(str(PACKAGES[name] / "package.xml"))
    [licence] = manifest.findall("license")
    assert (licence.text, licence.get("file")) == ("BSD-3-Clause", "LICENSE")
    own = PACKAGES[name] / "LICENSE"
    assert not own.is_symlink()
    assert own.read_bytes() == (WORKSPACE / "LICENSE").read_bytes()


@each_package
def test_page_begins_with_the_description_of_package_xml(name: str) -> None:
    title, text, *_ = page(name).split("\n\n")
    description = ElementTree.parse(str(PACKAGES[name] / "package.xml")).findtext("description")
    assert title == f"# {name}"
    assert text.split() == (description or "").split()


@each_package
def test_each_links_to_a_page_of_the_documentation(name: str) -> None:
    [link] = re.findall(r"\]\(([^)]*)\)", page(name))
    target = (PACKAGES[name] / link).resolve()
    assert target.is_file() and WORKSPACE / "docs" in target.parents


@each_package
def test_each_names_a_command_for_something_that_is_there(name: str) -> None:
    _, block, _ = page(name).split("\n```")
    kind, program, *words = block.split()
    assert kind == "sh"
    if program in FOLDERS:
        package, what = words[:2]
        file = PACKAGES[package] / FOLDERS[program] / what
    else:
        assert re.fullmatch(r"ros(msg|srv) show", " ".join([program, words[0]])), block
        package, what = words[1].split("/")
        kind = program[len("ros") :]
        file = PACKAGES[package] / kind / f"{what}.{kind}"
    assert package == name and file.is_file()


def test_files_named_by_the_conventions_page_exist() -> None:
    rows = (WORKSPACE / "docs" / "conventions.md").read_text("utf-8").splitlines()[6:]
    named = [re.findall(r"`([\w/.]+\.py)`", row) for row in rows]
    assert sum(map(bool, named)) >= 8
    for path in {path for row in named for path in row}:
        assert (WORKSPACE / path).is_file() or (WORKSPACE / "src" / path).is_file(), path
