"""Tests of the publisher's data: one file, with which all others agree."""

import pathlib
import re
import shutil
from xml.etree import ElementTree

import pytest

from ci.packages import project

WORKSPACE = project.WORKSPACE
REAL = {
    "maintainer": "Some & Body",
    "email": "some@example.org",
    "security": "security@example.org",
    "website": "https://example.org/?a=1&b=2",
    "repository": "https://example.org/it.git",
    "bugtracker": "https://example.org/it/issues",
}


def test_each_file_agrees_with_it() -> None:
    written = list(project.written(WORKSPACE, project.read(WORKSPACE)))
    assert written
    for path, text in written:
        assert path.read_text("utf-8") == text, f"{path}: run python3 ci packages.project"


@pytest.mark.parametrize("manifest", sorted(WORKSPACE.glob("src/*/package.xml")), ids=str)
def test_each_package_names_all_of_it(manifest: pathlib.Path) -> None:
    told = project.read(WORKSPACE)
    root = ElementTree.parse(str(manifest)).getroot()
    urls = {element.get("type"): element.text for element in root.findall("url")}
    assert urls == {kind: told[kind] for kind in ("website", "repository", "bugtracker")}
    [maintainer] = root.findall("maintainer")
    assert (maintainer.text, maintainer.get("email")) == (told["maintainer"], told["email"])


def test_no_file_has_a_placeholder_of_its_own() -> None:
    known = {path for path, _ in project.written(WORKSPACE, project.read(WORKSPACE))}
    assert known
    for place in ("src", "docs", "packaging", "ci"):
        for path in (WORKSPACE / place).rglob("*"):
            written = path.suffix in (".xml", ".py", ".md") and "tests" not in path.parts
            if written and path not in known:
                assert "basic-comms.invalid" not in path.read_text("utf-8"), path


@pytest.fixture
def copy(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> pathlib.Path:
    """Return a workspace with these files only, and the owner's values in the first."""
    for path, _ in project.written(WORKSPACE, project.read(WORKSPACE)):
        target = tmp_path / path.relative_to(WORKSPACE)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(str(path), str(target))
    (tmp_path / "packaging").mkdir()
    lines = "".join(f"{key}: {value}\n" for key, value in REAL.items())
    (tmp_path / "packaging" / "project.yaml").write_text(lines)
    monkeypatch.setattr(project, "WORKSPACE", tmp_path)
    return tmp_path


def test_data_of_the_owner_is_written_everywhere(
    copy: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    project.main()
    assert "src/nodekit/package.xml: changed" in capsys.readouterr().out
    project.main()
    assert capsys.readouterr().out == ""
    for manifest in copy.rglob("package.xml"):
        root = ElementTree.parse(str(manifest)).getroot()
        assert root.findtext("maintainer") == REAL["maintainer"]
        urls = [element.text for element in root.findall("url")]
        expected = [REAL["website"], REAL["repository"], REAL["bugtracker"]]
        assert urls == (expected if manifest.parent.parent == copy / "src" else [])
    page = (copy / "SECURITY.md").read_text("utf-8")
    assert "\nReport it to security@example.org.\n\nOnly the latest" in page
    for path in copy.rglob("*.*"):
        if path.is_file():
            assert not re.search(r"basic-comms\.invalid|There is no such address", path.read_text())


def test_page_asks_the_owner_to_fill_in_missing_data() -> None:
    told = project.read(WORKSPACE)
    page = (WORKSPACE / "SECURITY.md").read_text("utf-8")
    assert f"\nReport it to {told['security']}.\n" in page
    missing = "security" in project.placeholders(told)
    assert ("the owner of this repository has to fill it in" in page) == missing


@pytest.mark.parametrize("line", ["website: ''", "website: 5", "web: https://example.org"])
def test_a_file_of_another_form_is_refused(copy: pathlib.Path, line: str) -> None:
    path = copy / "packaging" / "project.yaml"
    path.write_text(re.sub(r"^website:.*$", line, path.read_text(), flags=re.MULTILINE))
    with pytest.raises(ValueError, match="^packaging/project.yaml: "):
        project.read(copy)
