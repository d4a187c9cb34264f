"""Tests of the command new: a package, or an error. Course 002-pkg-17."""

import errno
import pathlib
from typing import Any, List

import pytest
import rospkg
from catkin_pkg.package import parse_package

from nodekit.commands import new

TEMPLATE = pathlib.Path(__file__).resolve().parents[2] / "template" / new.PLACEHOLDER


class Packages(rospkg.RosPack):
    """The only packages that there are."""

    def list(self) -> List[str]:
        return ["my_old_package"]

    def get_path(self, name: str) -> str:
        return "/somewhere/" + name


def test_new_package_has_the_given_name(tmp_path: pathlib.Path) -> None:
    made = new.make("first_robot", tmp_path, TEMPLATE)
    assert made == tmp_path / "first_robot"
    assert parse_package(str(made)).name == "first_robot"
    files = [path for path in made.rglob("*") if path.is_file()]
    assert len(files) == 10
    written = (made / "package.xml").stat().st_mode
    for path in files:
        text = path.read_text("utf-8")
        assert new.PLACEHOLDER not in f"{path}{text}"
        # Executable for all who may read it, and writable for its owner only.
        assert path.stat().st_mode == written | (0o111 if text.startswith("#!") else 0)
        if path.suffix == ".py" or path.parent.name == "scripts":
            compile(text, str(path), "exec")


@pytest.mark.parametrize("name", ["first_robot", "r2", "a_1", "my_older_package"])
def test_names_that_are_allowed(name: str) -> None:
    new.check_name(name, Packages())


@pytest.mark.parametrize(
    "name, why",
    [
        ("", "must be lowercase letters"),
        *((name, "must be lowercase letters") for name in ("a", "1a", "Robot", "my-robot", "a b")),
        *(
            (name, "must be lowercase letters")
            for name in ("a__b", "ab_", "_ab", "a/b", "ab\n", "ä1")
        ),
        *((name, "already used by Python") for name in ("class", "json", "sys", "yaml")),
        ("package_name", "already used by Python"),
        ("my_old_package", "already exists in /somewhere/my_old_package"),
    ],
)
def test_names_that_are_refused(name: str, why: str) -> None:
    with pytest.raises(new.NewPackageError) as caught:
        new.check_name(name, Packages())
    assert str(caught.value).startswith(f"package name '{name}': {why}")


def test_existing_files_are_kept(tmp_path: pathlib.Path) -> None:
    (tmp_path / "first_robot").mkdir()
    (tmp_path / "second_robot").write_text("mine")
    for name in ("first_robot", "second_robot"):
        with pytest.raises(new.NewPackageError, match=f"{name} cannot be created: File exists$"):
            new.make(name, tmp_path, TEMPLATE)
    assert list((tmp_path / "first_robot").iterdir()) == []
    assert (tmp_path / "second_robot").read_text() == "mine"


def test_missing_folder_is_not_created(tmp_path: pathlib.Path) -> None:
    with pytest.raises(new.NewPackageError, match="^there is no folder .*/none$"):
        new.make("first_robot", tmp_path / "none", TEMPLATE)
    assert list(tmp_path.iterdir()) == []


def test_a_package_within_a_package_is_refused(tmp_path: pathlib.Path) -> None:
    outer = new.make("first_robot", tmp_path, TEMPLATE)
    before = sorted(outer.rglob("*"))
    with pytest.raises(
        new.NewPackageError, match="is inside the package .*/first_robot, where catkin"
    ):
        new.make("second_robot", outer / "src", TEMPLATE)
    assert sorted(outer.rglob("*")) == before


def test_failed_write_leaves_nothing(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    written = []

    def write_text(path: pathlib.Path, *arguments: Any) -> None:
        if len(written) == 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        written.append(path)
        path.touch()

    monkeypatch.setattr(pathlib.Path, "write_text", write_text)
    with pytest.raises(new.NewPackageError, match="cannot be created: No space left on device$"):
        new.make("first_robot", tmp_path, TEMPLATE)
    assert len(written) == 3 and list(tmp_path.iterdir()) == []


def test_workspace_is_found_from_any_folder_in_it(tmp_path: pathlib.Path) -> None:
    with pytest.raises(new.NewPackageError, match="is not in a workspace"):
        new.source_folder(tmp_path)
    (tmp_path / "src").mkdir()
    package = new.make("first_robot", tmp_path / "src", TEMPLATE)
    for place in (tmp_path, tmp_path / "src", package, package / "src" / "first_robot"):
        assert new.source_folder(place) == tmp_path / "src", place


def test_a_refusal_is_one_sentence(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr("sys.argv", ["new", "Robot"])
    with pytest.raises(SystemExit) as caught:
        new.main()
    assert str(caught.value.code).startswith("new: package name 'Robot': must be")


@pytest.mark.parametrize("marked, command", [(True, "catkin build"), (False, "catkin_make")])
def test_advice_names_the_tool_that_builds_the_workspace(
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    marked: bool,
    command: str,
) -> None:
    (tmp_path / "src").mkdir()
    if marked:
        (tmp_path / ".catkin_tools").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["new", "first_robot"])
    new.main()
    assert f"next: build the workspace with {command}, source" in capsys.readouterr().out
